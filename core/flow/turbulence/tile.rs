//! A periodic tile of noise without long waves (Cook & DeRose 2005, Wavelet noise): white noise w less what half as many values an axis hold of
//! it, n = w - U R w, the coefficients of quadratic B-splines.
//!
//! R is the mean of 2^d, U the cubic resampling. The tile is scaled so that the curl of a potential made of it is 1 in the root mean square.

use super::means::halve;
use crate::exec::{Exec, RowBuffers, for_rows};
use crate::flow::resample::{Kind, resample};
use crate::flow::sample::floor;
use crate::grid::{Boundary, Grid, Side};
use crate::real::Real;
use crate::walk::Random;

/// Values along an axis.
pub const SIDE: usize = 64;
/// Fields that [`fill`] works in.
pub const FIELDS: usize = 4;
/// Inner products of quadratic B-splines that are 0, 1, 2 apart, of their slopes, times 120.
const VALUES: [f64; 3] = [66.0, 26.0, 1.0];
const SLOPES: [f64; 3] = [120.0, -40.0, -20.0];

/// The values of a tile.
#[must_use]
pub fn len(dims: usize) -> usize {
    grid(dims, SIDE).cells()
}

fn grid(dims: usize, side: usize) -> Grid {
    let (cells, ends) = ([side; 3], [Boundary::Periodic; 3]);
    Grid::in_cells(cells.get(..dims).unwrap_or(&[]), ends.get(..dims).unwrap_or(&[]))
}

/// Fills `tile` with the noise of `seed`. `work` has [`FIELDS`] fields of its length.
pub fn fill<T: Real>(exec: &dyn Exec, dims: usize, seed: u64, tile: &mut [T], work: [&mut [T]; FIELDS]) {
    let (whole, half) = (grid(dims, SIDE), grid(dims, SIDE / 2));
    let [means, back, first, second] = work;
    let mut random = Random::new(seed, 0, 0);
    tile.iter_mut().for_each(|x| *x = T::from_f64(random.normal()));
    halve(exec, [&whole, &half], tile, means);
    resample(
        exec,
        [&half, &whole],
        (Kind::Cells, 1.0),
        means,
        back,
        [&mut *first, &mut *second],
    );
    tile.iter_mut().zip(&*back).for_each(|(x, &back)| *x -= back);
    // The mean square of the slope of the spline along each axis.
    let mut square = 0.0;
    for axis in 0..dims {
        first.copy_from_slice(tile);
        for along in 0..dims {
            let taps = if along == axis { SLOPES } else { VALUES };
            filter(exec, &whole, along, taps.map(|tap| tap / 120.0), first, second);
            first.copy_from_slice(second);
        }
        let products = tile.iter().zip(&*first).map(|(x, y)| x.to_f64() * y.to_f64());
        square += products.sum::<f64>() / tile.len() as f64;
    }
    // In 3D each component of the curl is made of two slopes.
    let curl = square * (dims - 1) as f64;
    let scale = T::from_f64(1.0 / libm::sqrt(curl));
    tile.iter_mut().for_each(|x| *x = *x * scale);
}

/// `out` = a symmetric filter of five taps along an axis of rings, the middle one first.
fn filter<T: Real>(exec: &dyn Exec, grid: &Grid, axis: usize, taps: [f64; 3], from: &[T], out: &mut [T]) {
    let taps = taps.map(T::from_f64);
    let beside = |at: [usize; 3], side: Side| grid.beside(at, axis, side).unwrap_or(at);
    for_rows(exec, grid.rows(), RowBuffers::fields([out]), |task| {
        let [out] = task.fields;
        for (x, out) in out.iter_mut().enumerate() {
            let here = grid.cell_at(task.row, x);
            let value = |at: [usize; 3]| from.get(grid.index(at)).copied().unwrap_or(T::ZERO);
            let [low, high] = [Side::Low, Side::High].map(|side| beside(here, side));
            let (below, above) = (beside(low, Side::Low), beside(high, Side::High));
            *out = taps[0] * value(here)
                + taps[1] * (value(low) + value(high))
                + taps[2] * (value(below) + value(above));
        }
    });
}

/// Three values along an axis around a place, and their weights.
pub type Three = [(usize, f64); 3];

/// Those around place `x` of a tile that is moved by `shift` and, on a ring, begins again after `ring` values.
#[inline(always)]
#[must_use]
pub fn around(x: f64, ring: Option<usize>, shift: usize) -> Three {
    let middle = floor(x + 0.5);
    let d = x - middle as f64;
    let weights = [
        0.5 * (0.5 - d) * (0.5 - d),
        0.75 - d * d,
        0.5 * (0.5 + d) * (0.5 + d),
    ];
    let place = |i: isize| match ring {
        Some(ring) => i.rem_euclid(ring as isize) as usize,
        None => i as usize,
    };
    let at = |offset: isize| place(middle + offset).wrapping_add(shift) % SIDE;
    [(at(-1), weights[0]), (at(0), weights[1]), (at(1), weights[2])]
}

/// The value of the spline there; `z` is `None` in 2D.
#[inline(always)]
#[must_use]
pub fn value<T: Real>(tile: &[T], x: Three, y: Three, z: Option<Three>) -> f64 {
    let plane = |z: usize| {
        y.into_iter().fold(0.0, |sum, (y, weight)| {
            let start = (z * SIDE + y) * SIDE;
            let line = tile.get(start..start + SIDE).unwrap_or(&[]);
            let along = x.into_iter().fold(0.0, |sum, (x, weight)| {
                sum + weight * line.get(x).map_or(0.0, |value| value.to_f64())
            });
            sum + weight * along
        })
    };
    match z {
        None => plane(0),
        Some(z) => z
            .into_iter()
            .fold(0.0, |sum, (z, weight)| sum + weight * plane(z)),
    }
}
