//! The residual of a step or of its adjoint, and the correction that Newton's method or GMRES takes from it.

use super::{Law, SURE, Step};
use crate::exec::Exec;
use crate::field::trajectory::add;
use crate::field::{VectorMut, reborrow, view};
use crate::grid::Space;
use crate::observe::Observer;
use crate::operators::self_advection;
use crate::poisson::Projection;
use crate::real::Real;
use crate::transport::Stop;

impl<T: Real> Step<'_, T> {
    /// residual = Q(given - Adv(v)) - v, or Q(given - J(v)^T z) - z.
    pub(super) fn residual<S: Space>(
        &mut self,
        exec: &dyn Exec,
        observer: &mut dyn Observer,
        law: Law,
        sums: &mut [f64],
    ) -> Result<(), Stop> {
        let (fluid, shape) = (self.fluid(), self.shape());
        let out = &mut self.residual;
        let x = match law {
            Law::Flow => {
                self_advection::apply::<T, S>(exec, fluid, view(&self.v), reborrow(out), self.scratch);
                view(&self.v)
            }
            Law::Adjoint => {
                self_advection::apply_adjoint::<T, S>(
                    exec,
                    fluid,
                    view(&self.v),
                    view(&self.adjoint),
                    reborrow(out),
                    self.scratch,
                );
                view(&self.adjoint)
            }
        };
        add(exec, shape, out, -1.0, 1.0, view(&self.given));
        project(
            &mut self.projection,
            exec,
            observer,
            out,
            SURE * self.setup.tolerance,
            sums,
        )?;
        add(exec, shape, out, 1.0, -1.0, x);
        Ok(())
    }

    /// correction = d with d + Q J(v) d, or d + Q J(v)^T d, nearer to the residual than `left`.
    pub(super) fn correct<S: Space>(
        &mut self,
        exec: &dyn Exec,
        observer: &mut dyn Observer,
        law: Law,
        left: f64,
        sums: &mut [f64],
    ) -> Result<(), Stop> {
        let (grid, fluid, shape) = (self.grid, self.fluid(), self.shape());
        let Self {
            projection,
            v,
            residual,
            correction,
            krylov,
            scratch,
            ..
        } = self;
        krylov.correct(
            exec,
            grid,
            view(residual),
            left,
            correction,
            sums,
            &mut |d, out, accuracy, sums| {
                match law {
                    Law::Flow => self_advection::apply_derivative::<T, S>(
                        exec,
                        fluid,
                        view(v),
                        d,
                        reborrow(out),
                        scratch,
                    ),
                    Law::Adjoint => {
                        self_advection::apply_adjoint::<T, S>(exec, fluid, view(v), d, reborrow(out), scratch)
                    }
                }
                project(projection, exec, observer, out, accuracy, sums)?;
                add(exec, shape, out, 1.0, 1.0, d);
                Ok(())
            },
        )
    }
}

/// Projects a field of one slot.
///
/// # Errors
/// [`Stop::Cancelled`].
pub fn project<T: Real>(
    projection: &mut Projection<'_, T>,
    exec: &dyn Exec,
    observer: &mut dyn Observer,
    field: &mut VectorMut<'_, T>,
    tolerance: f64,
    sums: &mut [f64],
) -> Result<(), Stop> {
    if projection
        .project(exec, observer, field, None, tolerance, sums)
        .is_break()
    {
        Err(Stop::Cancelled)
    } else {
        Ok(())
    }
}
