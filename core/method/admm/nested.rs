//! The nested start: the same scene on a grid of half as many cells an axis, solved first, and its flow prolonged.
//!
//! An odd axis coarsens as it does in STFAS: the flow is projected when it arrives, so the halves need not be exact.
//! The coarse solve begins the same way, down to 16 cells across in 2D and 8 in 3D, and lives in the bytes that AO and NSO
//! are going to use in turn, so it asks for no memory of its own; where it does not fit, the flow begins at rest. Ranks that share the box
//! plan what it takes beyond that.

use super::alternate::Projected;
use super::{Admm, Setup};
use crate::exec::{Capped, Exec};
use crate::field::{reborrow, view};
use crate::grid::{Grid, Space};
use crate::memory::{Ledger, Sharing};
use crate::method::animation::Animation;
use crate::method::coarse_start;
use crate::nso::SmootherMemory;
use crate::objective::coarse;
use crate::objective::script::Script;
use crate::observe::Observer;
use crate::progress::Status;
use crate::real::Real;

/// Outer iterations of a coarse solve at most.
const ITERATIONS: usize = 20;
/// The penalty of a coarse solve, in that of the finer one: the curvature of the data term goes with 1 / h^2, and with K / curvature
/// the part alpha of the way that AO can go.
const COARSER: f64 = 0.25;

impl Setup {
    /// The same solve with other scratch.
    fn in_space(mut self, threads: usize, memory: SmootherMemory) -> Self {
        self.memory = memory;
        self.ao.flow.sweep.threads = threads;
        self
    }

    /// The coarse solve on `grid`.
    fn coarsened(self, grid: Grid, threads: usize, memory: SmootherMemory) -> Self {
        let mut setup = self.in_space(threads, memory);
        setup.grid = grid;
        let filters = &mut setup.ao.flow.sweep.metric.filters;
        *filters = filters.saturating_sub(1);
        setup.iterations = ITERATIONS;
        setup.ao.penalty *= COARSER;
        setup
    }
}

impl<T: Real, S: Space> Admm<'_, T, S> {
    /// v from the coarse solve, if there is one.
    pub(super) fn nested_start(
        &mut self,
        exec: &dyn Exec,
        observer: &mut dyn Observer,
        script: &Script<'_, T>,
    ) -> Result<(), Status> {
        let Some(setup) = self.coarse_setup() else {
            return Ok(());
        };
        if self.solve_coarse(exec, observer, &setup, script)? == Status::NotFinite {
            let v = &mut self.animation.v;
            v.iter_mut().for_each(|component| component.fill(T::ZERO));
        }
        self.pbar.fill(T::ZERO);
        self.project(exec, observer, Projected::Flow)
    }

    /// The setup of the coarse solve on as many threads as its memory allows, or `None` when there is to be no coarse solve.
    fn coarse_setup(&self) -> Option<Setup> {
        let coarse = *self.animation.levels.grids.get(1)?;
        if !self.begins_coarser(&self.setup) {
            return None;
        }
        let fits = |setup: &Setup| {
            Self::coarse_bytes(setup).is_some_and(|bytes| bytes <= self.region.len() * T::BYTES)
        };
        let ways = SmootherMemory::all::<T, S>(&coarse);
        coarse::halvings(self.threads())
            .flat_map(|threads| ways.clone().map(move |memory| (threads, memory)))
            .map(|(threads, memory)| self.setup.coarsened(coarse, threads, memory))
            .find(fits)
    }

    /// Whether there is to be a coarse solve of `setup`: that follows from the problem alone, never from the threads, the ranks or the use of memory
    /// that was planned.
    fn begins_coarser(&self, setup: &Setup) -> bool {
        if setup.grid.is_part() {
            return Self::begins_coarser_in_whole(setup);
        }
        let grids = &self.animation.levels.grids;
        let (Some(fine), Some(coarse)) = (grids.first(), grids.get(1)) else {
            return false;
        };
        let room = coarse::scratch_per_thread(fine, self.slots()) <= fine.cells() * self.slots();
        if !(setup.params.nested && coarse::large_enough(coarse) && room) {
            return false;
        }
        let least = setup.coarsened(*coarse, 1, SmootherMemory::LEAST);
        matches!((Self::coarse_bytes(&least), self.least_region(setup)), (Some(coarse), Some(fine)) if coarse <= fine)
    }

    /// The same where one program has all of the box. A function of its own, since a state takes much of a stack.
    #[inline(never)]
    fn begins_coarser_in_whole(setup: &Setup) -> bool {
        let mut whole = *setup;
        whole.grid = setup.grid.whole();
        Self::with(&whole).begins_coarser(&whole)
    }

    /// Counts the coarse solve where ranks share the box: with all of a coarser grid, or many copies, it may need more than the rest that is used in
    /// turn.
    pub(super) fn measure_coarse(&self, setup: &Setup, ledger: &mut Ledger) {
        let coarse = self.animation.levels.grids.get(1);
        let Some(coarse) = coarse.filter(|_| setup.grid.is_part() && self.begins_coarser(setup)) else {
            return;
        };
        let least = setup.coarsened(*coarse, 1, SmootherMemory::LEAST);
        let bytes = Self::coarse_bytes(&least).unwrap_or(usize::MAX);
        ledger.line(
            "solve on the next coarser grid",
            bytes.div_ceil(T::BYTES),
            T::BYTES,
        );
    }

    /// Bytes of the region where one thread uses the least memory.
    fn least_region(&self, setup: &Setup) -> Option<usize> {
        let mut ledger = Ledger::new();
        ledger.group("used in turn", Sharing::InTurn, |ledger| {
            self.measure(&setup.in_space(1, SmootherMemory::LEAST), ledger);
        });
        ledger.bytes()
    }

    /// Bytes of a coarse solve.
    #[inline(never)]
    fn coarse_bytes(setup: &Setup) -> Option<usize> {
        coarse_start::bytes::<T, S>(Admm::with(setup), setup.fields, &mut Ledger::new())
    }

    /// Solves the coarse scene in `region` and prolongs its flow.
    fn solve_coarse(
        &mut self,
        exec: &dyn Exec,
        observer: &mut dyn Observer,
        setup: &Setup,
        script: &Script<'_, T>,
    ) -> Result<Status, Status> {
        let Self {
            animation,
            region,
            pbar: scratch,
            ..
        } = self;
        let exec = &Capped::new(exec, setup.ao.flow.sweep.threads);
        let mut admm = Admm::<T, S>::with(setup);
        let ended = coarse_start::solve(exec, observer, animation, script, &mut admm, region, scratch)?;
        let Animation { levels, v, slots, .. } = animation;
        let coarse_v = view(&admm.animation.v);
        coarse::prolong(exec, levels, 0, *slots, coarse_v, reborrow(v), scratch);
        Ok(ended)
    }
}
