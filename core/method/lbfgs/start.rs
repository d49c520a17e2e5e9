//! Where the forces begin: at 0, or as those of the same scene on a coarser grid, solved first in the bytes of `rest`.

use super::{Lbfgs, Settings};
use crate::exec::{Capped, Exec};
use crate::field::slot::put_everywhere;
use crate::field::{reborrow, view};
use crate::grid::Space;
use crate::memory::Arena;
use crate::memory::Ledger;
use crate::objective::coarse;
use crate::objective::flow::{self, Evaluation};
use crate::objective::keyframes::Keyframes;
use crate::observe::{Observer, WorkOnly};
use crate::optimise::descent::Descent;
use crate::progress::Status;
use crate::real::Real;

/// Iterations of a coarse solve at most.
const COARSE_ITERATIONS: usize = 40;

impl<T: Real, S: Space> Lbfgs<'_, T, S> {
    /// The first flow and forces.
    pub(super) fn begin(
        &mut self,
        exec: &dyn Exec,
        observer: &mut dyn Observer,
        keyframes: &Keyframes<'_, T>,
    ) -> Result<(), Status> {
        let slots = self.settings.carrier.slots;
        self.u.iter_mut().for_each(|component| component.fill(T::ZERO));
        put_everywhere(exec, &self.levels.finest, view(&self.initial), &mut self.v, slots);
        if let Some(settings) = self.coarse_settings() {
            self.begin_coarse(exec, observer, &settings, keyframes)?;
        }
        self.descent = Descent::new(self.settings.params.history);
        self.begun = true;
        Ok(())
    }

    /// The settings of the coarse solve on as many threads as its bytes allow, or `None` when there is to be none.
    ///
    /// Whether there is one follows from the problem alone, never from the threads that memory was planned for.
    fn coarse_settings(&self) -> Option<Settings> {
        let (fine, coarse) = (self.levels.grids.first()?, self.levels.grids.get(1)?);
        let on = |threads: usize| {
            let mut settings = Settings {
                grid: *coarse,
                iterations: COARSE_ITERATIONS,
                ..self.settings
            };
            settings.carrier.metric.filters = settings.carrier.metric.filters.saturating_sub(1);
            settings.carrier.threads = threads;
            settings
        };
        let room = |threads: usize| {
            let (mut settings, mut ledger) = (self.settings, Ledger::new());
            settings.carrier.threads = threads;
            Self::rest(&mut ledger, &settings);
            ledger.bytes().unwrap_or(0) / T::BYTES
        };
        let threads = self.settings.carrier.threads;
        if !(self.settings.params.nested
            && coarse::begins_on(fine, coarse)
            && self.coarse_numbers(&on(1)) <= room(1))
        {
            return None;
        }
        let fewer = coarse::halvings(threads);
        fewer
            .map(on)
            .find(|settings| self.coarse_numbers(settings) <= room(threads))
    }

    /// Numbers that the coarse solve and the way to it take.
    fn coarse_numbers(&self, settings: &Settings) -> usize {
        let mut ledger = Ledger::new();
        Self::requirement(&mut ledger, settings);
        ledger.line(
            "keyframe densities",
            settings.keyframes * settings.grid.cells(),
            T::BYTES,
        );
        let scratch = settings.carrier.threads
            * coarse::scratch_per_thread(&self.settings.grid, settings.carrier.slots);
        ledger
            .bytes()
            .map_or(usize::MAX, |bytes| (bytes / T::BYTES).saturating_add(scratch))
    }

    /// Solves the coarse scene, prolongs its forces and its flow, and projects both.
    fn begin_coarse(
        &mut self,
        exec: &dyn Exec,
        observer: &mut dyn Observer,
        settings: &Settings,
        keyframes: &Keyframes<'_, T>,
    ) -> Result<(), Status> {
        let Self {
            levels,
            rest,
            rho,
            initial,
            v,
            u,
            settings: fine,
            sums,
            ..
        } = self;
        let (cells, coarse, slots) = (fine.grid.cells(), settings.grid.cells(), fine.carrier.slots);
        let capped = &Capped::new(exec, settings.carrier.threads);
        let scratch = settings.carrier.threads * coarse::scratch_per_thread(&fine.grid, slots);
        let (memory, scratch) = rest.split_at_mut(rest.len() - scratch);
        let mut arena = Arena::over(memory);
        let full = |_| Status::NotFinite;
        let mut solver = Lbfgs::<T, S>::carve(&mut arena, settings).map_err(full)?;
        let densities = arena.take(settings.keyframes * coarse).map_err(full)?;
        let scene = coarse::Scene {
            source: &rho[..cells],
            initial: view(initial),
            keyframes,
        };
        let coarser = coarse::SceneMut {
            source: &mut solver.rho[..coarse],
            initial: reborrow(&mut solver.initial),
            densities: &mut *densities,
        };
        coarse::restrict(capped, levels, 0, &scene, coarser, scratch);
        let coarse_keyframes = keyframes.coarse(1, densities);
        let status = loop {
            if let Some(status) = solver
                .step(capped, &mut WorkOnly(observer), &coarse_keyframes)
                .status
            {
                break status;
            }
        };
        match status {
            Status::Cancelled => return Err(status),
            Status::NotFinite => return Ok(()),
            _ => {}
        }
        coarse::prolong(capped, levels, 0, slots, view(&solver.v), reborrow(v), scratch);
        coarse::prolong(capped, levels, 0, slots, view(&solver.u), reborrow(u), scratch);
        drop(solver);
        let Settings {
            carrier,
            viscosity,
            force_weight,
            projection_tolerance,
            ..
        } = *fine;
        let setup = flow::Setup {
            carrier,
            viscosity,
            force_weight,
            projection_tolerance,
        };
        let keyframes = *keyframes;
        let mut evaluation = Evaluation {
            levels,
            level: 0,
            setup,
            initial: view(initial),
            rho,
            keyframes,
            region: rest,
            sums,
        };
        [v, u]
            .into_iter()
            .try_for_each(|field| {
                evaluation
                    .project(exec, observer, field, setup.projection_tolerance)
                    .map(drop)
            })
            .map_err(|_| Status::Cancelled)
    }
}
