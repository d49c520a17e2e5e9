//! The paper's method (its section 4): ADMM between the advection problem (AO) and the Navier-Stokes problem (NSO).
//!
//! ```text
//! v*   <- argmin 1/2 <e, C e> + K/2 |v* - v - lambda/K|^2        density: AO
//! v, w <- argmin K/2 |v - v* + lambda/K|^2 + r/2 |w|^2            velocity: NSO with t = v* - lambda/K
//! lambda <- lambda + K beta (v - v*)                              multiplier
//! ```
//!
//! Two vector fields serve both problems. During AO they are v* and lambda/K; NSO needs only t, and the new lambda/K is
//! v - t when beta = 1, so the second one is free for damping. The bytes of w hold AO's direction, since w follows from v, p.

pub mod ao;
mod check;
mod nested;
mod update_density;
mod update_multiplier;
mod update_velocity;

use crate::checkpoint::{Damaged, MANY, Record};
use crate::exec::Exec;
use crate::field::slot::{RETREATS, pull_towards};
use crate::field::trajectory::{self, Shape as Trajectory};
use crate::field::{Vector, VectorMut, means, view};
use crate::grid::levels::Levels;
use crate::grid::{Grid, Space};
use crate::memory::{Arena, TooSmall};
use crate::memory::{Ledger, Pool, Sharing};
use crate::nso::{self, Bases, Nso, NsoParams, NsoSolver, Shape};
use crate::objective::keyframes::Keyframes;
use crate::objective::sweep::{self, densities};
use crate::observe::{Event, Observer, Silent};
use crate::poisson::{self, Projection};
use crate::problem::{Problem, ProblemError, positive};
use crate::progress::{Objective, Progress, Status};
use crate::real::Real;

use core::marker::PhantomData;

/// What a caller chooses for ADMM.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AdmmParams {
    /// Penalty K, in the scene's units.
    pub penalty: f64,
    /// Relaxation beta.
    pub relaxation: f64,
    /// Fixed-point iterations of AO in each outer iteration.
    pub ao_iterations: usize,
    /// Momentum between the iterations of one AO, at least 0 and below 1; 0 is the paper's AO.
    pub ao_momentum: f64,
    /// Stop when rho changes less than this times max rho_0 in an outer iteration.
    pub density_tolerance: f64,
    /// Whether the flow begins as that of the same scene on a grid of half as many cells an axis, solved first.
    pub nested: bool,
    /// The Navier-Stokes problem.
    pub nso: NsoParams,
}

impl Default for AdmmParams {
    fn default() -> Self {
        Self {
            penalty: 1e3,
            relaxation: 1.0,
            ao_iterations: 2,
            ao_momentum: 0.0,
            density_tolerance: 0.01,
            nested: true,
            nso: NsoParams::default(),
        }
    }
}

impl AdmmParams {
    /// Most fixed-point iterations of AO in an outer iteration.
    pub const MOST_AO_ITERATIONS: usize = 1000;

    /// Checks every number.
    ///
    /// # Errors
    /// [`ProblemError::NotPositive`] names the first that is wrong.
    pub fn check(&self) -> Result<(), ProblemError> {
        positive("admm.penalty", self.penalty)?;
        positive("admm.relaxation", self.relaxation)?;
        positive("admm.ao_iterations", self.ao_iterations as f64)?;
        if !(0.0..1.0).contains(&self.ao_momentum) {
            return Err(ProblemError::Momentum {
                given: self.ao_momentum,
            });
        }
        positive("admm.density_tolerance", self.density_tolerance)?;
        positive("admm.nso_tolerance", self.nso.tolerance)?;
        positive("admm.nso_cycles", self.nso.cycles as f64)
    }
}

/// The sizes that the buffers follow from.
#[derive(Clone, Copy, Debug)]
pub struct Dimensions {
    /// The finest grid.
    pub grid: Grid,
    /// Slots T = N - 1.
    pub slots: usize,
    /// Filters of the metric.
    pub filters: usize,
    /// Threads that scratch is planned for.
    pub threads: usize,
    /// How the smoother uses its memory.
    pub shape: Shape,
}

/// All that a solve follows from but its densities, in scaled numbers.
#[derive(Clone, Copy, Debug)]
pub struct Settings {
    /// The sizes.
    pub dimensions: Dimensions,
    /// The caller's choices.
    pub params: AdmmParams,
    /// AO's numbers; max rho_0 is set with the source.
    pub setup: ao::Setup,
    /// nu in scaled numbers.
    pub viscosity: f64,
    /// r.
    pub force_weight: f64,
    /// Outer iterations at most.
    pub iterations: usize,
}

