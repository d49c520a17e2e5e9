//! Adjoint control of smoke (Treuille et al. 2003, McNamara et al. 2004): L-BFGS over the forces. Every evaluation simulates the
//! flow, every gradient is the exact adjoint of the simulation (see [`evaluate`]).

pub mod evaluate;
mod start;

use crate::checkpoint::{Damaged, MANY, Record};
use crate::exec::Exec;
use crate::field::trajectory::{self, Shape};
use crate::field::{Vector, VectorMut, reborrow, rows, sums, view};
use crate::grid::levels::Levels;
use crate::grid::{Grid, Space};
use crate::memory::{Arena, TooSmall};
use crate::memory::{Ledger, Pool, Sharing};
use crate::objective::flow::{self, Evaluation};
use crate::objective::keyframes::Keyframes;
use crate::objective::sweep::{self, densities};
use crate::observe::{Event, Observer};
use crate::optimise::descent::{Descent, Function, Outcome};
use crate::optimise::lbfgs::{self, Borrowed, Fields, Initial, MAX_PAIRS, QuasiNewton};
use crate::poisson::{self, Projection};
use crate::problem::{Problem, ProblemError, positive};
use crate::progress::{Objective, Progress, Status};
use crate::real::Real;
use crate::transport::Stop;
use core::marker::PhantomData;
use evaluate::{Simulated, Warm};

/// What a caller chooses for adjoint control.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LbfgsParams {
    /// Pairs.
    pub history: usize,
    /// Stop when the objective falls by less than this times itself in an iteration, twice in a row.
    pub tolerance: f64,
    /// Whether the forces begin as those of the same scene on coarser grids.
    pub nested: bool,
}

impl Default for LbfgsParams {
    fn default() -> Self {
        Self {
            history: 8,
            tolerance: 1e-4,
            nested: false,
        }
    }
}

impl LbfgsParams {
    /// Most pairs.
    pub const MOST: usize = MAX_PAIRS;

    /// Checks every number but the pairs.
    ///
    /// # Errors
    /// [`ProblemError::NotPositive`].
    pub fn check(&self) -> Result<(), ProblemError> {
        positive("lbfgs.tolerance", self.tolerance)
    }
}

/// All that a solve follows from but its densities, in scaled numbers.
#[derive(Clone, Copy, Debug)]
pub struct Settings {
    /// The grid.
    pub grid: Grid,
    /// Keyframes.
    pub keyframes: usize,
    /// Transport and metric; max rho_0 is set with the source.
    pub carrier: sweep::Setup,
    /// Relative tolerance of projections.
    pub projection_tolerance: f64,
    /// nu in scaled numbers.
    pub viscosity: f64,
    /// r.
    pub force_weight: f64,
    /// Relative tolerance of a step.
    pub step_tolerance: f64,
    /// Iterations at most.
    pub iterations: usize,
    /// The caller's choices.
    pub params: LbfgsParams,
}

impl Settings {
    /// The settings of `problem`.
    #[must_use]
    pub fn new(
        problem: &Problem<'_>,
        params: &LbfgsParams,
        step_tolerance: f64,
        threads: usize,
        iterations: usize,
    ) -> Self {
        Self {
            grid: problem.grid(),
            keyframes: problem.keyframes.len(),
            carrier: sweep::Setup::new(problem, threads),
            projection_tolerance: problem.projection_tolerance,
            viscosity: problem.scaled_viscosity(),
            force_weight: problem.scaled_force_weight(),
            step_tolerance,
            iterations,
            params: *params,
        }
    }
}

/// The state of adjoint control: every buffer but the keyframes.
#[derive(Debug)]
pub struct Lbfgs<'m, T, S> {
    levels: Levels<'m, T>,
    /// The flow of the forces.
    pub(crate) v: VectorMut<'m, T>,
    /// The forces u_0 .. u_{N-2}.
    u: VectorMut<'m, T>,
    /// v_0.
    pub(crate) initial: VectorMut<'m, T>,
    /// rho_0 .. rho_N.
    pub(crate) rho: &'m mut [T],
    /// Gradients, directions, pairs and work, or the coarse solve before them.
    rest: &'m mut [T],
    sums: &'m mut [f64],
    settings: Settings,
    descent: Descent,
    begun: bool,
    iteration: usize,
    space: PhantomData<S>,
}

impl<'m, T: Real, S: Space> Lbfgs<'m, T, S> {
    /// Writes the ledger lines of [`Self::carve`], in its order.
    pub fn requirement(ledger: &mut Ledger, settings: &Settings) {
        let (grid, slots) = (settings.grid, settings.carrier.slots);
        ledger.line("densities rho_0 .. rho_N", densities(&grid, slots), T::BYTES);
        Levels::<T>::requirement(ledger, &grid, settings.carrier.metric.filters);
        ledger.vector("velocity v", S::DIM, grid.cells() * slots, T::BYTES);
        ledger.vector("force u", S::DIM, grid.cells() * slots, T::BYTES);
        ledger.vector("given velocity v_0", S::DIM, grid.cells(), T::BYTES);
        ledger.line(
            "sums of rows",
            lbfgs::sums_per_row(settings.params.history) * grid.rows(),
            8,
        );
        Self::rest(ledger, settings);
    }

