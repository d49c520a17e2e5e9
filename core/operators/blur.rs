//! The metric of the objective (paper eq. 5, mathematics section 4): C e = e + sum over j of G_j (G_j e); e itself may weigh less.
//!
//! G_j is a separable Gaussian of sigma = 2^(j-1) cells, taps cut at ceil(3 sigma) and normalised, mirrored at walls
//! (half-sample) and wrapped on periodic axes. Symmetric, so its own adjoint.

use crate::exec::{Exec, RowBuffers, for_rows};
use crate::field::rows;
use crate::grid::Grid;
use crate::real::Real;

/// Standard deviation of filter `j`, from 1, in cells.
fn sigma(j: usize) -> f64 {
    (1u64 << (j - 1)) as f64
}

/// Taps of filter `j` on one side of the centre.
fn radius(j: usize) -> usize {
    libm::ceil(3.0 * sigma(j)) as usize
}

/// Fields of cells that [`apply`] needs as work.
pub const WORK_FIELDS: usize = 2;

/// Numbers of scratch a thread needs: one row with its neighbours along x, and the taps, which all share.
#[must_use]
pub fn scratch_per_thread(grid: &Grid, filters: usize) -> usize {
    let radius = if filters == 0 { 0 } else { radius(filters) };
    grid.n[0] + 2 * radius + radius + 1
}

/// What a metric is made of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Metric {
    /// Filters m.
    pub filters: usize,
    /// Weight of e itself: 1 in the objective.
    pub identity: f64,
}

/// `out = C e`.
pub fn apply<T: Real>(exec: &dyn Exec, grid: &Grid, metric: Metric, e: &[T], out: &mut [T], work: [&mut [T]; WORK_FIELDS], scratch: &mut [T]) {
    rows::scale(out, T::from_f64(metric.identity), e);
    let [mut blurred, mut next] = work;
    for j in 1..=metric.filters {
        blurred.copy_from_slice(e);
        for _ in 0..2 {
            for axis in 0..grid.dims {
                along(exec, grid, axis, j, blurred, next, scratch);
                core::mem::swap(&mut blurred, &mut next);
            }
        }
        let blurred = &*blurred;
        let n = grid.n[0];
        for_rows(exec, grid.rows(), 0..grid.rows(), RowBuffers { fields: [&mut *out], sums: &mut [], scratch: &mut [] }, |task| {
            let [out] = task.fields;
            rows::add(out, &blurred[task.row * n..(task.row + 1) * n]);
        });
    }
}

/// One Gaussian along one axis.
fn along<T: Real>(exec: &dyn Exec, grid: &Grid, axis: usize, j: usize, from: &[T], to: &mut [T], scratch: &mut [T]) {
    let (n, radius) = (grid.n[0], radius(j) as isize);
    let weight = |offset: isize| libm::exp(-0.5 * (offset as f64 / sigma(j)) * (offset as f64 / sigma(j)));
    let total: f64 = (-radius..=radius).map(weight).sum();
    let (taps, scratch) = scratch.split_at_mut(radius as usize + 1);
    taps.iter_mut().zip(0..).for_each(|(tap, offset)| *tap = T::from_f64(weight(offset) / total));
    let tap = |offset: isize| taps[offset.unsigned_abs()];
    for_rows(exec, grid.rows(), 0..grid.rows(), RowBuffers { fields: [to], sums: &mut [], scratch }, |task| {
        let [out] = task.fields;
        out.fill(T::ZERO);
        let row = |row: usize| &from[row * n..(row + 1) * n];
        if axis == 0 {
            let here = row(task.row);
            let reach = n as isize + radius;
            for (at, slot) in (-radius..reach).zip(task.scratch.iter_mut()) {
                *slot = here[fold(at, n, grid.periodic[0])];
            }
            for offset in -radius..=radius {
                rows::add_scaled(out, tap(offset), &task.scratch[(offset + radius) as usize..][..n]);
            }
        } else {
            let at = grid.row_at(task.row);
            for offset in -radius..=radius {
                let mut source = at;
                source[axis - 1] = fold(at[axis - 1] as isize + offset, grid.n[axis], grid.periodic[axis]);
                rows::add_scaled(out, tap(offset), row(grid.row(source[0], source[1])));
            }
        }
    });
}

/// The cell that stands at place `i` of an axis of `n` cells: wrapped, or mirrored with the last cell repeated.
fn fold(i: isize, n: usize, periodic: bool) -> usize {
    let n = n as isize;
    if periodic {
        return i.rem_euclid(n) as usize;
    }
    let i = i.rem_euclid(2 * n);
    (if i >= n { 2 * n - 1 - i } else { i }) as usize
}
