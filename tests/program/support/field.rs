//! Numbers on the cells or faces of a box, in the layout of the result files.

/// A 3D array, x fastest; in 2D the third size is 1.
#[derive(Clone, Debug, PartialEq)]
pub struct Field {
    pub size: [usize; 3],
    pub data: Vec<f64>,
}

impl Field {
    pub fn zeros(size: [usize; 3]) -> Self {
        Field {
            size,
            data: vec![0.0; size.iter().product()],
        }
    }

    fn offset(&self, at: [usize; 3]) -> usize {
        (at[2] * self.size[1] + at[1]) * self.size[0] + at[0]
    }

    pub fn at(&self, at: [usize; 3]) -> f64 {
        self.data[self.offset(at)]
    }

    pub fn add(&mut self, at: [usize; 3], value: f64) {
        let offset = self.offset(at);
        self.data[offset] += value;
    }

    pub fn max_abs(&self) -> f64 {
        self.data.iter().fold(0.0, |max: f64, value| {
            if value.is_nan() {
                f64::NAN
            } else {
                max.max(value.abs())
            }
        })
    }

    pub fn sum(&self) -> f64 {
        self.data.iter().sum()
    }

    pub fn sum_of_squares(&self) -> f64 {
        self.data.iter().map(|value| value * value).sum()
    }
}

/// Every index of an array of `size`.
pub fn indices(size: [usize; 3]) -> impl Iterator<Item = [usize; 3]> {
    let [nx, ny, nz] = size;
    (0..nz).flat_map(move |k| (0..ny).flat_map(move |j| (0..nx).map(move |i| [i, j, k])))
}

/// `at` with its index along `axis` replaced.
pub fn with(mut at: [usize; 3], axis: usize, index: usize) -> [usize; 3] {
    at[axis] = index;
    at
}
