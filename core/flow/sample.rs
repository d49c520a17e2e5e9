//! Values of fields between their places, in cells (h = 1): Catmull-Rom among cells, linear among faces.

use crate::field::Vector;
use crate::grid::{Axis, Grid};
use crate::real::Real;

/// Places farther from the box than this are as good as at this distance.
const FAR: f64 = 1e9;

/// The largest whole number that is at most `x`.
#[inline(always)]
#[must_use]
pub fn floor(x: f64) -> isize {
    let x = x.clamp(-FAR, FAR);
    let towards_zero = x as isize;
    towards_zero - isize::from((towards_zero as f64) > x)
}

/// The Catmull-Rom weights of the four samples around a place that is `t` beyond the second.
#[inline(always)]
#[must_use]
pub fn weights(t: f64) -> [f64; 4] {
    let (squared, cubed) = (t * t, t * t * t);
    [
        0.5 * (-t + 2.0 * squared - cubed),
        0.5 * (2.0 - 5.0 * squared + 3.0 * cubed),
        0.5 * (t + 4.0 * squared - 3.0 * cubed),
        0.5 * (cubed - squared),
    ]
}

/// The four cells around the place `x`, in cells from the low end of the axis, mirrored at walls, and their weights.
#[inline(always)]
#[must_use]
pub fn four(axis: Axis, x: f64) -> [(usize, f64); 4] {
    let x = x - 0.5;
    let i = floor(x);
    let weights = weights(x - i as f64);
    core::array::from_fn(|k| (axis.mirrored(i - 1 + k as isize), weights[k]))
}

/// Four cells along an axis and their weights.
#[derive(Clone, Copy)]
struct Four<T> {
    cells: [usize; 4],
    weights: [T; 4],
    /// Whether they lie side by side.
    together: bool,
}

impl<T: Real> Four<T> {
    /// Around the place `x`, in cells from the low end of the axis.
    #[inline(always)]
    fn new(axis: Axis, x: f64) -> Self {
        let x = x - 0.5;
        let i = floor(x);
        let first = i - 1;
        let together = first >= 0 && first + 4 <= axis.cells() as isize;
        let mut cells = [0; 4];
        for (cell, place) in cells.iter_mut().zip(first..) {
            *cell = if together {
                place as usize
            } else {
                axis.mirrored(place)
            };
        }
        let [a, b, c, d] = weights(x - i as f64);
        Self {
            cells,
            weights: [T::from_f64(a), T::from_f64(b), T::from_f64(c), T::from_f64(d)],
            together,
        }
    }

    /// The sum of four values, each with its weight.
    #[inline(always)]
    fn sum(&self, [a, b, c, d]: [T; 4]) -> T {
        let [w0, w1, w2, w3] = self.weights;
        (w0 * a + w1 * b) + (w2 * c + w3 * d)
    }

    /// The value at the place in the row of `field` that begins at `start`.
    #[inline(always)]
    fn in_row(&self, field: &[T], start: usize) -> T {
        let [a, b, c, d] = self.cells;
        if !self.together {
            return self.sum([
                at(field, start + a),
                at(field, start + b),
                at(field, start + c),
                at(field, start + d),
            ]);
        }
        match field.get(start + a..start + a + 4) {
            Some(&[a, b, c, d]) => self.sum([a, b, c, d]),
            _ => T::ZERO,
        }
    }
}

/// A value of a field; 0 where there is none.
#[inline(always)]
fn at<T: Real>(field: &[T], index: usize) -> T {
    field.get(index).copied().unwrap_or(T::ZERO)
}

/// Catmull-Rom interpolation of a field of cells at a place, mirrored at walls.
///
/// Here and below sums are written out: closures of this size over four values are called one by one.
#[inline(always)]
pub fn cubic<T: Real>(grid: &Grid, field: &[T], place: [f64; 3]) -> T {
    let [nx, ny, _] = grid.n;
    let x = Four::<T>::new(grid.axis(0), place[0]);
    let y = Four::<T>::new(grid.axis(1), place[1]);
    let [a, b, c, d] = y.cells;
    if grid.dims == 2 {
        return y.sum([
            x.in_row(field, a * nx),
            x.in_row(field, b * nx),
            x.in_row(field, c * nx),
            x.in_row(field, d * nx),
        ]);
    }
    let z = Four::<T>::new(grid.axis(2), place[2]);
    let mut planes = [T::ZERO; 4];
    for (plane, z) in planes.iter_mut().zip(z.cells) {
        let first = z * ny;
        *plane = y.sum([
            x.in_row(field, (first + a) * nx),
            x.in_row(field, (first + b) * nx),
            x.in_row(field, (first + c) * nx),
            x.in_row(field, (first + d) * nx),
        ]);
    }
    z.sum(planes)
}