    /// The lines of `rest`.
    fn rest(ledger: &mut Ledger, settings: &Settings) {
        let (grid, carrier) = (settings.grid, settings.carrier);
        ledger.group("L-BFGS", Sharing::Together, |ledger| {
            ledger.line(
                "gradients, directions and pairs",
                lbfgs::numbers(&grid, carrier.slots, settings.params.history),
                T::BYTES,
            );
            Simulated::<T>::requirement(ledger, &grid, &carrier);
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
        let u = arena.take_vector(S::DIM, grid.cells() * slots)?;
        let initial = arena.take_vector(S::DIM, grid.cells())?;
        let sums = arena.take(lbfgs::sums_per_row(settings.params.history) * grid.rows())?;
        let mut ledger = Ledger::new();
        Self::rest(&mut ledger, settings);
        let rest = arena.take(ledger.bytes().unwrap_or(usize::MAX) / T::BYTES)?;
        let descent = Descent::new(settings.params.history);
        Ok(Self {
            levels,
            v,
            u,
            initial,
            rho,
            rest,
            sums,
            settings: *settings,
            descent,
            begun: false,
            iteration: 0,
            space: PhantomData,
        })
    }

    /// The grid.
    pub(crate) fn grid(&self) -> &Grid {
        &self.levels.finest
    }

    /// Slots T.
    pub(crate) fn slots(&self) -> usize {
        self.settings.carrier.slots
    }

    /// Sets rho_0 and its maximum.
    pub(crate) fn set_source(&mut self, density: &[T], largest: f64) {
        self.rho[..density.len()].copy_from_slice(density);
        self.settings.carrier.largest = largest;
    }

    /// Numbers of quasi-Newton's fields, which are the first of `rest`: the rest of it is work.
    fn pairs(settings: &Settings) -> usize {
        lbfgs::numbers(&settings.grid, settings.carrier.slots, settings.params.history)
    }

    /// Numbers that [`Self::record`] passes over.
    pub(crate) fn live(settings: &Settings) -> usize {
        let (grid, slots) = (settings.grid, settings.carrier.slots);
        densities(&grid, slots) + S::DIM * grid.cells() * (2 * slots + 1) + Self::pairs(settings)
    }

    /// The state in a checkpoint.
    pub(crate) fn record(&mut self, record: &mut Record<'_>) -> Result<(), Damaged> {
        let (mut descent, mut begun, mut iteration, mut largest) = (
            self.descent.clone(),
            self.begun,
            self.iteration,
            self.settings.carrier.largest,
        );
        record.flag(&mut begun)?;
        record.count(&mut iteration, MANY)?;
        record.real(&mut largest)?;
        descent.record(record)?;
        (
            self.descent,
            self.begun,
            self.iteration,
            self.settings.carrier.largest,
        ) = (descent, begun, iteration, largest);
        record.numbers(self.rho);
        let Self { v, u, initial, .. } = self;
        [v, u, initial]
            .into_iter()
            .flatten()
            .for_each(|field| record.numbers(field));
        record.numbers(&mut self.rest[..Self::pairs(&self.settings)]);
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
        view(&self.u)
    }

    /// One iteration.
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
        self.iteration += 1;
        progress.iteration = self.iteration;
        progress.direct.cells = self.grid().n;
        if observer
            .on(Event::IterationBegin {
                iteration: self.iteration,
            })
            .is_break()
        {
            return Err(Status::Cancelled);
        }
        if !self.begun {
            self.begin(exec, observer, keyframes)?;
        }
        let mut descent = core::mem::replace(&mut self.descent, Descent::new(self.settings.params.history));
        let tolerance = self.settings.params.tolerance;
        let outcome = descent.iterate::<T, S>(
            exec,
            observer,
            &mut self.work(keyframes),
            tolerance,
            &mut progress.direct,
        );
        match outcome {
            Ok((outcome, objective)) => {
                progress.objective = objective;
                self.descent = descent;
                match outcome {
                    Outcome::Goes if self.descent.iterations < self.settings.iterations => Ok(()),
                    Outcome::Goes => Err(Status::MaxIterations),
                    Outcome::Converged => Err(Status::Converged),
                    Outcome::Stalled => Err(Status::Stalled),
                    Outcome::NotFinite => Err(Status::NotFinite),
                }
            }
            Err(Stop::Cancelled) => Err(Status::Cancelled),
            Err(Stop::TooFast) => Err(Status::NotFinite),
        }
    }

    fn work<'a>(&'a mut self, keyframes: &Keyframes<'a, T>) -> Work<'a, 'm, T> {
        let Settings {
            grid,
            carrier,
            viscosity,
            force_weight,
            projection_tolerance,
            step_tolerance,
            params,
            ..
        } = self.settings;
        let mut pool = Pool::new(&mut *self.rest);
        let fields = lbfgs::take(&grid, carrier.slots, params.history, &mut pool);
        let setup = flow::Setup {
            carrier,
            viscosity,
            force_weight,
            projection_tolerance,
        };
        let keyframes = *keyframes;
        let evaluation = Evaluation {
            levels: &self.levels,
            level: 0,
            setup,
            initial: view(&self.initial),
            rho: self.rho,
            keyframes,
            region: pool.into_rest(),
            sums: self.sums,
        };
        let simulated = Simulated {
            evaluation,
            tolerance: step_tolerance,
        };
        Work {
            simulated,
            v: reborrow(&mut self.v),
            u: reborrow(&mut self.u),
            fields,
            change: None,
        }
    }

