//! The data term's F and the operator of the normal equation, row by row, in cells and frames (h = 1).
//!
//! ```text
//! (F w)_cell    = sum over axes of (g_low w_low + g_high w_high) / 2,     g = G (phi_1 + phi_2*) / 2 at faces
//! (F^T r)_face  = g_face (r_low + r_here) / 2
//! (L w)_face    = sum over axes of 2 w - w_before - w_after:  0 on the walls across, mirrored along them
//! ```
//!
//! F w is minus the rate of `central` transport by a w without divergence. With the walls of this grid L = C^T C + D^T D.

use crate::exec::{Exec, RowBuffers, for_rows};
use crate::field::rows::part_mut;
use crate::field::{Block, Vector, VectorMut, reborrow};
use crate::grid::geometry::Beyond;
use crate::grid::solids::Solids;
use crate::grid::{Grid, Side};
use crate::operators::divergence::{add_divergence, add_gradient};
use crate::real::Real;
use crate::simd::multiversion;

/// Rows of scratch of a thread.
pub const SCRATCH_ROWS: usize = 3;

/// The scratch of so many threads, in elements.
#[must_use]
pub fn scratch_len(grid: &Grid, threads: usize) -> usize {
    threads * SCRATCH_ROWS * grid.n[0]
}

/// A field of one slot.
pub(super) fn alone(grid: &Grid) -> Block<'_> {
    Block {
        grid,
        slots: 1,
        first: 0,
        count: 1,
    }
}

/// `g` = G (a + b) / 2: a, b at cells, g at faces, 0 on walls.
pub fn gradient_of_mean<T: Real>(
    exec: &dyn Exec,
    grid: &Grid,
    [a, b]: [&[T]; 2],
    g: &mut VectorMut<'_, T>,
    scratch: &mut [T],
) {
    let (block, half) = (alone(grid), T::from_f64(0.5 * grid.h[0]));
    let buffers = RowBuffers::fields(reborrow(g)).with_scratch(scratch);
    for_rows(exec, grid.rows(), buffers, |task| {
        let shifted = part_mut(task.scratch, 0..grid.n[0]);
        for (axis, out) in task.fields.into_iter().enumerate().take(grid.dims) {
            out.fill(T::ZERO);
            add_gradient(&block, task.row, axis, half, a, out, shifted);
            add_gradient(&block, task.row, axis, half, b, out, shifted);
        }
    });
}

multiversion! {
    /// `out += s x y`.
    fn add_product[T: Real](out: &mut [T], s: T, x: &[T], y: &[T]) {
        for ((out, &x), &y) in out.iter_mut().zip(x).zip(y) {
            *out += s * (x * y);
        }
    }
}

/// `out = F w`, at cells.
pub fn apply<T: Real>(exec: &dyn Exec, grid: &Grid, g: Vector<'_, T>, w: Vector<'_, T>, out: &mut [T]) {
    let block = alone(grid);
    for_rows(exec, grid.rows(), RowBuffers::fields([out]), |task| {
        let [out] = task.fields;
        out.fill(T::ZERO);
        for axis in 0..grid.dims {
            let (own_g, own_w) = (block.of(g[axis], task.row), block.of(w[axis], task.row));
            add_product(out, T::HALF, own_g, own_w);
            if axis > 0 {
                if let Some(high) = grid.neighbour(task.row, axis, Side::High) {
                    add_product(out, T::HALF, block.of(g[axis], high), block.of(w[axis], high));
                }
                continue;
            }
            if let (Some((_, g)), Some((_, w))) = (own_g.split_first(), own_w.split_first()) {
                add_product(out, T::HALF, g, w);
            }
            // Behind the last cell is a wall, or the first face: g is 0 there on a wall.
            if let (Some(last), Some(&g), Some(&w)) = (out.last_mut(), own_g.first(), own_w.first()) {
                *last += T::HALF * (g * w);
            }
        }
    });
}

/// What [`combine`] weighs.
#[derive(Clone, Copy, Debug)]
pub struct Weights {
    /// Of F^T r.
    pub data: f64,
    /// Of L w.
    pub smooth: f64,
    /// Of w.
    pub kinetic: f64,
}

