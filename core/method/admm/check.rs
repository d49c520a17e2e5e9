//! The stop (mathematics section 5).

use super::Admm;
use super::alternate::Projected;
use super::report::Course;
use crate::exec::Exec;
use crate::field::{sums, view};
use crate::grid::Space;
use crate::memory::Pool;
use crate::objective::script::Script;
use crate::objective::sweep::{DensitySweep, densities};
use crate::observe::Observer;
use crate::progress::{Objective, Status};
use crate::real::Real;
use crate::transport::{Flow, Stop};

/// Smallest blending step with which a small change of rho is convergence and not exhaustion, unless there is nothing to blend.
const TRUSTED_STEP: f64 = 1.0 / 8.0;
/// max |v - v*| over max |v| at convergence.
const GAP: f64 = 0.01;
/// How far, relatively, the data terms of v and v* may differ at convergence.
const AGREEMENT: f64 = 0.05;
/// Outer iterations in a row that may end with a small change of rho but without agreement before the solve has stalled.
const PATIENCE: usize = 3;

impl<T: Real, S: Space> Admm<'_, T, S> {
    /// How an iteration with this objective of v ends the solve, if it does.
    pub(super) fn check(&mut self, objective: Objective, course: &Course) -> Result<(), Status> {
        let agree = (objective.data - course.data_of_star).abs() <= AGREEMENT * course.data_of_star;
        let still = self.iteration > 1 && course.density_change < self.setup.params.density_tolerance;
        let trusted = course.ao_step >= TRUSTED_STEP || course.ao_residuals.last() == Some(&0.0);
        if still && trusted && course.gap <= GAP && agree {
            return Err(Status::Converged);
        }
        self.history.still = if still { self.history.still + 1 } else { 0 };
        if self.history.still >= PATIENCE {
            Err(Status::Stalled)
        } else if self.iteration >= self.setup.iterations {
            Err(Status::MaxIterations)
        } else {
            Ok(())
        }
    }

    /// Data term of what v carries, force term of w, which with buoyancy becomes the force among these densities.
    pub(super) fn objective(
        &mut self,
        exec: &dyn Exec,
        observer: &mut dyn Observer,
        script: &Script<'_, T>,
    ) -> Result<Objective, Status> {
        let data = self.data(exec, observer, script)?;
        if self.setup.ao.flow.lifts() && data.is_finite() {
            self.exchange_lift(exec, observer)?;
        }
        let force = self.force_term(exec);
        Ok(Objective { data, ..force })
    }

    /// w, the force among the densities that v* carries, becomes that among those that v carries, with which the region begins.
    fn exchange_lift(&mut self, exec: &dyn Exec, observer: &mut dyn Observer) -> Result<(), Status> {
        let lift = self.setup.ao.flow.lift(&self.animation.levels);
        lift.add(exec, 1.0, self.animation.rho, 0..lift.slots, &mut self.w);
        lift.add(exec, -1.0, self.region, 0..lift.slots, &mut self.w);
        self.project(exec, observer, Projected::Force)
    }

    /// Data term of what v carries; the region then begins with the densities of v. A flow too fast to transport counts as infinitely bad.
    pub(crate) fn data(
        &mut self,
        exec: &dyn Exec,
        observer: &mut dyn Observer,
        script: &Script<'_, T>,
    ) -> Result<f64, Status> {
        let (grid, slots) = (&self.animation.levels.finest, self.slots());
        let mut pool = Pool::new(&mut *self.region);
        let rho = pool.take("densities of v", densities(grid, slots));
        let mut sweep = DensitySweep::carve(&self.animation.levels, 0, &self.setup.ao.flow.sweep, &mut pool);
        rho[..grid.cells()].copy_from_slice(&self.animation.rho[..grid.cells()]);
        let flow = Flow {
            initial: view(&self.animation.initial),
            v: view(&self.animation.v),
            along: None,
        };
        let data = match sweep.carry(exec, observer, &flow, rho, script, self.animation.sums) {
            Ok(data) => data,
            Err(Stop::Cancelled) => return Err(Status::Cancelled),
            Err(Stop::TooFast) => f64::INFINITY,
        };
        Ok(data)
    }

    /// The force term of w.
    pub(super) fn force_term(&mut self, exec: &dyn Exec) -> Objective {
        let (grid, slots) = (&self.animation.levels.finest, self.slots());
        let force = 0.5
            * self.setup.ao.flow.force_weight
            * sums::sum_squares(exec, grid, slots, view(&self.w), self.animation.sums);
        Objective::of_force(force, force)
    }
}
