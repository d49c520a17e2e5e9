//! Richardson's iteration with Chebyshev's parameters: its steps and the residual that it follows.

use crate::field::Block;
use crate::grid::Side;
use crate::grid::geometry::Beyond;
use crate::real::Real;
use crate::simd::multiversion;

/// The degree of a Chebyshev polynomial that leaves at most `leave` of [lowest, 2]: the least power of two, but at least 2.
pub fn degree(lowest: f64, leave: f64) -> usize {
    let (mut value, mut degree) = ((2.0 + lowest) / (2.0 - lowest), 1);
    while degree < 2 || value * leave < 1.0 {
        (value, degree) = (2.0 * value * value - 1.0, 2 * degree);
    }
    degree
}

/// The root that step `step` takes, in the order of Lebedev & Finogenov (1971), which keeps the partial products small.
pub fn root(lowest: f64, degree: usize, step: usize) -> f64 {
    let (mut index, mut count) = (1, 1);
    for bit in (0..degree.ilog2()).rev() {
        count *= 2;
        if step >> bit & 1 == 1 {
            index = count + 1 - index;
        }
    }
    let angle = core::f64::consts::PI * (2 * index - 1) as f64 / (2 * degree) as f64;
    0.5 * (2.0 + lowest) + 0.5 * (2.0 - lowest) * libm::cos(angle)
}

/// `out = div grad q - rhs` at the cells of `row`; `shifts` is scratch for two rows.
pub fn residual_row<T: Real>(
    block: &Block<'_>,
    row: usize,
    q: &[T],
    rhs: &[T],
    out: &mut [T],
    shifts: &mut [T],
) {
    let grid = block.grid;
    let here = block.of(q, row);
    let (low, high) = shifts.split_at_mut(block.len());
    let high = &mut high[..block.len()];
    block.shift(Side::Low, Beyond::Own, here, low);
    block.shift(Side::High, Beyond::Own, here, high);
    let beside = |axis: usize, side: Side| {
        let row = if axis < grid.dims {
            block.beside((axis, side), Beyond::Own, q, row, &mut [])
        } else {
            None
        };
        row.unwrap_or(here)
    };
    let neighbours = [
        &*low,
        &*high,
        beside(1, Side::Low),
        beside(1, Side::High),
        beside(2, Side::Low),
        beside(2, Side::High),
    ];
    let weights = grid.h.map(|h| T::from_f64(1.0 / (h * h)));
    laplacian(out, here, block.of(rhs, row), neighbours, weights);
}

multiversion! {
    /// `out = div grad q - rhs`; `neighbours` are q on the low and the high side along x, y and z, `weights` 1 / h^2.
    fn laplacian[T: Real](out: &mut [T], q: &[T], rhs: &[T], neighbours: [&[T]; 6], weights: [T; 3]) {
        let n = out.len();
        let (q, rhs, [xl, xh, yl, yh, zl, zh]) = (&q[..n], &rhs[..n], neighbours.map(|row| &row[..n]));
        for i in 0..n {
            let two = q[i] + q[i];
            out[i] = weights[0] * (xl[i] + xh[i] - two) + weights[1] * (yl[i] + yh[i] - two) + weights[2] * (zl[i] + zh[i] - two) - rhs[i];
        }
    }
}
