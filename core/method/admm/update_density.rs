//! The first half of an iteration: AO, from v* = v.

use super::Admm;
use super::report::Course;
use crate::exec::Exec;
use crate::field::{reborrow, view};
use crate::grid::Space;
use crate::method::admm::ao::{self, AO};
use crate::objective::script::Script;
use crate::observe::{Event, Observer};
use crate::progress::Status;
use crate::real::Real;

impl<T: Real, S: Space> Admm<'_, T, S> {
    /// v* by AO, with the densities that it carries.
    pub(super) fn update_density(
        &mut self,
        exec: &dyn Exec,
        observer: &mut dyn Observer,
        script: &Script<'_, T>,
        course: &mut Course,
    ) -> Result<(), Status> {
        if observer.on(Event::PhaseBegin(AO)).is_break() {
            return Err(Status::Cancelled);
        }
        for (target, v) in self.target.iter_mut().zip(&self.animation.v) {
            target.copy_from_slice(v);
        }
        let fields = ao::Fields {
            v: view(&self.animation.v),
            multiplier: view(&self.multiplier),
            star: reborrow(&mut self.target),
            direction: reborrow(&mut self.w),
            initial: view(&self.animation.initial),
            rho: self.animation.rho,
            script,
        };
        let solved = ao::solve::<T, S>(
            exec,
            observer,
            &self.animation.levels,
            &self.setup.ao,
            fields,
            &mut self.step,
            self.region,
            self.animation.sums,
        );
        if observer.on(Event::PhaseEnd(AO)).is_break() {
            return Err(Status::Cancelled);
        }
        match solved {
            Ok(info) => {
                (course.ao_step, course.ao_residuals, course.data_of_star) =
                    (info.step, info.residuals, info.data);
                course.density_change = info.density_change / self.setup.ao.flow.sweep.largest;
                if info.data.is_finite() {
                    Ok(())
                } else {
                    Err(Status::NotFinite)
                }
            }
            Err(stop) => Err(stop.into()),
        }
    }
}