    /// The flow projected, its densities, and the forces that make it; the objective.
    pub(crate) fn make_feasible(
        &mut self,
        exec: &dyn Exec,
        keyframes: &Keyframes<'_, T>,
    ) -> Result<Objective, Status> {
        self.descent = Descent::new(self.settings.params.history);
        let Work {
            mut simulated,
            mut v,
            mut u,
            ..
        } = self.work(keyframes);
        simulated.evaluation.finish::<S>(exec, &mut v, &mut u)
    }
}

/// What an iteration uses.
struct Work<'a, 'm, T> {
    simulated: Simulated<'a, 'm, T>,
    v: VectorMut<'a, T>,
    u: VectorMut<'a, T>,
    fields: Fields<'a, T>,
    /// The direction that u was moved along, and how far in all, since v was its flow.
    change: Option<(usize, f64)>,
}

impl<'a, T> Work<'a, '_, T> {
    fn shape(&self) -> Shape<'a> {
        let Evaluation {
            levels, level, setup, ..
        } = &self.simulated.evaluation;
        Shape {
            grid: &levels.grids[*level],
            slots: setup.carrier.slots,
        }
    }

    /// The first inverse Hessian 1 / r: exact where the data term is flat.
    fn initial(&self) -> Initial<'a> {
        Initial {
            line: None,
            scale: 1.0 / self.simulated.evaluation.setup.force_weight,
        }
    }
}

impl<T: Real, S: Space> Function<T, S> for Work<'_, '_, T> {
    fn direction(
        &mut self,
        exec: &dyn Exec,
        _observer: &mut dyn Observer,
        newton: &mut QuasiNewton,
    ) -> Result<f64, Stop> {
        let shape = self.shape();
        let slope = newton.descend(exec, shape, &mut self.fields);
        let (direction, sums) = (
            view(&self.fields[newton.direction]),
            &mut *self.simulated.evaluation.sums,
        );
        let largest = sums::max_abs(exec, shape.grid, shape.slots, direction, sums);
        Ok(if largest.is_finite() { slope } else { f64::NAN })
    }

    fn move_along(&mut self, exec: &dyn Exec, direction: usize, s: f64) {
        let shape = self.shape();
        trajectory::add(exec, shape, &mut self.u, 1.0, s, view(&self.fields[direction]));
        self.change = Some((direction, self.change.map_or(0.0, |(_, before)| before) + s));
    }

    fn retreat(&mut self, exec: &dyn Exec, keep: f64) {
        for component in &mut self.u {
            if keep == 0.0 {
                component.fill(T::ZERO);
            } else {
                rows::scale_in_place(component, T::from_f64(keep));
            }
        }
        self.simulated.evaluation.retreat(exec, &mut self.v, keep);
    }

    fn value(
        &mut self,
        exec: &dyn Exec,
        observer: &mut dyn Observer,
        work: usize,
        bound: f64,
    ) -> Result<Objective, Stop> {
        let mut v = core::mem::take(&mut self.fields[work]);
        let change = self.change.map_or((view(&self.u), 0.0), |(direction, s)| {
            (view(&self.fields[direction]), s)
        });
        let value = self.simulated.value::<S>(
            exec,
            observer,
            view(&self.u),
            Warm {
                v: view(&self.v),
                change,
            },
            &mut v,
            bound,
        );
        self.fields[work] = v;
        value
    }

    fn gradient(
        &mut self,
        exec: &dyn Exec,
        observer: &mut dyn Observer,
        work: usize,
        into: usize,
    ) -> Result<(), Stop> {
        let mut gradient = core::mem::take(&mut self.fields[into]);
        let v = view(&self.fields[work]);
        let done = self
            .simulated
            .gradient::<S>(exec, observer, view(&self.u), v, &mut gradient);
        if done.is_ok() {
            let shape = self.shape();
            trajectory::add(exec, shape, &mut self.v, 0.0, 1.0, view(&self.fields[work]));
        }
        self.fields[into] = gradient;
        done
    }

    fn arrive(&mut self, exec: &dyn Exec, newton: &mut QuasiNewton, borrowed: Borrowed, step: Option<f64>) {
        let initial = self.initial();
        newton.arrive(
            exec,
            self.shape(),
            &mut self.fields,
            borrowed,
            step,
            &initial,
            self.simulated.evaluation.sums,
        );
    }
}