impl Settings {
    /// The settings of `problem`.
    #[must_use]
    pub fn new(
        problem: &Problem<'_>,
        params: &AdmmParams,
        dimensions: Dimensions,
        iterations: usize,
    ) -> Self {
        let units = problem.units();
        let setup = ao::Setup {
            penalty: params.penalty * units.velocity * units.velocity,
            iterations: params.ao_iterations,
            momentum: params.ao_momentum,
            projection_tolerance: problem.projection_tolerance,
            carrier: sweep::Setup::new(problem, dimensions.threads),
        };
        let (viscosity, force_weight) = (problem.scaled_viscosity(), problem.scaled_force_weight());
        Self {
            dimensions,
            params: *params,
            setup,
            viscosity,
            force_weight,
            iterations,
        }
    }
}

/// ADMM's state: every buffer but the keyframes.
#[derive(Debug)]
pub struct Admm<'m, T, S> {
    pub(crate) levels: Levels<'m, T>,
    bases: Bases<'m, T>,
    /// Velocities v_k.
    pub(crate) v: VectorMut<'m, T>,
    /// Forces w_k; AO's direction.
    pub(crate) w: VectorMut<'m, T>,
    p: &'m mut [T],
    pbar: &'m mut [T],
    /// v* during AO, t during NSO.
    target: VectorMut<'m, T>,
    /// lambda / K during AO; during NSO free for damping once it is not needed.
    multiplier: VectorMut<'m, T>,
    /// A field of its own for damping, when beta is not 1; otherwise empty.
    spare: VectorMut<'m, T>,
    /// v_0.
    pub(crate) initial: VectorMut<'m, T>,
    /// rho_0 .. rho_N.
    pub(crate) rho: &'m mut [T],
    /// Bytes that AO and NSO use in turn.
    region: &'m mut [T],
    sums: &'m mut [f64],
    settings: Settings,
    step: f64,
    iteration: usize,
    history: check::History,
    space: PhantomData<S>,
}

impl<'m, T: Real, S: Space> Admm<'m, T, S> {
    /// Writes the ledger lines of [`Self::carve`], in its order.
    pub fn requirement(ledger: &mut Ledger, settings: &Settings) {
        let Dimensions { grid, slots, .. } = settings.dimensions;
        let (cells, len) = (grid.cells(), grid.cells() * slots);
        ledger.line("densities rho_0 .. rho_N", densities(&grid, slots), T::BYTES);
        Levels::<T>::requirement(ledger, &grid, settings.dimensions.filters);
        Bases::<T>::requirement::<S>(ledger, &levels_of(&grid));
        for name in [
            "velocity v",
            "force w (AO: direction)",
            "target t (AO: v*)",
            "multiplier lambda / K (NSO: damping)",
        ] {
            ledger.vector(name, S::DIM, len, T::BYTES);
        }
        if settings.params.relaxation != 1.0 {
            ledger.vector(
                "damping of NSO beside the multiplier (beta is not 1)",
                S::DIM,
                len,
                T::BYTES,
            );
        }
        ledger.line("pressure p", len, T::BYTES);
        ledger.line("pressure pbar", len, T::BYTES);
        ledger.vector("given velocity v_0", S::DIM, cells, T::BYTES);
        ledger.line("sums of rows", sums_len(&settings.dimensions), 8);
        Self::in_turn(ledger, settings);
    }

    /// The lines of the bytes that AO and NSO use in turn.
    fn in_turn(ledger: &mut Ledger, settings: &Settings) {
        let Dimensions {
            grid,
            slots,
            threads,
            shape,
            ..
        } = settings.dimensions;
        ledger.group("used in turn", Sharing::InTurn, |ledger| {
            ao::requirement::<T>(ledger, &grid, &settings.setup);
            match settings.params.nso.solver {
                NsoSolver::Stfas => Nso::<T, S>::requirement(ledger, &grid, slots, threads, shape),
                NsoSolver::NewtonCg => nso::newton::requirement::<T>(ledger, &grid, slots, threads),
            }
        });
    }