/// Two samples along an axis, `None` where there stands 0, and the weight of the second.
#[derive(Clone, Copy)]
struct Two {
    places: [Option<usize>; 2],
    t: f64,
}

impl Two {
    /// Cells around `x`, or with `faces` faces, clamped to the outermost ones at walls.
    #[inline(always)]
    fn new(axis: Axis, x: f64, faces: bool) -> Self {
        let n = axis.cells();
        let x = if faces { x } else { x - 0.5 };
        if axis.is_ring() {
            let i = floor(x);
            return Self {
                places: [axis.cell(i), axis.cell(i + 1)],
                t: x - i as f64,
            };
        }
        let last = if faces { n } else { n - 1 };
        let x = x.max(0.0).min(last as f64);
        let i = (x as usize).min(last - 1);
        // Of the faces on a wall the first is stored, and is 0.
        let second = Some(i + 1).filter(|&second| second < n);
        Self {
            places: [Some(i), second],
            t: x - i as f64,
        }
    }
}

/// Linear interpolation of the component along `own` of a field of faces at a place, clamped to the outermost samples at walls.
#[inline(always)]
pub fn linear<T: Real>(grid: &Grid, field: &[T], own: usize, place: [f64; 3]) -> f64 {
    let x = Two::new(grid.axis(0), place[0], own == 0);
    let y = Two::new(grid.axis(1), place[1], own == 1);
    if grid.dims == 2 {
        return in_plane(grid, field, [x, y], 0);
    }
    let z = Two::new(grid.axis(2), place[2], own == 2);
    let a = z.places[0].map_or(0.0, |z| in_plane(grid, field, [x, y], z));
    let b = z.places[1].map_or(0.0, |z| in_plane(grid, field, [x, y], z));
    a + z.t * (b - a)
}

/// The value at a place in plane `z`.
#[inline(always)]
fn in_plane<T: Real>(grid: &Grid, field: &[T], [x, y]: [Two; 2], z: usize) -> f64 {
    let [nx, ny, _] = grid.n;
    let a = y.places[0].map_or(0.0, |row| in_row(field, x, (z * ny + row) * nx));
    let b = y.places[1].map_or(0.0, |row| in_row(field, x, (z * ny + row) * nx));
    a + y.t * (b - a)
}

/// The value at a place in the row that begins at `start`.
#[inline(always)]
fn in_row<T: Real>(field: &[T], x: Two, start: usize) -> f64 {
    let a = x.places[0].map_or(0.0, |cell| at(field, start + cell).to_f64());
    let b = x.places[1].map_or(0.0, |cell| at(field, start + cell).to_f64());
    a + x.t * (b - a)
}

/// The flow at a place.
#[inline(always)]
pub fn velocity<T: Real>(grid: &Grid, v: Vector<'_, T>, place: [f64; 3]) -> [f64; 3] {
    let (x, y) = (linear(grid, v[0], 0, place), linear(grid, v[1], 1, place));
    let z = if grid.dims == 3 {
        linear(grid, v[2], 2, place)
    } else {
        0.0
    };
    [x, y, z]
}

/// The smallest and the largest value of the 2^d cells around a place between the outermost centres.
#[inline(always)]
pub fn extremes<T: Real>(grid: &Grid, field: &[T], place: [f64; 3]) -> [T; 2] {
    let [nx, ny, _] = grid.n;
    let pair = |axis: usize| -> [usize; 2] {
        let (line, x) = (grid.axis(axis), place[axis] - 0.5);
        if line.is_ring() {
            let i = floor(x);
            return [line.nearest(i), line.nearest(i + 1)];
        }
        let i = (x.max(0.0) as usize).min(line.cells() - 2);
        [i, i + 1]
    };
    let (x, y) = (pair(0), pair(1));
    let z = if grid.dims == 3 { pair(2) } else { [0, 0] };
    let mut found: Option<[T; 2]> = None;
    for z in z.into_iter().take(grid.dims - 1) {
        for y in y {
            for x in x {
                let value = at(field, (z * ny + y) * nx + x);
                let [low, high] = found.unwrap_or([value; 2]);
                found = Some([
                    if value < low { value } else { low },
                    if value > high { value } else { high },
                ]);
            }
        }
    }
    found.unwrap_or([T::ZERO; 2])
}
