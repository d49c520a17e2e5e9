//! The direct method (mathematics section 6): no splitting. For any flow free of divergence the force that produces it is
//! w_k = P[v_k - v_{k-1} + Adv(v_k)], so the objective is a function of the flow alone, without constraints:
//!
//! ```text
//! F(v) = 1/2 <e, C e>(v) + r/2 sum |w_k(v)|^2
//! g_k  = Q[r (w_k - w_{k+1} + J(v_k)^T w_k) - A_v^T mu_k]
//! ```
//!
//! Every iterate is a feasible animation and no flow is ever simulated. F is minimised by L-BFGS, whose first inverse Hessian is
//! exact in time for a flow at rest; it begins on coarser grids (see [`crate::objective::coarse`]) in the bytes of the finest grid's work.

mod descend;
mod level;
mod start;

use crate::checkpoint::{Damaged, MANY, Record};
use crate::exec::Exec;
use crate::field::{Vector, VectorMut};
use crate::grid::levels::{self, Levels};
use crate::grid::{Grid, Space};
use crate::memory::{Arena, TooSmall};
use crate::memory::{Ledger, Pool, Sharing, pooled};
use crate::objective::coarse;
use crate::objective::keyframes::Keyframes;
use crate::objective::sweep::{self, densities};
use crate::observe::{Event, Observer};
use crate::optimise::descent::{Descent, Outcome};
use crate::optimise::lbfgs::{self, MAX_PAIRS};
use crate::poisson::{self, Projection};
use crate::problem::{Problem, ProblemError, positive};
use crate::progress::{Progress, Status};
use crate::real::Real;
use core::marker::PhantomData;
use level::Sizes;

/// Scale K of the first inverse Hessian (K + r S)^-1, in scaled numbers.
const STIFFNESS: f64 = 1e3;

/// Iterations at most on the coarsest grid, where they cost nothing, and on those between it and the finest.
const COARSE_ITERATIONS: [usize; 2] = [100, 60];
/// Their tolerance in parts of the finest grid's: a plateau there is seldom the end, and to go on costs little.
const COARSE_TOLERANCE: f64 = 1e-2;

/// Iterations at most on grid `level` > 0, of which `coarsest` is the last.
fn coarse_iterations(level: usize, coarsest: usize) -> usize {
    COARSE_ITERATIONS[usize::from(level < coarsest)]
}

/// What a caller chooses for the direct method.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DirectParams {
    /// Pairs of L-BFGS; by default as many as the ceiling allows, at most [`DirectParams::MOST_BY_DEFAULT`].
    pub history: Option<usize>,
    /// Stop when the objective falls by less than this times itself in an iteration, twice in a row.
    pub tolerance: f64,
    /// Whether the flow begins as that of the same scene on coarser grids.
    pub nested: bool,
}

impl Default for DirectParams {
    fn default() -> Self {
        Self {
            history: None,
            tolerance: 1e-4,
            nested: true,
        }
    }
}

impl DirectParams {
    /// Pairs when nothing is said and memory is plenty.
    pub const MOST_BY_DEFAULT: usize = 5;
    /// Most pairs.
    pub const MOST: usize = MAX_PAIRS;

    /// Checks every number.
    ///
    /// # Errors
    /// [`ProblemError::NotPositive`] names the first that is wrong.
    pub fn check(&self) -> Result<(), ProblemError> {
        positive("direct.tolerance", self.tolerance)
    }

    /// Iterations of a solve at most, those on coarser grids included, of which `on_finest` on the finest.
    #[must_use]
    pub fn most_iterations(&self, problem: &Problem<'_>, on_finest: usize) -> usize {
        let grids = levels::hierarchy(&problem.grid());
        let coarser = grids
            .windows(2)
            .take_while(|pair| self.nested && coarse::begins_on(&pair[0], &pair[1]))
            .count();
        (1..=coarser)
            .map(|level| coarse_iterations(level, coarser))
            .fold(on_finest, usize::saturating_add)
    }
}

/// All that a solve follows from but its densities, in scaled numbers.
#[derive(Clone, Copy, Debug)]
pub struct Settings {
    /// The finest grid.
    pub grid: Grid,
    /// Pairs of L-BFGS.
    pub history: usize,
    /// Keyframes.
    pub keyframes: usize,
    /// Transport and metric on the finest grid; max rho_0 is set with the source.
    pub carrier: sweep::Setup,
    /// Relative tolerance of projections.
    pub projection_tolerance: f64,
    /// nu in scaled numbers.
    pub viscosity: f64,
    /// r.
    pub force_weight: f64,
    /// Iterations on the finest grid at most.
    pub iterations: usize,
    /// Whether two steps are one on the coarser grids: where every keyframe's step is even and leaves a slot to steer by.
    pub halves_time: bool,
    /// The caller's choices.
    pub params: DirectParams,
}

