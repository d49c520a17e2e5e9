//! Numbers on a grid finer than that of the smoke, and what they are between its points.

use rayon::prelude::*;

use super::camera::Vector;

/// One number for each cell of a box whose cells were cut `factor` times along every side.
pub(super) struct Volume {
    /// Along x, y and z.
    pub cells: [usize; 3],
    pub factor: usize,
    pub values: Vec<f32>,
}

/// The eight cells about a point and their weights.
pub(super) struct Corners {
    pub cells: [usize; 8],
    pub weights: [f32; 8],
}

impl Corners {
    /// The mean of `values`, one for each cell.
    #[inline]
    pub fn of<const N: usize>(&self, values: &[[f32; N]]) -> [f32; N] {
        let mut sum = [0.0; N];
        for (&cell, weight) in self.cells.iter().zip(self.weights) {
            for (sum, value) in sum.iter_mut().zip(values[cell]) {
                *sum += weight * value;
            }
        }
        sum
    }
}

impl Volume {
    /// `values` of a grid of `cells`, interpolated by monotone cubics along each axis: no value is outside of the range of its
    /// neighbours, so nothing becomes negative.
    pub fn refined(values: &[f32], cells: [usize; 3], factor: usize) -> Self {
        let (mut fine, mut values) = (cells, values.to_vec());
        for axis in (0..3).filter(|_| factor > 1) {
            values = cut(&values, fine, axis, factor);
            fine[axis] *= factor;
        }
        Self {
            cells: fine,
            factor,
            values,
        }
    }

    /// Means of blocks of `by` cells along each side.
    pub fn coarser(&self, by: usize) -> Self {
        let coarse = self.cells.map(|count| count / by);
        let [nx, ny, _] = coarse;
        let mut values = vec![0.0; coarse.iter().product()];
        let share = 1.0 / (by * by * by) as f32;
        values.par_chunks_mut(nx).enumerate().for_each(|(row, out)| {
            let (y, z) = (row % ny, row / ny);
            for line in 0..by * by {
                let (y, z) = (y * by + line % by, z * by + line / by);
                let line = &self.values[(z * self.cells[1] + y) * self.cells[0]..][..self.cells[0]];
                for (out, cells) in out.iter_mut().zip(line.chunks_exact(by)) {
                    *out += share * cells.iter().sum::<f32>();
                }
            }
        });
        Self {
            cells: coarse,
            factor: self.factor / by,
            values,
        }
    }

    /// The corners about a point, which is in cells of the smoke.
    #[inline]
    pub fn corners(&self, point: Vector) -> Corners {
        let mut low = [0; 3];
        let mut step = [0; 3];
        let mut part = [0.0; 3];
        let strides = [1, self.cells[0], self.cells[0] * self.cells[1]];
        for axis in 0..3 {
            let last = self.cells[axis] - 1;
            let place = (point[axis] * self.factor as f32 - 0.5).clamp(0.0, last as f32);
            let cell = place as usize;
            low[axis] = cell * strides[axis];
            step[axis] = if cell < last { strides[axis] } else { 0 };
            part[axis] = place - cell as f32;
        }
        let first = low[0] + low[1] + low[2];
        let [x, y, z] = part;
        let (ux, uy, uz) = (1.0 - x, 1.0 - y, 1.0 - z);
        let [dx, dy, dz] = step;
        Corners {
            cells: [0, dx, dy, dx + dy, dz, dx + dz, dy + dz, dx + dy + dz].map(|offset| first + offset),
            weights: [
                ux * uy * uz,
                x * uy * uz,
                ux * y * uz,
                x * y * uz,
                ux * uy * z,
                x * uy * z,
                ux * y * z,
                x * y * z,
            ],
        }
    }

    /// The value at a point, trilinear; beyond the outermost centres it is theirs.
    #[inline]
    pub fn at(&self, point: Vector) -> f32 {
        let corners = self.corners(point);
        let terms = corners.cells.iter().zip(corners.weights);
        terms.map(|(&cell, weight)| weight * self.values[cell]).sum()
    }