multiversion! {
    /// `out = s w + t g (r + low) / 2`, the scales being s and t.
    fn begin[T: Real](out: &mut [T], scales: [T; 2], w: &[T], g: &[T], r: &[T], low: &[T]) {
        let (s, half) = (scales[0], scales[1] * T::HALF);
        for ((((out, &w), &g), &r), &low) in out.iter_mut().zip(w).zip(g).zip(r).zip(low) {
            *out = s * w + half * (g * (r + low));
        }
    }
}

multiversion! {
    /// `out += s (2 w - low - high)`.
    fn add_second_difference[T: Real](out: &mut [T], s: T, w: &[T], low: &[T], high: &[T]) {
        for (((out, &w), &low), &high) in out.iter_mut().zip(w).zip(low).zip(high) {
            *out += s * ((w - low) + (w - high));
        }
    }
}

/// `out` = data F^T r + smooth L w + kinetic w at faces, 0 on walls; `r` at cells.
pub fn combine<T: Real>(
    exec: &dyn Exec,
    grid: &Grid,
    weights: Weights,
    (g, r): (Vector<'_, T>, &[T]),
    w: Vector<'_, T>,
    out: &mut VectorMut<'_, T>,
    scratch: &mut [T],
) {
    let (block, n) = (alone(grid), grid.n[0]);
    let [data, smooth, kinetic] =
        [weights.data, weights.smooth, weights.kinetic].map(|weight| T::from_f64(weight));
    let buffers = RowBuffers::fields(reborrow(out)).with_scratch(scratch);
    for_rows(exec, grid.rows(), buffers, |task| {
        let (before, rest) = task.scratch.split_at_mut(n);
        let (after, zero) = rest.split_at_mut(n);
        let zero = part_mut(zero, 0..n);
        zero.fill(T::ZERO);
        let row = task.row;
        let here = block.of(r, row);
        for (axis, out) in task.fields.into_iter().enumerate().take(grid.dims) {
            let own = block.of(w[axis], row);
            let low = block.beside((axis, Side::Low), Beyond::Own, r, row, before);
            begin(
                out,
                [kinetic, data],
                own,
                block.of(g[axis], row),
                here,
                low.unwrap_or(here),
            );
            if smooth == T::ZERO {
                continue;
            }
            for along in 0..grid.dims {
                let (beyond, outside) = if along == axis {
                    (Beyond::Zero, &*zero)
                } else {
                    (Beyond::Own, own)
                };
                let low = block.beside((along, Side::Low), beyond, w[axis], row, before);
                let high = block.beside((along, Side::High), beyond, w[axis], row, after);
                add_second_difference(out, smooth, own, low.unwrap_or(outside), high.unwrap_or(outside));
            }
            block.clear_closed(axis, row, out);
        }
    });
}

/// `out += gamma D^T D w` at faces, D in fluid cells; `cells` is work.
pub fn add_divergence_price<T: Real>(
    exec: &dyn Exec,
    grid: &Grid,
    solids: Solids<'_>,
    gamma: f64,
    w: Vector<'_, T>,
    out: &mut VectorMut<'_, T>,
    (cells, scratch): (&mut [T], &mut [T]),
) {
    let (block, n) = (alone(grid), grid.n[0]);
    let buffers = RowBuffers::fields([&mut *cells]).with_scratch(&mut *scratch);
    for_rows(exec, grid.rows(), buffers, |task| {
        let [cells] = task.fields;
        cells.fill(T::ZERO);
        add_divergence(&block, task.row, T::ONE, w, cells, part_mut(task.scratch, 0..n));
    });
    solids.clear_cells(n, cells);
    let (cells, scale) = (&*cells, T::from_f64(-gamma));
    let buffers = RowBuffers::fields(reborrow(out)).with_scratch(scratch);
    for_rows(exec, grid.rows(), buffers, |task| {
        let shifted = part_mut(task.scratch, 0..n);
        for (axis, out) in task.fields.into_iter().enumerate().take(grid.dims) {
            add_gradient(&block, task.row, axis, scale, cells, out, shifted);
        }
    });
}
