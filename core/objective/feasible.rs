//! What makes flows feasible: projections of fields and directions, and the end of a solve (mathematics section 5).

use crate::exec::Exec;
use crate::field::slot::{RETREATS, pull_towards};
use crate::field::{VectorMut, view};
use crate::grid::Space;
use crate::memory::Pool;
use crate::objective::flow::Evaluation;
use crate::objective::sweep;
use crate::observe::{Observer, Silent};
use crate::poisson::Projection;
use crate::progress::{Objective, Status};
use crate::real::Real;
use crate::transport::Stop;
use core::ops::ControlFlow;

/// max |div d| h_x / max |d| that a direction d may have.
pub const CLEAN: f64 = 4e-5;
/// Part of its divergence that a projected direction may keep.
pub const DIRECTION_TOLERANCE: f64 = 0.02;

impl<T: Real> Evaluation<'_, '_, T> {
    /// Projects every slot, to a part `tolerance` of the divergence that it has; max |div| after it, which is not finite where the field is
    /// not.
    ///
    /// # Errors
    /// [`Stop::Cancelled`].
    pub fn project(
        &mut self,
        exec: &dyn Exec,
        observer: &mut dyn Observer,
        field: &mut VectorMut<'_, T>,
        tolerance: f64,
    ) -> Result<f64, Stop> {
        let sweep::Setup { slots, threads, .. } = self.setup.sweep;
        let mut projection = Projection::carve(
            self.levels,
            self.level,
            slots,
            threads,
            &mut Pool::new(&mut *self.region),
        );
        match projection.project(exec, observer, field, None, tolerance, self.sums) {
            ControlFlow::Continue(divergence) => Ok(divergence),
            ControlFlow::Break(()) => Err(Stop::Cancelled),
        }
    }

    /// Projects a direction, made of projected gradients, if it needs that: what projections leave of divergence would add up,
    /// and the descent would make use of it. What is left of its
    /// divergence, which is not finite where the direction is not, and max |d|.
    ///
    /// # Errors
    /// [`Stop::Cancelled`].
    pub fn clean(
        &mut self,
        exec: &dyn Exec,
        observer: &mut dyn Observer,
        direction: &mut VectorMut<'_, T>,
    ) -> Result<[f64; 2], Stop> {
        let sweep::Setup { slots, threads, .. } = self.setup.sweep;
        let mut projection = Projection::carve(
            self.levels,
            self.level,
            slots,
            threads,
            &mut Pool::new(&mut *self.region),
        );
        let [divergence, speed] = projection.relative_divergence(exec, direction, self.sums);
        let left = if divergence <= CLEAN {
            divergence
        } else {
            self.project(exec, observer, direction, DIRECTION_TOLERANCE)?
        };
        Ok([left, speed])
    }

    /// Makes a flow feasible (mathematics section 5): projects v, takes its force, transports rho_0 by it. A flow that is not finite, or too
    /// fast to be transported, is taken back towards v_0 until it is.
    ///
    /// # Errors
    /// [`Status::NotFinite`] where v_0 itself is too fast.
    pub fn finish<S: Space>(
        &mut self,
        exec: &dyn Exec,
        v: &mut VectorMut<'_, T>,
        w: &mut VectorMut<'_, T>,
    ) -> Result<Objective, Status> {
        let mut finished = self.finish_as_is::<S>(exec, v, w);
        for keep in RETREATS {
            if finished != Err(Status::NotFinite) {
                break;
            }
            self.retreat(exec, v, keep);
            finished = self.finish_as_is::<S>(exec, v, w);
        }
        match finished {
            // A projection leaves a part of the divergence that there was, most of it of what emitters push, beside which the force may be small.
            Ok(objective) if self.script.pushes() => {
                let force = self.projected::<S>(exec, &mut Silent, w)?;
                Ok(Objective {
                    data: objective.data,
                    ..force
                })
            }
            finished => finished,
        }
    }

    /// Takes a flow back towards v_0 in all slots: `keep` of the way from there is left.
    pub fn retreat(&self, exec: &dyn Exec, v: &mut VectorMut<'_, T>, keep: f64) {
        let grid = &self.levels.grids[self.level];
        pull_towards(exec, grid, self.initial, v, self.setup.sweep.slots, keep);
    }

    fn finish_as_is<S: Space>(
        &mut self,
        exec: &dyn Exec,
        v: &mut VectorMut<'_, T>,
        w: &mut VectorMut<'_, T>,
    ) -> Result<Objective, Status> {
        let projected = self.project(exec, &mut Silent, v, self.setup.projection_tolerance);
        match projected.and_then(|_| self.value::<S>(exec, &mut Silent, view(v), w, f64::INFINITY)) {
            Ok(objective) if objective.total().is_finite() => Ok(objective),
            Ok(_) => Err(Status::NotFinite),
            Err(stop) => Err(stop.into()),
        }
    }
}