    /// Where the value grows, by differences of half a cell of the smoke.
    pub fn gradient(&self, point: Vector) -> Vector {
        core::array::from_fn(|axis| {
            let moved = |by: f32| {
                let mut point = point;
                point[axis] += by;
                self.at(point)
            };
            moved(0.5) - moved(-0.5)
        })
    }
}

/// Cuts the cells along one axis.
fn cut(values: &[f32], cells: [usize; 3], axis: usize, factor: usize) -> Vec<f32> {
    let mut fine = cells;
    fine[axis] *= factor;
    let mut cut = vec![0.0; fine.iter().product()];
    let taps: Vec<Taps> = (0..fine[axis])
        .map(|place| Taps::new(place, factor, cells[axis]))
        .collect();
    cut.par_chunks_mut(fine[0]).enumerate().for_each(|(row, out)| {
        let (y, z) = (row % fine[1], row / fine[1]);
        let source = |y: usize, z: usize| &values[(z * cells[1] + y) * cells[0]..][..cells[0]];
        let place = match axis {
            0 => {
                let source = source(y, z);
                for (out, taps) in out.iter_mut().zip(&taps) {
                    *out = monotone(taps.cells.map(|cell| source[cell]), taps.part);
                }
                return;
            }
            1 => y,
            _ => z,
        };
        let Taps { cells: near, part } = taps[place];
        let [a, b, c, d] = near.map(|near| {
            if axis == 1 {
                source(near, z)
            } else {
                source(y, near)
            }
        });
        for (x, out) in out.iter_mut().enumerate() {
            *out = monotone([a[x], b[x], c[x], d[x]], part);
        }
    });
    cut
}

/// The four cells about a finer one, and where it is between the middle two.
#[derive(Clone, Copy)]
struct Taps {
    cells: [usize; 4],
    part: f32,
}

impl Taps {
    fn new(place: usize, factor: usize, count: usize) -> Self {
        let place = (place as f32 + 0.5) / factor as f32 - 0.5;
        let low = place.floor();
        let near = |offset: i64| (low as i64 + offset).clamp(0, count as i64 - 1) as usize;
        Self {
            cells: [near(-1), near(0), near(1), near(2)],
            part: place - low,
        }
    }
}

/// Hermite's cubic between the middle two of four values; its slopes are limited as by van Leer (1977), so that it is monotone.
#[inline]
fn monotone([before, low, high, after]: [f32; 4], part: f32) -> f32 {
    let (left, rise, right) = (low - before, high - low, after - high);
    let (start, end) = (slope(left, rise), slope(rise, right));
    let (square, cube) = (part * part, part * part * part);
    low + rise * (3.0 * square - 2.0 * cube) + start * (cube - 2.0 * square + part) + end * (cube - square)
}

/// The mean of two differences, at most twice the smaller of them, 0 where they disagree.
#[inline]
fn slope(left: f32, right: f32) -> f32 {
    let least = left.abs().min(right.abs());
    let mean = 0.5 * (left + right);
    if left * right > 0.0 {
        mean.clamp(-2.0 * least, 2.0 * least)
    } else {
        0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_leaves_the_range_of_its_neighbours_and_lines_stay_lines() {
        let values: Vec<f32> = (0..5 * 4 * 3).map(|cell| ((cell * 37) % 11) as f32).collect();
        let fine = Volume::refined(&values, [5, 4, 3], 3);
        assert_eq!(fine.cells, [15, 12, 9]);
        assert!(fine.values.iter().all(|value| (0.0..=10.0).contains(value)));
        let line: Vec<f32> = (0..8).map(|cell| cell as f32).collect();
        let fine = Volume::refined(&line, [8, 1, 1], 2);
        assert!((fine.at([3.75, 0.5, 0.5]) - 3.25).abs() < 1e-5);
    }
}
