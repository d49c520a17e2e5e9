//! The force that a flow needs, and its part of the objective.

use crate::exec::Exec;
use crate::field::{Vector, VectorMut, reborrow, rows, sums, view};
use crate::force;
use crate::grid::Space;
use crate::objective::flow::Evaluation;
use crate::observe::Observer;
use crate::operators::self_advection::Fluid;
use crate::real::Real;
use crate::transport::Stop;

impl<T: Real> Evaluation<'_, '_, T> {
    /// The force that produces v, and its part of the objective.
    ///
    /// # Errors
    /// [`Stop::Cancelled`].
    pub fn force<S: Space>(
        &mut self,
        exec: &dyn Exec,
        observer: &mut dyn Observer,
        v: Vector<'_, T>,
        w: &mut VectorMut<'_, T>,
    ) -> Result<f64, Stop> {
        self.acceleration::<S>(exec, v, w);
        self.projected(exec, observer, w)
    }

    /// What the force would be without a pressure.
    pub(super) fn acceleration<S: Space>(
        &mut self,
        exec: &dyn Exec,
        v: Vector<'_, T>,
        w: &mut VectorMut<'_, T>,
    ) {
        let (grid, slots) = (&self.levels.grids[self.level], self.setup.sweep.slots);
        let len = self.setup.sweep.threads * force::scratch_per_thread(grid, slots);
        let scratch = rows::part_mut(self.region, 0..len);
        force::from_velocity::<T, S>(
            exec,
            Fluid {
                grid,
                slots,
                viscosity: self.setup.viscosity,
            },
            v,
            self.initial,
            &[],
            reborrow(w),
            scratch,
        );
    }

    /// Projects a force; its part of the objective.
    ///
    /// # Errors
    /// [`Stop::Cancelled`].
    pub fn projected(
        &mut self,
        exec: &dyn Exec,
        observer: &mut dyn Observer,
        w: &mut VectorMut<'_, T>,
    ) -> Result<f64, Stop> {
        let (grid, slots) = (&self.levels.grids[self.level], self.setup.sweep.slots);
        self.project(exec, observer, w, self.setup.projection_tolerance)?;
        Ok(0.5 * self.setup.force_weight * sums::sum_squares(exec, grid, slots, view(w), self.sums))
    }
}