    /// Takes its buffers.
    ///
    /// # Errors
    /// [`TooSmall`].
    #[inline(never)]
    pub fn carve(arena: &mut Arena<'m>, settings: &Settings) -> Result<Self, TooSmall> {
        let Dimensions { grid, slots, .. } = settings.dimensions;
        let (cells, len) = (grid.cells(), grid.cells() * slots);
        let rho = arena.take(densities(&grid, slots))?;
        let levels = Levels::carve(arena, &grid, settings.dimensions.filters)?;
        let bases = Bases::carve::<S>(arena, &levels.grids)?;
        let mut vector = |len: usize| arena.take_vector(S::DIM, len);
        let (v, w, target, multiplier) = (vector(len)?, vector(len)?, vector(len)?, vector(len)?);
        let spare = if settings.params.relaxation != 1.0 {
            vector(len)?
        } else {
            Default::default()
        };
        let (p, pbar) = (arena.take(len)?, arena.take(len)?);
        let initial = arena.take_vector(S::DIM, cells)?;
        let sums = arena.take(sums_len(&settings.dimensions))?;
        let mut ledger = Ledger::new();
        Self::in_turn(&mut ledger, settings);
        let region = arena.take(ledger.bytes().unwrap_or(usize::MAX) / T::BYTES)?;
        Ok(Self {
            levels,
            bases,
            v,
            w,
            p,
            pbar,
            target,
            multiplier,
            spare,
            initial,
            rho,
            region,
            sums,
            settings: *settings,
            step: 1.0,
            iteration: 0,
            history: check::History::default(),
            space: PhantomData,
        })
    }

    /// One outer iteration.
    pub fn step(
        &mut self,
        exec: &dyn Exec,
        observer: &mut dyn Observer,
        keyframes: &Keyframes<'_, T>,
    ) -> Progress {
        let mut progress = Progress::default();
        progress.status = self.iterate(exec, observer, keyframes, &mut progress).err();
        progress
    }
}

impl<T: Real, S: Space> Admm<'_, T, S> {
    /// The loop's body; an error is how the solve ended.
    fn iterate(
        &mut self,
        exec: &dyn Exec,
        observer: &mut dyn Observer,
        keyframes: &Keyframes<'_, T>,
        progress: &mut Progress,
    ) -> Result<(), Status> {
        if self.iteration == 0 {
            self.nested_start(exec, observer, keyframes)?;
        }
        self.iteration += 1;
        progress.iteration = self.iteration;
        if observer
            .on(Event::IterationBegin {
                iteration: self.iteration,
            })
            .is_break()
        {
            return Err(Status::Cancelled);
        }
        let mut carried = self.update_density(exec, observer, keyframes, progress);
        // A flow from a coarser grid may be too fast for this one.
        for keep in RETREATS {
            if carried != Err(Status::NotFinite) {
                break;
            }
            self.retreat(exec, keep);
            carried = self.update_density(exec, observer, keyframes, progress);
        }
        carried?;
        let improved = self
            .update_velocity(exec, observer, progress)
            .and_then(|()| self.objective(exec, observer, keyframes))
            .and_then(finite);
        if improved == Err(Status::NotFinite) {
            self.return_to_star(exec);
        }
        progress.objective = improved?;
        self.update_multiplier(exec, progress)?;
        self.check(progress)
    }

    /// v = v*, the last flow that was carried to its end, in the place of one that is not finite or too fast; v = t where damping overwrote
    /// lambda / K.
    fn return_to_star(&mut self, exec: &dyn Exec) {
        let (grid, slots) = (&self.levels.finest, self.settings.dimensions.slots);
        let lost = self.history.damped && self.spare[0].is_empty();
        let shape = Trajectory { grid, slots };
        trajectory::add(exec, shape, &mut self.v, 0.0, 1.0, view(&self.target));
        if !lost {
            trajectory::add(exec, shape, &mut self.v, 1.0, 1.0, view(&self.multiplier));
        }
        self.p.fill(T::ZERO);
        self.pbar.fill(T::ZERO);
    }

    /// The finest grid.
    pub(crate) fn grid(&self) -> &Grid {
        &self.levels.finest
    }

    /// Slots T.
    pub(crate) fn slots(&self) -> usize {
        self.settings.dimensions.slots
    }

    /// Sets rho_0 and its maximum.
    pub(crate) fn set_source(&mut self, density: &[T], largest: f64) {
        self.rho[..density.len()].copy_from_slice(density);
        self.settings.setup.carrier.largest = largest;
    }

    /// Projects v_0; the change relative to max |v_0|.
    pub(crate) fn project_initial(&mut self, exec: &dyn Exec) -> f64 {
        let (threads, tolerance) = (
            self.settings.dimensions.threads,
            self.settings.setup.projection_tolerance,
        );
        let projection = Projection::carve(&self.levels, 0, 1, threads, &mut Pool::new(&mut *self.region));
        poisson::project_given(
            exec,
            &self.levels.finest,
            projection,
            &mut self.initial,
            &mut self.w,
            tolerance,
            self.sums,
        )
    }

    /// The forces of the result.
    pub(crate) fn force(&self) -> Vector<'_, T> {
        view(&self.w)
    }

    /// Projects v, takes w from it and transports rho_0 by it. A flow that is not finite, or too fast to be transported, is taken back
    /// towards v_0 until it is.
    pub(crate) fn make_feasible(
        &mut self,
        exec: &dyn Exec,
        keyframes: &Keyframes<'_, T>,
    ) -> Result<Objective, Status> {
        let mut finished = self.finish_as_is(exec, keyframes);
        for keep in RETREATS {
            if finished != Err(Status::NotFinite) {
                break;
            }
            self.retreat(exec, keep);
            finished = self.finish_as_is(exec, keyframes);
        }
        finished
    }

    /// Takes the flow back towards v_0 in all slots: `keep` of the way from there is left.
    fn retreat(&mut self, exec: &dyn Exec, keep: f64) {
        let slots = self.settings.dimensions.slots;
        let initial = view(&self.initial);
        pull_towards(exec, &self.levels.finest, initial, &mut self.v, slots, keep);
    }

    fn finish_as_is(&mut self, exec: &dyn Exec, keyframes: &Keyframes<'_, T>) -> Result<Objective, Status> {
        let (slots, threads) = (self.settings.dimensions.slots, self.settings.dimensions.threads);
        {
            let mut projection =
                Projection::carve(&self.levels, 0, slots, threads, &mut Pool::new(&mut *self.region));
            let _ = projection.project(
                exec,
                &mut Silent,
                slots,
                &mut self.v,
                None,
                self.settings.setup.projection_tolerance,
                self.sums,
            );
        }
        self.consistent_force(exec, &mut Silent)?;
        let objective = self.objective(exec, &mut Silent, keyframes).and_then(finite)?;
        self.rho.copy_from_slice(&self.region[..self.rho.len()]);
        Ok(objective)
    }
}

