//! A projection among solid cells that changes some of the flow less than the rest (Gregson 2015, eq. 5.21; mathematics section 11).

use super::batch::{Batch, Measured};
use super::conjugate::ease;
use super::{PASSES, Projection};
use crate::exec::{Exec, RowBuffers, for_rows};
use crate::field::{VectorMut, reborrow, view};
use crate::grid::{Grid, Side};
use crate::observe::Observer;
use crate::real::Real;
use core::ops::ControlFlow;

impl<T: Real> Projection<'_, T> {
    /// v becomes v + Delta without divergence and without flow through closed faces, where 1/2 sum over faces of |W Delta|^2 is least: Delta =
    /// -W^-2 grad p with div W^-2 grad p = div v. W > 0 at a face is the mean of its two cells of `importance`. The projection is one of a box with
    /// solid cells, of one slot. Tolerance, sums and result are those of [`Self::project`].
    pub fn project_weighted(
        &mut self,
        exec: &dyn Exec,
        observer: &mut dyn Observer,
        v: &mut VectorMut<'_, T>,
        importance: &[T],
        tolerance: f64,
        sums: &mut [f64],
    ) -> ControlFlow<(), f64> {
        let (grid, batch) = (self.grid, Batch::all(1, 1).next());
        let Some(batch) = batch else {
            return ControlFlow::Continue(0.0);
        };
        self.close(exec, v);
        let mut goal = None;
        for pass in 0.. {
            let Measured { divergence, speed } = self.solver.divergence(exec, batch, view(v), sums);
            let goal = *goal
                .get_or_insert_with(|| (tolerance * divergence).max(4.0 * T::EPSILON * speed / grid.h[0]));
            if pass == PASSES || !(divergence > goal) {
                return ControlFlow::Continue(divergence);
            }
            self.solver
                .solve(exec, observer, batch, 0.5 * goal, Some(importance))?;
            subtract(exec, grid, self.solver.potentials(), importance, v);
            self.close(exec, v);
        }
        ControlFlow::Continue(f64::NAN)
    }
}

/// v -= W^-2 grad q, 0 on walls.
fn subtract<T: Real>(exec: &dyn Exec, grid: &Grid, q: &[T], importance: &[T], v: &mut VectorMut<'_, T>) {
    for_rows(exec, grid.rows(), RowBuffers::fields(reborrow(v)), |task| {
        for (axis, faces) in task.fields.into_iter().enumerate().take(grid.dims) {
            let scale = T::from_f64(1.0 / grid.h[axis]);
            for (x, face) in faces.iter_mut().enumerate() {
                let here = grid.cell_at(task.row, x);
                let Some(low) = grid.beside(here, axis, Side::Low) else {
                    continue;
                };
                let of = |field: &[T], at: [usize; 3]| field.get(grid.index(at)).copied().unwrap_or(T::ONE);
                let slope = scale * (of(q, here) - of(q, low));
                *face -= ease(of(importance, low), of(importance, here)) * slope;
            }
        }
    });
}
