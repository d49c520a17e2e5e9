//! The nested start: the same scene on a grid of half as many cells an axis, solved first, and its flow prolonged.
//!
//! The coarse solve begins the same way, down to 16 cells across in 2D and 8 in 3D, and lives in the bytes that AO and NSO
//! are going to use in turn, so it asks for no memory of its own; where it does not fit, the flow begins at rest.

use super::{Admm, Dimensions, Settings};
use crate::exec::{Capped, Exec};
use crate::field::{reborrow, view};
use crate::grid::{Grid, Space};
use crate::memory::Arena;
use crate::memory::{Ledger, Pool};
use crate::nso::Shape;
use crate::objective::coarse;
use crate::objective::keyframes::Keyframes;
use crate::observe::{Observer, WorkOnly};
use crate::poisson::Projection;
use crate::progress::Status;
use crate::real::Real;

/// Outer iterations of a coarse solve at most.
const ITERATIONS: usize = 20;
/// The penalty of a coarse solve, in that of the finer one: the curvature of the data term goes with 1 / h^2, and with K / curvature
/// the part alpha of the way that AO can go.
const COARSER: f64 = 0.25;

impl Settings {
    /// The same solve with other scratch.
    fn in_space(mut self, grid: Grid, threads: usize, shape: Shape) -> Self {
        self.dimensions = Dimensions {
            grid,
            threads,
            shape,
            ..self.dimensions
        };
        self.setup.carrier.threads = threads;
        self
    }

    /// The coarse solve on `grid`.
    fn coarsened(self, grid: Grid, threads: usize, shape: Shape) -> Self {
        let mut settings = self.in_space(grid, threads, shape);
        settings.dimensions.filters = self.dimensions.filters.saturating_sub(1);
        settings.setup.carrier.metric.filters = settings.dimensions.filters;
        settings.iterations = ITERATIONS;
        settings.setup.penalty *= COARSER;
        settings
    }
}

impl<T: Real, S: Space> Admm<'_, T, S> {
    /// v from the coarse solve, if there is one.
    pub(super) fn nested_start(
        &mut self,
        exec: &dyn Exec,
        observer: &mut dyn Observer,
        keyframes: &Keyframes<'_, T>,
    ) -> Result<(), Status> {
        let Some(settings) = self.coarse_settings(keyframes.count()) else {
            return Ok(());
        };
        if self.solve_coarse(exec, observer, &settings, keyframes)? == Status::NotFinite {
            self.v.iter_mut().for_each(|component| component.fill(T::ZERO));
        }
        self.pbar.fill(T::ZERO);
        let Dimensions { slots, threads, .. } = self.settings.dimensions;
        let mut projection =
            Projection::carve(&self.levels, 0, slots, threads, &mut Pool::new(&mut *self.region));
        let tolerance = self.settings.setup.projection_tolerance;
        let projected = projection.project(exec, observer, slots, &mut self.v, None, tolerance, self.sums);
        if projected.is_break() {
            Err(Status::Cancelled)
        } else {
            Ok(())
        }
    }

    /// The settings of the coarse solve on as many threads as its bytes allow, or `None` when there is to be no coarse solve.
    ///
    /// Whether there is one follows from the problem alone, never from the threads or the shape that memory was planned for.
    fn coarse_settings(&self, keyframes: usize) -> Option<Settings> {
        let Dimensions { slots, threads, .. } = self.settings.dimensions;
        let (fine, coarse) = (self.levels.grids.first()?, self.levels.grids.get(1)?);
        let room = coarse::scratch_per_thread(fine, slots) <= self.pbar.len();
        if !(self.settings.params.nested && coarse::begins_on(fine, coarse) && room) {
            return None;
        }
        let mut ledger = Ledger::new();
        Self::in_turn(&mut ledger, &self.settings.in_space(*fine, 1, Shape::LEAST));
        if Self::coarse_bytes(&self.settings.coarsened(*coarse, 1, Shape::LEAST), keyframes)?
            > ledger.bytes()?
        {
            return None;
        }
        let shapes = Shape::all::<T, S>(coarse);
        let fewer = coarse::halvings(threads);
        let all = fewer.flat_map(|threads| shapes.clone().map(move |shape| (threads, shape)));
        let fits = |settings: &Settings| {
            Self::coarse_bytes(settings, keyframes).is_some_and(|bytes| bytes <= self.region.len() * T::BYTES)
        };
        all.map(|(threads, shape)| self.settings.coarsened(*coarse, threads, shape))
            .find(fits)
    }

    /// Bytes of a coarse solve.
    fn coarse_bytes(settings: &Settings, keyframes: usize) -> Option<usize> {
        let mut ledger = Ledger::new();
        Self::requirement(&mut ledger, settings);
        ledger.line(
            "keyframe densities",
            keyframes * settings.dimensions.grid.cells(),
            T::BYTES,
        );
        ledger.bytes()
    }

    /// Solves the coarse scene in `region` and prolongs its flow.
    fn solve_coarse(
        &mut self,
        exec: &dyn Exec,
        observer: &mut dyn Observer,
        settings: &Settings,
        keyframes: &Keyframes<'_, T>,
    ) -> Result<Status, Status> {
        let Self {
            levels,
            region,
            rho,
            initial,
            v,
            pbar: scratch,
            settings: fine,
            ..
        } = self;
        let exec = &Capped::new(exec, settings.dimensions.threads);
        let (cells, coarse) = (fine.dimensions.grid.cells(), settings.dimensions.grid.cells());
        let mut arena = Arena::over(region);
        let full = |_| Status::NotFinite;
        let mut admm = Admm::<T, S>::carve(&mut arena, settings).map_err(full)?;
        let densities = arena.take(keyframes.count() * coarse).map_err(full)?;
        let scene = coarse::Scene {
            source: &rho[..cells],
            initial: view(initial),
            keyframes,
        };
        let coarser = coarse::SceneMut {
            source: &mut admm.rho[..coarse],
            initial: reborrow(&mut admm.initial),
            densities: &mut *densities,
        };
        coarse::restrict(exec, levels, 0, &scene, coarser, scratch);
        let coarse_keyframes = keyframes.coarse(1, densities);
        let status = loop {
            if let Some(status) = admm.step(exec, &mut WorkOnly(observer), &coarse_keyframes).status {
                break status;
            }
        };
        if status == Status::Cancelled {
            return Err(status);
        }
        coarse::prolong(
            exec,
            levels,
            0,
            fine.dimensions.slots,
            view(&admm.v),
            reborrow(v),
            scratch,
        );
        Ok(status)
    }
}
