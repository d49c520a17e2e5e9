//! Where the forces begin: at 0, or as those of the same scene on a coarser grid, solved first in the bytes of `rest`.

use super::{Lbfgs, Setup};
use crate::exec::{Capped, Exec};
use crate::field::slot::put_everywhere;
use crate::field::{reborrow, view};
use crate::grid::Space;
use crate::memory::Ledger;
use crate::method::animation::Animation;
use crate::method::coarse_start;
use crate::objective::coarse;
use crate::objective::script::Script;
use crate::observe::Observer;
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
        script: &Script<'_, T>,
    ) -> Result<(), Status> {
        self.u.iter_mut().for_each(|component| component.fill(T::ZERO));
        let Animation {
            levels,
            initial,
            v,
            slots,
            ..
        } = &mut self.animation;
        put_everywhere(exec, &levels.finest, view(initial), v, *slots);
        if let Some(setup) = self.coarse_setup() {
            self.begin_coarse(exec, observer, &setup, script)?;
        }
        self.descent = Descent::new(self.setup.history);
        self.begun = true;
        Ok(())
    }

    /// The setup of the coarse solve on as many threads as its memory allows, or `None` when there is to be none.
    ///
    /// Whether there is one follows from the problem alone, never from the threads that memory was planned for.
    fn coarse_setup(&self) -> Option<Setup> {
        let grids = &self.animation.levels.grids;
        let (fine, coarse) = (grids.first()?, grids.get(1)?);
        let on = |threads: usize| {
            let mut setup = Setup {
                grid: *coarse,
                iterations: COARSE_ITERATIONS,
                ..self.setup
            };
            let sweep = &mut setup.flow.sweep;
            sweep.metric.filters = sweep.metric.filters.saturating_sub(1);
            sweep.threads = threads;
            setup
        };
        let room = |threads: usize| {
            let mut ledger = Ledger::new();
            self.measure(threads, &mut ledger);
            ledger.elements(T::BYTES)
        };
        let fits = |setup: &Setup, room: usize| self.coarse_elements(setup).is_some_and(|len| len <= room);
        let threads = self.setup.flow.sweep.threads;
        if !(self.setup.nested && coarse::begins_on(fine, coarse) && fits(&on(1), room(1))) {
            return None;
        }
        let room = room(threads);
        coarse::halvings(threads).map(on).find(|setup| fits(setup, room))
    }

    /// Elements that the coarse solve and the way to it take.
    fn coarse_elements(&self, setup: &Setup) -> Option<usize> {
        let mut ledger = Ledger::new();
        let bytes = coarse_start::bytes::<T, S>(Lbfgs::with(setup), setup.fields, &mut ledger)?;
        (bytes / T::BYTES).checked_add(self.transfer_scratch(setup))
    }

    /// Elements of scratch that fields take on their way to and from the coarse grid.
    fn transfer_scratch(&self, coarse: &Setup) -> usize {
        coarse.flow.sweep.threads * coarse::scratch_per_thread(&self.setup.grid, self.animation.slots)
    }

    /// Solves the coarse scene, prolongs its forces and its flow, and projects both.
    fn begin_coarse(
        &mut self,
        exec: &dyn Exec,
        observer: &mut dyn Observer,
        setup: &Setup,
        script: &Script<'_, T>,
    ) -> Result<(), Status> {
        let scratch = self.transfer_scratch(setup);
        let Self {
            animation,
            rest,
            u,
            setup: fine,
            ..
        } = self;
        let capped = &Capped::new(exec, setup.flow.sweep.threads);
        let (memory, scratch) = rest.split_at_mut(rest.len() - scratch);
        let mut solver = Lbfgs::<T, S>::with(setup);
        let ended = coarse_start::solve(capped, observer, animation, script, &mut solver, memory, scratch)?;
        if ended == Status::NotFinite {
            return Ok(());
        }
        let Animation { levels, v, slots, .. } = animation;
        let coarse_v = view(&solver.animation.v);
        coarse::prolong(capped, levels, 0, *slots, coarse_v, reborrow(v), scratch);
        coarse::prolong(capped, levels, 0, *slots, view(&solver.u), reborrow(u), scratch);
        drop(solver);
        let tolerance = fine.flow.projection_tolerance;
        let (mut evaluation, v) = animation.evaluation(fine.flow, script, rest);
        [v, u]
            .into_iter()
            .try_for_each(|field| evaluation.project(exec, observer, field, tolerance).map(drop))
            .map_err(|_| Status::Cancelled)
    }
}
