//! The velocities of all steps, and how that of one step is taken out of them.

use crate::exec::{Exec, RowBuffers, for_rows};
use crate::field::{Vector, VectorMut, rows};
use crate::grid::{Grid, halo};
use crate::real::Real;
use crate::simd::{Cache, prefetch};

/// Rows between the one that is copied and the one that is prefetched.
pub const ROWS_AHEAD: usize = 4;

/// Velocities of all steps, perhaps moved along a direction: step 0 is v_0, step k slot k of the trajectories.
#[derive(Clone, Copy, Debug)]
pub struct Flow<'a, T> {
    /// v_0, a field of one slot.
    pub initial: Vector<'a, T>,
    /// v_1 .. v_{N-1}.
    pub v: Vector<'a, T>,
    /// A direction d and how far the flow goes along it: v + s d.
    pub along: Option<(Vector<'a, T>, T)>,
}

impl<T: Real> Flow<'_, T> {
    /// Copies the velocity of a step. The rows of the component along x receive halos.
    pub(super) fn copy_step(
        &self,
        exec: &dyn Exec,
        grid: &Grid,
        slots: usize,
        step: usize,
        out: VectorMut<'_, T>,
    ) {
        let n = grid.n[0];
        let buffers = RowBuffers::fields(out);
        for_rows(exec, grid.rows(), buffers, move |task| {
            for (axis, faces) in task.fields.into_iter().enumerate().take(grid.dims) {
                let inner = if axis == 0 {
                    halo::inner(faces, n)
                } else {
                    &mut *faces
                };
                self.copy_row(axis, slots, step, task.row, inner);
                self.prefetch_row(axis, slots, step, task.row + ROWS_AHEAD, n);
                if axis == 0 {
                    grid.axis(0).surround_faces(faces);
                }
            }
        });
    }

    /// Copies one component of the velocity of a step at a row of faces.
    #[inline]
    fn copy_row(&self, axis: usize, slots: usize, step: usize, row: usize, out: &mut [T]) {
        let n = out.len();
        let (from, place) = if step == 0 {
            (self.initial, row)
        } else {
            (self.v, row * slots + step - 1)
        };
        out.copy_from_slice(&from[axis][place * n..(place + 1) * n]);
        if let (Some((direction, s)), true) = (self.along, step > 0) {
            rows::add_scaled(out, s, &direction[axis][place * n..(place + 1) * n]);
        }
    }

    /// Prefetches what [`Self::copy_row`] will read: the rows of a step are far apart.
    #[inline]
    fn prefetch_row(&self, axis: usize, slots: usize, step: usize, row: usize, n: usize) {
        let Some(slot) = step.checked_sub(1) else { return };
        let direction = self.along.map(|(direction, _)| direction);
        for field in [Some(self.v), direction].into_iter().flatten() {
            prefetch(Cache::First, field[axis], (row * slots + slot) * n, n);
        }
    }
}
