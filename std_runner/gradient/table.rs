//! Taylor's table of a gradient, and what it says.

use serde_json::{Value, json};

/// The steps along the direction.
pub(crate) const STEPS: [f64; 5] = [1e-3, 1e-4, 1e-5, 1e-6, 1e-7];
/// What is judged are steps of at most this.
const SMALL: f64 = 1e-6;
/// What the difference quotient may be away from the derivative, whatever the order.
const EXACT: f64 = 1e-6;
/// A remainder of second order falls a hundredfold from step to step, one of first order tenfold: what is between both on a logarithmic scale.
const FALLS: f64 = 31.6;
/// Rounding errors of J, in parts of it.
const ROUNDING: f64 = 1e-13;

/// A line of the table.
#[derive(Clone, Copy, Debug)]
pub struct Row {
    /// t.
    pub step: f64,
    /// J(x + t d) - J(x).
    pub change: f64,
    /// That less t times the derivative.
    pub remainder: f64,
    /// The remainder in parts of t times the derivative.
    pub relative: f64,
}

/// Taylor's test along one direction.
#[derive(Clone, Debug)]
pub struct Table {
    /// J.
    pub value: f64,
    /// Its derivative along the direction by the adjoint.
    pub slope: f64,
    /// The part of it that each input has, by its name.
    pub parts: Vec<(&'static str, f64)>,
    /// The lines, largest step first.
    pub rows: Vec<Row>,
    /// What it ran in.
    pub kept: Kept,
}

/// The memory of a gradient.
#[derive(Clone, Copy, Debug)]
pub struct Kept {
    /// Bytes of the block.
    pub bytes: usize,
    /// States that are kept.
    pub slots: usize,
    /// Steps that the gradient repeats.
    pub repeated: usize,
}

impl Table {
    pub(crate) fn new(value: f64, parts: Vec<(&'static str, f64)>, kept: Kept) -> Self {
        Self {
            value,
            slope: parts.iter().map(|(_, part)| part).sum(),
            parts,
            rows: Vec::new(),
            kept,
        }
    }

    pub(crate) fn push(&mut self, step: f64, value: f64) {
        let change = value - self.value;
        let remainder = change - step * self.slope;
        self.rows.push(Row {
            step,
            change,
            remainder,
            relative: (remainder / (step * self.slope)).abs(),
        });
    }

    /// Whether the gradient is right: at one of the small steps at least the remainder has fallen as one of second order does, or is as small as
    /// rounding errors.
    pub fn is_exact(&self) -> bool {
        let small = |row: &Row| row.step <= SMALL;
        let falls = self.rows.windows(2).any(|pair| match pair {
            [before, row] => small(row) && before.remainder.abs() >= FALLS * row.remainder.abs(),
            _ => false,
        });
        let as_rounded = |row: &Row| {
            let rounding = ROUNDING * self.value.abs() / (row.step * self.slope).abs();
            row.relative <= EXACT.max(rounding.min(0.1))
        };
        self.slope.is_finite() && (falls || self.rows.iter().filter(|row| small(row)).any(as_rounded))
    }

    /// The table as JSON.
    pub fn fields(&self) -> Value {
        let row = |row: &Row| {
            json!({
                "step": row.step,
                "change": row.change,
                "remainder": row.remainder,
                "relative": row.relative,
            })
        };
        let parts = self.parts.iter();
        let parts = parts.map(|(name, part)| (name.replace(' ', "_"), json!(part)));
        json!({
            "exact": self.is_exact(),
            "value": self.value,
            "derivative": self.slope,
            "parts": Value::Object(parts.collect()),
            "rows": self.rows.iter().map(row).collect::<Vec<_>>(),
            "bytes": self.kept.bytes,
            "slots": self.kept.slots,
            "repeated_steps": self.kept.repeated,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table(slope: f64) -> Table {
        let kept = Kept {
            bytes: 0,
            slots: 1,
            repeated: 0,
        };
        let mut table = Table::new(1.0, vec![("all", slope)], kept);
        // J(t) = 1 + 2 t + 3 t^2.
        STEPS
            .iter()
            .for_each(|&t| table.push(t, 1.0 + 2.0 * t + 3.0 * t * t));
        table
    }

    #[test]
    fn a_wrong_derivative_is_told_from_a_right_one() {
        assert!(table(2.0).is_exact());
        assert!(!table(2.00002).is_exact() && !table(-2.0).is_exact() && !table(0.0).is_exact());
        assert!(!table(f64::NAN).is_exact());
    }
}
