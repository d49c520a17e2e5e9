//! The first half of an iteration: AO, from v* = v.

use super::Admm;
use crate::exec::Exec;
use crate::field::{reborrow, view};
use crate::grid::Space;
use crate::method::admm::ao;
use crate::objective::keyframes::Keyframes;
use crate::observe::{Event, Observer};
use crate::progress::{Progress, Status};
use crate::real::Real;
use crate::transport::Stop;

impl<T: Real, S: Space> Admm<'_, T, S> {
    /// v* by AO, with the densities that it carries.
    pub(super) fn update_density(
        &mut self,
        exec: &dyn Exec,
        observer: &mut dyn Observer,
        keyframes: &Keyframes<'_, T>,
        progress: &mut Progress,
    ) -> Result<(), Status> {
        if observer.on(Event::AoBegin).is_break() {
            return Err(Status::Cancelled);
        }
        for (target, v) in self.target.iter_mut().zip(&self.v) {
            target.copy_from_slice(v);
        }
        let fields = ao::Fields {
            v: view(&self.v),
            multiplier: view(&self.multiplier),
            star: reborrow(&mut self.target),
            direction: reborrow(&mut self.w),
            initial: view(&self.initial),
            rho: self.rho,
            keyframes,
        };
        let solved = ao::solve(
            exec,
            observer,
            &self.levels,
            &self.settings.setup,
            fields,
            &mut self.step,
            self.region,
            self.sums,
        );
        if observer.on(Event::AoEnd).is_break() {
            return Err(Status::Cancelled);
        }
        match solved {
            Ok(info) => {
                let admm = &mut progress.admm;
                (admm.ao_step, admm.ao_residuals, admm.data_of_star) = (info.step, info.residuals, info.data);
                admm.density_change = info.density_change / self.settings.setup.carrier.largest;
                if info.data.is_finite() {
                    Ok(())
                } else {
                    Err(Status::NotFinite)
                }
            }
            Err(Stop::Cancelled) => Err(Status::Cancelled),
            Err(Stop::TooFast) => Err(Status::NotFinite),
        }
    }
}
