//! Single slots of trajectories, and fields of one slot.

use super::{Vector, VectorMut, reborrow, rows};
use crate::exec::{Exec, RowBuffers, for_rows};
use crate::grid::Grid;
use crate::real::Real;

/// One slot of a trajectory.
#[derive(Clone, Copy, Debug)]
pub struct Slot<'a, T> {
    /// The trajectory.
    pub field: Vector<'a, T>,
    /// Its slots.
    pub slots: usize,
    /// Which one, from 0.
    pub slot: usize,
}

impl<'a, T> Slot<'a, T> {
    /// A field that has but one slot.
    #[must_use]
    pub fn only(field: Vector<'a, T>) -> Self {
        Self {
            field,
            slots: 1,
            slot: 0,
        }
    }

    /// Slot `k` of a trajectory, counted from 1, or the field `initial` that stands before it for k = 0.
    #[must_use]
    pub fn at(k: usize, initial: Vector<'a, T>, field: Vector<'a, T>, slots: usize) -> Self {
        if k == 0 {
            Self::only(initial)
        } else {
            Self {
                field,
                slots,
                slot: k - 1,
            }
        }
    }

    /// Its row `row` of component `axis`.
    #[must_use]
    pub fn row(&self, grid: &Grid, axis: usize, row: usize) -> &'a [T] {
        let start = (row * self.slots + self.slot) * grid.n[0];
        &self.field[axis][start..start + grid.n[0]]
    }
}

/// `out` = the sum of `s x` over `terms`, of one slot.
pub fn combine<T: Real, const K: usize>(
    exec: &dyn Exec,
    grid: &Grid,
    terms: [(f64, Slot<'_, T>); K],
    out: &mut VectorMut<'_, T>,
) {
    for_rows(exec, grid.rows(), RowBuffers::fields(reborrow(out)), |task| {
        for (axis, out) in task.fields.into_iter().enumerate().take(grid.dims) {
            out.fill(T::ZERO);
            for (s, x) in &terms {
                rows::add_scaled(out, T::from_f64(*s), x.row(grid, axis, task.row));
            }
        }
    });
}

/// Writes `from`, of one slot, to slot `slot` of the trajectory `out`.
pub fn put<T: Real>(
    exec: &dyn Exec,
    grid: &Grid,
    from: Vector<'_, T>,
    out: &mut VectorMut<'_, T>,
    slot: usize,
) {
    let n = grid.n[0];
    for_rows(exec, grid.rows(), RowBuffers::fields(reborrow(out)), |task| {
        for (axis, out) in task.fields.into_iter().enumerate().take(grid.dims) {
            out[slot * n..(slot + 1) * n].copy_from_slice(&from[axis][task.row * n..(task.row + 1) * n]);
        }
    });
}

/// Sets slot `slot` of a trajectory to 0.
pub fn clear<T: Real>(exec: &dyn Exec, grid: &Grid, out: &mut VectorMut<'_, T>, slot: usize) {
    let n = grid.n[0];
    for_rows(exec, grid.rows(), RowBuffers::fields(reborrow(out)), |task| {
        for out in task.fields.into_iter().take(grid.dims) {
            out[slot * n..(slot + 1) * n].fill(T::ZERO);
        }
    });
}

/// What is left, each time, of a trajectory that is not finite: in all 1/2, 1/4, 1/16, 1/256, 2^-16, and at last nothing.
pub const RETREATS: [f64; 6] = [0.5, 0.5, 0.25, 0.0625, 0.00390625, 0.0];

/// Leaves `keep` of the way from `from`, of one slot, to every slot of the trajectory `out`: where that is 0, a copy in every slot.
pub fn pull_towards<T: Real>(
    exec: &dyn Exec,
    grid: &Grid,
    from: Vector<'_, T>,
    out: &mut VectorMut<'_, T>,
    slots: usize,
    keep: f64,
) {
    if keep == 0.0 {
        return put_everywhere(exec, grid, from, out, slots);
    }
    let n = grid.n[0];
    let (keep, rest) = (T::from_f64(keep), T::from_f64(1.0 - keep));
    for_rows(exec, grid.rows(), RowBuffers::fields(reborrow(out)), |task| {
        for (axis, out) in task.fields.into_iter().enumerate().take(grid.dims) {
            for slot in out.chunks_exact_mut(n) {
                rows::scale_in_place(slot, keep);
                rows::add_scaled(slot, rest, &from[axis][task.row * n..(task.row + 1) * n]);
            }
        }
    });
}

/// Writes `from`, of one slot, to all slots of the trajectory `out`.
pub fn put_everywhere<T: Real>(
    exec: &dyn Exec,
    grid: &Grid,
    from: Vector<'_, T>,
    out: &mut VectorMut<'_, T>,
    slots: usize,
) {
    (0..slots).for_each(|slot| put(exec, grid, from, out, slot));
}
