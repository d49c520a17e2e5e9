//! Algebra of trajectories of faces: inner product, sum and scaling over all components, rows and time levels.

use super::{Vector, VectorMut, reborrow, rows, sums};
use crate::exec::{Exec, RowBuffers, for_rows};
use crate::grid::Grid;
use crate::real::Real;

/// Where the trajectories live.
#[derive(Clone, Copy, Debug)]
pub struct Shape<'g> {
    /// The grid.
    pub grid: &'g Grid,
    /// Slots of a trajectory.
    pub slots: usize,
}

/// <x, y> over all faces and slots.
pub fn dot<T: Real>(
    exec: &dyn Exec,
    shape: Shape<'_>,
    x: Vector<'_, T>,
    y: Vector<'_, T>,
    sums: &mut [f64],
) -> f64 {
    let Shape { grid, slots } = shape;
    sums::total(exec, grid, sums, |row| {
        (0..grid.dims)
            .map(|a| {
                rows::dot(
                    sums::row(grid, slots, x[a], row),
                    sums::row(grid, slots, y[a], row),
                )
            })
            .sum()
    })
}

/// <x, y> over all faces and the first `first` slots.
pub fn dot_of_first<T: Real>(
    exec: &dyn Exec,
    shape: Shape<'_>,
    first: usize,
    [x, y]: [Vector<'_, T>; 2],
    sums: &mut [f64],
) -> f64 {
    let Shape { grid, slots } = shape;
    let len = first.min(slots) * grid.n[0];
    sums::total(exec, grid, sums, |row| {
        let part = |field| rows::part(sums::row(grid, slots, field, row), 0..len);
        (0..grid.dims).map(|a| rows::dot(part(x[a]), part(y[a]))).sum()
    })
}

/// `out = s out + t x`; with s = 0 `out` may hold anything.
pub fn add<T: Real>(
    exec: &dyn Exec,
    shape: Shape<'_>,
    out: &mut VectorMut<'_, T>,
    s: f64,
    t: f64,
    x: Vector<'_, T>,
) {
    let Shape { grid, slots } = shape;
    let (own, other) = (T::from_f64(s), T::from_f64(t));
    for_rows(exec, grid.rows(), RowBuffers::fields(reborrow(out)), |task| {
        for (axis, out) in task.fields.into_iter().enumerate().take(grid.dims) {
            let x = sums::row(grid, slots, x[axis], task.row);
            if s == 0.0 {
                rows::scale(out, other, x);
            } else if s == 1.0 {
                rows::add_scaled(out, other, x);
            } else {
                rows::scale_in_place(out, own);
                rows::add_scaled(out, other, x);
            }
        }
    });
}

/// `out = s out`.
pub fn scale<T: Real>(exec: &dyn Exec, shape: Shape<'_>, out: &mut VectorMut<'_, T>, s: f64) {
    if s == 1.0 {
        return;
    }
    let grid = shape.grid;
    for_rows(exec, grid.rows(), RowBuffers::fields(reborrow(out)), |task| {
        task.fields
            .into_iter()
            .take(grid.dims)
            .for_each(|out| rows::scale_in_place(out, T::from_f64(s)));
    });
}

/// `out = s(k) out` in slot k.
pub fn scale_slots<T: Real>(
    exec: &dyn Exec,
    shape: Shape<'_>,
    out: &mut VectorMut<'_, T>,
    s: &(dyn Fn(usize) -> f64 + Sync),
) {
    let Shape { grid, slots } = shape;
    for slot in 0..slots {
        let (n, s) = (grid.n[0], T::from_f64(s(slot)));
        for_rows(exec, grid.rows(), RowBuffers::fields(reborrow(out)), |task| {
            for out in task.fields.into_iter().take(grid.dims) {
                rows::scale_in_place(&mut out[slot * n..][..n], s);
            }
        });
    }
}
