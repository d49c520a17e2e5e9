//! One outer iteration of ADMM: the three updates, what is taken back where a flow is not finite, and the end.

use super::Admm;
use super::report::Course;
use crate::exec::Exec;
use crate::field::slot::{RETREATS, pull_towards};
use crate::field::{trajectory, view};
use crate::grid::Space;
use crate::memory::Pool;
use crate::method::animation::Animation;
use crate::objective::script::Script;
use crate::observe::{Observer, Silent};
use crate::poisson::Projection;
use crate::progress::{Objective, Progress, Status};
use crate::real::Real;

impl<T: Real, S: Space> Admm<'_, T, S> {
    /// The three updates and the check.
    pub(super) fn alternate(
        &mut self,
        exec: &dyn Exec,
        observer: &mut dyn Observer,
        script: &Script<'_, T>,
        progress: &mut Progress,
        course: &mut Course,
    ) -> Result<(), Status> {
        let mut carried = self.update_density(exec, observer, script, course);
        // A flow from a coarser grid may be too fast for this one.
        for keep in RETREATS {
            if carried != Err(Status::NotFinite) {
                break;
            }
            self.retreat(exec, keep);
            carried = self.update_density(exec, observer, script, course);
        }
        carried?;
        let improved = self
            .update_velocity(exec, observer, course)
            .and_then(|()| self.objective(exec, observer, script))
            .and_then(finite);
        if improved == Err(Status::NotFinite) {
            self.return_to_star(exec);
        }
        progress.objective = improved?;
        self.update_multiplier(exec, course)?;
        self.check(progress.objective, course)
    }

    /// v = v*, the last flow that was carried to its end, in the place of one that is not finite or too fast; v = t where damping overwrote
    /// lambda / K.
    fn return_to_star(&mut self, exec: &dyn Exec) {
        let lost = self.history.damped && self.spare[0].is_empty();
        let Animation { levels, v, slots, .. } = &mut self.animation;
        let shape = trajectory::Shape {
            grid: &levels.finest,
            slots: *slots,
        };
        trajectory::add(exec, shape, v, 0.0, 1.0, view(&self.target));
        if !lost {
            trajectory::add(exec, shape, v, 1.0, 1.0, view(&self.multiplier));
        }
        self.p.fill(T::ZERO);
        self.pbar.fill(T::ZERO);
    }

    /// Takes the flow back towards v_0 in all time levels: `keep` of the way from there is left.
    pub(super) fn retreat(&mut self, exec: &dyn Exec, keep: f64) {
        let Animation {
            levels,
            v,
            initial,
            slots,
            ..
        } = &mut self.animation;
        pull_towards(exec, &levels.finest, view(initial), v, *slots, keep);
    }

    /// Projects v, takes w from it and transports rho_0 by it.
    pub(super) fn finish_as_is(
        &mut self,
        exec: &dyn Exec,
        script: &Script<'_, T>,
    ) -> Result<Objective, Status> {
        self.project(exec, &mut Silent, Projected::Flow)?;
        let data = self.data(exec, &mut Silent, script)?;
        if data.is_finite() {
            let rho = &mut self.animation.rho;
            rho.copy_from_slice(&self.region[..rho.len()]);
        }
        self.consistent_force(exec, &mut Silent)?;
        let force = self.force_term(exec);
        finite(Objective { data, ..force })
    }

    /// Projects v or w.
    pub(super) fn project(
        &mut self,
        exec: &dyn Exec,
        observer: &mut dyn Observer,
        which: Projected,
    ) -> Result<(), Status> {
        let (slots, threads) = (self.slots(), self.threads());
        let tolerance = self.setup.ao.flow.projection_tolerance;
        let Animation { levels, v, sums, .. } = &mut self.animation;
        let field = match which {
            Projected::Flow => v,
            Projected::Force => &mut self.w,
        };
        let mut pool = Pool::new(&mut *self.region);
        let projected = Projection::carve(levels, 0, slots, threads, &mut pool)
            .project(exec, observer, field, None, tolerance, sums);
        if projected.is_break() {
            Err(Status::Cancelled)
        } else {
            Ok(())
        }
    }
}

/// What is projected.
#[derive(Clone, Copy)]
pub(super) enum Projected {
    Flow,
    Force,
}

/// Refuses an objective that is not finite.
fn finite(objective: Objective) -> Result<Objective, Status> {
    if objective.total().is_finite() {
        Ok(objective)
    } else {
        Err(Status::NotFinite)
    }
}