impl<T: Real, S: Space> Admm<'_, T, S> {
    /// Numbers that [`Self::record`] passes over.
    pub(crate) fn live(settings: &Settings) -> usize {
        let Dimensions { grid, slots, .. } = settings.dimensions;
        let vectors = if settings.params.relaxation != 1.0 { 5 } else { 4 };
        densities(&grid, slots) + (vectors * S::DIM + 2) * grid.cells() * slots + S::DIM * grid.cells()
    }

    /// The state in a checkpoint: what iterations in turn overwrite is left out, and what follows from the problem.
    pub(crate) fn record(&mut self, record: &mut Record<'_>) -> Result<(), Damaged> {
        let (mut step, mut iteration, mut history, mut largest) = (
            self.step,
            self.iteration,
            self.history,
            self.settings.setup.carrier.largest,
        );
        record.real(&mut step)?;
        record.count(&mut iteration, MANY)?;
        record.real(&mut largest)?;
        history.record(record)?;
        (
            self.step,
            self.iteration,
            self.history,
            self.settings.setup.carrier.largest,
        ) = (step, iteration, history, largest);
        record.numbers(self.rho);
        let Self {
            v,
            w,
            target,
            multiplier,
            spare,
            initial,
            ..
        } = self;
        [v, w, target, multiplier, spare, initial]
            .into_iter()
            .flatten()
            .for_each(|field| record.numbers(field));
        record.numbers(self.p);
        record.numbers(self.pbar);
        Ok(())
    }
}

/// Refuses an objective that is not finite.
fn finite(objective: Objective) -> Result<Objective, Status> {
    if objective.total().is_finite() {
        Ok(objective)
    } else {
        Err(Status::NotFinite)
    }
}

fn levels_of(grid: &Grid) -> heapless::Vec<Grid, { crate::grid::levels::MAX_LEVELS }> {
    crate::grid::levels::hierarchy(grid)
}

fn sums_len(dimensions: &Dimensions) -> usize {
    means::sums_len(&dimensions.grid, dimensions.slots).max(2 * dimensions.grid.rows() + dimensions.slots)
}