impl Settings {
    /// The settings of `problem` with so many pairs; whether two threads may do different works, for which there is memory then.
    #[must_use]
    pub fn new(
        problem: &Problem<'_>,
        params: &DirectParams,
        history: usize,
        threads: usize,
        tandem: bool,
        iterations: usize,
    ) -> Self {
        Self {
            grid: problem.grid(),
            history,
            keyframes: problem.keyframes.len(),
            carrier: sweep::Setup {
                tandem,
                ..sweep::Setup::new(problem, threads)
            },
            projection_tolerance: problem.projection_tolerance,
            viscosity: problem.scaled_viscosity(),
            force_weight: problem.scaled_force_weight(),
            iterations,
            halves_time: problem.steps.is_multiple_of(2)
                && problem
                    .keyframes
                    .iter()
                    .all(|&step| step.is_multiple_of(2) && step >= 4),
            params: *params,
        }
    }
}

/// The direct method's state: every buffer but the keyframes of the finest grid.
#[derive(Debug)]
pub struct Direct<'m, T, S> {
    levels: Levels<'m, T>,
    /// Velocities v_k.
    pub(crate) v: VectorMut<'m, T>,
    /// v_0.
    pub(crate) initial: VectorMut<'m, T>,
    /// rho_0 .. rho_N.
    pub(crate) rho: &'m mut [T],
    /// Gradients, directions, pairs and work of the finest grid, or the coarser grids before it.
    rest: &'m mut [T],
    pivots: &'m mut [f64],
    sums: &'m mut [f64],
    settings: Settings,
    /// Threads on each grid that takes part, finest first.
    threads: level::Threads,
    /// The grid that is worked on, or `None` before the first iteration.
    level: Option<usize>,
    descent: Descent,
    iteration: usize,
    space: PhantomData<S>,
}

impl<'m, T: Real, S: Space> Direct<'m, T, S> {
    /// Writes the ledger lines of [`Self::carve`], in its order.
    pub fn requirement(ledger: &mut Ledger, settings: &Settings) {
        let (grid, slots) = (settings.grid, settings.carrier.slots);
        let (cells, len) = (grid.cells(), grid.cells() * slots);
        ledger.line("densities rho_0 .. rho_N", densities(&grid, slots), T::BYTES);
        Levels::<T>::requirement(ledger, &grid, settings.carrier.metric.filters);
        ledger.vector("velocity v", S::DIM, len, T::BYTES);
        ledger.vector("given velocity v_0", S::DIM, cells, T::BYTES);
        ledger.line(
            "sums of rows",
            lbfgs::sums_per_row(settings.history) * grid.rows(),
            8,
        );
        ledger.line("pivots in time", slots, 8);
        Self::in_turn(ledger, settings);
    }

    /// The lines of the bytes that the finest grid and the coarser ones use in turn.
    fn in_turn(ledger: &mut Ledger, settings: &Settings) {
        ledger.group("used in turn", Sharing::InTurn, |ledger| {
            Sizes::<T>::requirement(ledger, settings, 0, settings.carrier.threads);
            if level::Threads::new::<T>(settings).len() > 1 {
                ledger.line(
                    "coarser grids before",
                    Sizes::<T>::new(settings, 1, 1).all(),
                    T::BYTES,
                );
            }
        });
    }

    /// Takes its buffers.
    ///
    /// # Errors
    /// [`TooSmall`].
    #[inline(never)]
    pub fn carve(arena: &mut Arena<'m>, settings: &Settings) -> Result<Self, TooSmall> {
        let (grid, slots) = (settings.grid, settings.carrier.slots);
        let rho = arena.take(densities(&grid, slots))?;
        let levels = Levels::carve(arena, &grid, settings.carrier.metric.filters)?;
        let v = arena.take_vector(S::DIM, grid.cells() * slots)?;
        let initial = arena.take_vector(S::DIM, grid.cells())?;
        let sums = arena.take(lbfgs::sums_per_row(settings.history) * grid.rows())?;
        let pivots = arena.take(slots)?;
        let mut ledger = Ledger::new();
        Self::in_turn(&mut ledger, settings);
        let rest = arena.take(ledger.bytes().unwrap_or(usize::MAX) / T::BYTES)?;
        Ok(Self {
            levels,
            v,
            initial,
            rho,
            rest,
            pivots,
            sums,
            settings: *settings,
            threads: level::Threads::new::<T>(settings),
            level: None,
            descent: Descent::new(settings.history),
            iteration: 0,
            space: PhantomData,
        })
    }

