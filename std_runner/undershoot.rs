//! Values below 0 in a density that is given: what transport undershoots, or no density at all.
//!
//! Transport by QUICK or central differences undershoots beside steep edges, so that densities of a result are slightly negative here
//! and there. Such a density is an input like any other; its negative values become 0. Where the negative values sum to more than
//! [`MOST`] of the positive ones, the array holds something else than a density.

use thurible_core::Real;

/// The largest part of the positive values that the negative ones of a density may sum to. Results have up to 0.014.
pub const MOST: f64 = 0.05;

/// What of an array is below 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Undershoot {
    /// How many values.
    pub count: usize,
    /// The least value,
    pub least: f64,
    /// and its index.
    pub at: usize,
    /// The sum of the negative values as a part of that of the positive ones.
    pub part: f64,
}

impl Undershoot {
    /// What is below 0 in `values`, if anything is.
    pub fn of<T: Real>(values: &[T]) -> Option<Self> {
        let (mut below, mut above) = (0.0, 0.0);
        let mut found = Self {
            count: 0,
            least: 0.0,
            at: 0,
            part: 0.0,
        };
        for (index, value) in values.iter().map(|value| value.to_f64()).enumerate() {
            if value < 0.0 {
                found.count += 1;
                below -= value;
            } else {
                above += value;
            }
            if value < found.least {
                (found.least, found.at) = (value, index);
            }
        }
        found.part = below / above;
        (found.count > 0).then_some(found)
    }

    /// Whether the array is a density all the same.
    #[must_use]
    pub fn is_small(&self) -> bool {
        self.part <= MOST
    }

    /// What is said of a density whose negative values become 0, after its name.
    #[must_use]
    pub fn taken(&self) -> String {
        let (values, become_zero) = if self.count == 1 {
            ("value", "it becomes 0")
        } else {
            ("values", "they become 0")
        };
        format!(
            "holds {} {values} below 0, the least {:.3e}; {become_zero}",
            self.count, self.least
        )
    }

    /// What is found in an array of `shape` that is no density, and the remedy.
    #[must_use]
    pub fn refused(&self, shape: &[usize]) -> [String; 2] {
        [
            format!("holds {} at {}", self.least, place(self.at, shape)),
            format!(
                "a density is never negative, and this one is by more than {} % of what it holds: clip it by numpy.maximum(a, 0)",
                100.0 * MOST
            ),
        ]
    }
}

/// Sets what is below 0 to 0.
pub fn clip<T: Real>(values: &mut [T]) {
    for value in values {
        if *value < T::ZERO {
            *value = T::ZERO;
        }
    }
}

/// Where the value `index` of an array of `shape` stands, as NumPy writes it.
#[must_use]
pub fn place(index: usize, shape: &[usize]) -> String {
    let mut rest = index;
    let mut place: Vec<String> = Vec::new();
    for &count in shape.iter().rev() {
        place.insert(0, (rest % count.max(1)).to_string());
        rest /= count.max(1);
    }
    format!("[{}]", place.join(", "))
}