    /// The finest grid.
    pub(crate) fn grid(&self) -> &Grid {
        &self.levels.finest
    }

    /// Sets rho_0 and its maximum.
    pub(crate) fn set_source(&mut self, density: &[T], largest: f64) {
        self.rho[..density.len()].copy_from_slice(density);
        self.settings.carrier.largest = largest;
    }

    /// Slots T.
    pub(crate) fn slots(&self) -> usize {
        self.settings.carrier.slots
    }

    /// Numbers that [`Self::record`] passes over.
    pub(crate) fn live(settings: &Settings) -> usize {
        let (grid, slots) = (settings.grid, settings.carrier.slots);
        densities(&grid, slots) + S::DIM * grid.cells() * (slots + 1) + level::live::<T>(settings)
    }

    /// The state in a checkpoint.
    pub(crate) fn record(&mut self, record: &mut Record<'_>) -> Result<(), Damaged> {
        let (mut level, mut descent, mut iteration, mut largest) = (
            self.level,
            self.descent.clone(),
            self.iteration,
            self.settings.carrier.largest,
        );
        let coarsest = self.threads.len() - 1;
        record.option(&mut level, |record, level| record.count(level, coarsest))?;
        record.count(&mut iteration, MANY)?;
        record.real(&mut largest)?;
        descent.record(record)?;
        (
            self.level,
            self.descent,
            self.iteration,
            self.settings.carrier.largest,
        ) = (level, descent, iteration, largest);
        record.numbers(self.rho);
        let Self { v, initial, .. } = self;
        [v, initial]
            .into_iter()
            .flatten()
            .for_each(|field| record.numbers(field));
        record.numbers(&mut self.rest[..level::live::<T>(&self.settings)]);
        Ok(())
    }

    /// Projects v_0; the change relative to max |v_0|.
    pub(crate) fn project_initial(&mut self, exec: &dyn Exec) -> f64 {
        let (grid, threads, tolerance) = (
            &self.levels.finest,
            self.settings.carrier.threads,
            self.settings.projection_tolerance,
        );
        let mut pool = Pool::new(&mut *self.rest);
        let mut copy = pool.take_vector(S::DIM, grid.cells());
        let projection = Projection::carve(&self.levels, 0, 1, threads, &mut pool);
        poisson::project_given(
            exec,
            grid,
            projection,
            &mut self.initial,
            &mut copy,
            tolerance,
            self.sums,
        )
    }

    /// The forces of the result, after [`Self::make_feasible`].
    pub(crate) fn force(&self) -> Vector<'_, T> {
        let len = self.grid().cells() * self.slots();
        let start = self.descent.newton.direction * S::DIM * pooled(len);
        core::array::from_fn(|axis| {
            if axis < S::DIM {
                &self.rest[start + axis * pooled(len)..][..len]
            } else {
                &[]
            }
        })
    }

    /// Iterations on grid `level` at most.
    fn iterations_on(&self, level: usize) -> usize {
        if level == 0 {
            self.settings.iterations
        } else {
            coarse_iterations(level, self.threads.len() - 1)
        }
    }

    /// What an iteration on grid `level` must gain, in parts of the objective.
    fn tolerance_on(&self, level: usize) -> f64 {
        let tolerance = self.settings.params.tolerance;
        if level == 0 {
            tolerance
        } else {
            COARSE_TOLERANCE * tolerance
        }
    }

    /// One iteration, on the grid that the solve has come to.
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

    /// The step's body; an error is how the solve ended.
    fn iterate(
        &mut self,
        exec: &dyn Exec,
        observer: &mut dyn Observer,
        keyframes: &Keyframes<'_, T>,
        progress: &mut Progress,
    ) -> Result<(), Status> {
        let level = match self.level {
            Some(level) => level,
            None => self.begin(exec, keyframes),
        };
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
        let outcome = self.descend(exec, observer, keyframes, progress)?;
        match outcome {
            Outcome::Goes if self.descent.iterations < self.iterations_on(level) => Ok(()),
            _ if level > 0 => self.ascend(exec, observer, keyframes),
            Outcome::Goes => Err(Status::MaxIterations),
            Outcome::Converged => Err(Status::Converged),
            Outcome::Stalled => Err(Status::Stalled),
            Outcome::NotFinite => Err(Status::NotFinite),
        }
    }
}
