//! The flow simulated forwards: free, with buoyancy perhaps, or driven from keyframe to keyframe. One pass is the whole solve.
//!
//! For k = 1 .. N-1: carry rho_{k-1} by v_{k-1}, take a force from rho_k, solve v_k - a v_{k-1} + Adv(v_k) + grad p = force with
//! a = 1, or less where momentum is attenuated. The forces of the result are what makes the equation hold with a = 1, so that it
//! is a result like any other; only gathered densities are not those that the flow alone would carry.

use super::drive::{Drive, PdParams, buoyancy};
use super::step::{self, Step};
use crate::checkpoint::{Damaged, Record};
use crate::exec::Exec;
use crate::field::slot::{Slot, put, put_everywhere};
use crate::field::{Vector, VectorMut, sums, view};
use crate::grid::levels::Levels;
use crate::grid::{Grid, Space};
use crate::memory::{Arena, TooSmall};
use crate::memory::{Ledger, Pool, Sharing};
use crate::objective::flow::{self, Evaluation};
use crate::objective::keyframes::Keyframes;
use crate::objective::sweep::{self, Carrier, densities};
use crate::observe::{Event, Observer, Silent};
use crate::poisson::{self, Projection};
use crate::problem::{Problem, ProblemError, positive};
use crate::progress::{Objective, Progress, Status};
use crate::real::Real;
use crate::transport::{Flow, Stop};
use core::marker::PhantomData;

/// What a caller chooses for every simulation of the flow.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SimulationParams {
    /// Upward acceleration of a free flow where the density is 1, in the scene's units; downward when negative.
    pub buoyancy: f64,
    /// Residual of an implicit step, relative to the largest velocity.
    pub tolerance: f64,
}

impl Default for SimulationParams {
    fn default() -> Self {
        Self {
            buoyancy: 0.0,
            tolerance: 1e-5,
        }
    }
}

impl SimulationParams {
    /// Checks every number.
    ///
    /// # Errors
    /// [`ProblemError`] names the first that is wrong.
    pub fn check(&self) -> Result<(), ProblemError> {
        positive("simulation.tolerance", self.tolerance)?;
        if self.buoyancy.is_finite() {
            Ok(())
        } else {
            Err(ProblemError::NotFinite {
                field: "simulation.buoyancy",
                given: self.buoyancy,
            })
        }
    }
}

/// What pushes the smoke.
#[derive(Clone, Copy, Debug)]
pub enum Push {
    /// Buoyancy alone, in scaled numbers.
    Buoyancy(f64),
    /// The next keyframe.
    Target(PdParams),
}

/// All that a simulation follows from but its densities, in scaled numbers.
#[derive(Clone, Copy, Debug)]
pub struct Settings {
    /// The grid.
    pub grid: Grid,
    /// Transport and metric; max rho_0 is set with the source.
    pub carrier: sweep::Setup,
    /// Relative tolerance of projections.
    pub projection_tolerance: f64,
    /// nu in scaled numbers.
    pub viscosity: f64,
    /// r.
    pub force_weight: f64,
    /// Relative tolerance of a step.
    pub tolerance: f64,
    /// What pushes.
    pub push: Push,
}

impl Settings {
    /// The settings of `problem`.
    #[must_use]
    pub fn new(
        problem: &Problem<'_>,
        params: &SimulationParams,
        target: Option<PdParams>,
        threads: usize,
    ) -> Self {
        Self {
            grid: problem.grid(),
            carrier: sweep::Setup::new(problem, threads),
            projection_tolerance: problem.projection_tolerance,
            viscosity: problem.scaled_viscosity(),
            force_weight: problem.scaled_force_weight(),
            tolerance: params.tolerance,
            push: target.map_or(
                Push::Buoyancy(params.buoyancy / problem.units().force),
                Push::Target,
            ),
        }
    }

    /// The settings of a step.
    fn step(&self) -> step::Setup {
        step::Setup {
            viscosity: self.viscosity,
            tolerance: self.tolerance,
            threads: self.carrier.threads,
        }
    }
}

/// The state of a simulation: every buffer but the keyframes.
#[derive(Debug)]
pub struct Forward<'m, T, S> {
    levels: Levels<'m, T>,
    /// v_1 .. v_{N-1}.
    pub(crate) v: VectorMut<'m, T>,
    /// v_0.
    pub(crate) initial: VectorMut<'m, T>,
    /// rho_0 .. rho_N.
    pub(crate) rho: &'m mut [T],
    /// The forces.
    w: VectorMut<'m, T>,
    region: &'m mut [T],
    sums: &'m mut [f64],
    settings: Settings,
    /// Whether all steps were simulated.
    marched: bool,
    space: PhantomData<S>,
}

impl<'m, T: Real, S: Space> Forward<'m, T, S> {
    /// Writes the ledger lines of [`Self::carve`], in its order.
    pub fn requirement(ledger: &mut Ledger, settings: &Settings) {
        let (grid, slots) = (settings.grid, settings.carrier.slots);
        ledger.line("densities rho_0 .. rho_N", densities(&grid, slots), T::BYTES);
        Levels::<T>::requirement(ledger, &grid, settings.carrier.metric.filters);
        ledger.vector("velocity v", S::DIM, grid.cells() * slots, T::BYTES);
        ledger.vector("force", S::DIM, grid.cells() * slots, T::BYTES);
        ledger.vector("given velocity v_0", S::DIM, grid.cells(), T::BYTES);
        ledger.line("sums of rows", 2 * grid.rows(), 8);
        Self::in_turn(ledger, settings);
    }

    fn in_turn(ledger: &mut Ledger, settings: &Settings) {
        let (grid, carrier) = (settings.grid, settings.carrier);
        ledger.group("used in turn", Sharing::InTurn, |ledger| {
            Evaluation::<T>::requirement(ledger, &grid, &carrier);
            Step::<T>::requirement(ledger, &grid, carrier.threads);
            if let Push::Target(_) = settings.push {
                Drive::<T>::requirement(ledger, &grid, carrier.metric.filters, carrier.threads);
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
        let w = arena.take_vector(S::DIM, grid.cells() * slots)?;
        let initial = arena.take_vector(S::DIM, grid.cells())?;
        let sums = arena.take(2 * grid.rows())?;
        let mut ledger = Ledger::new();
        Self::in_turn(&mut ledger, settings);
        let region = arena.take(ledger.bytes().unwrap_or(usize::MAX) / T::BYTES)?;
        Ok(Self {
            levels,
            v,
            initial,
            rho,
            w,
            region,
            sums,
            settings: *settings,
            marched: false,
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

    /// Numbers that [`Self::record`] passes over.
    pub(crate) fn live(settings: &Settings) -> usize {
        let (grid, slots) = (settings.grid, settings.carrier.slots);
        densities(&grid, slots) + S::DIM * grid.cells() * (2 * slots + 1)
    }

    /// The state in a checkpoint.
    pub(crate) fn record(&mut self, record: &mut Record<'_>) -> Result<(), Damaged> {
        let (mut marched, mut largest) = (self.marched, self.settings.carrier.largest);
        record.flag(&mut marched)?;
        record.real(&mut largest)?;
        (self.marched, self.settings.carrier.largest) = (marched, largest);
        record.numbers(self.rho);
        let Self { v, w, initial, .. } = self;
        [v, w, initial]
            .into_iter()
            .flatten()
            .for_each(|field| record.numbers(field));
        Ok(())
    }

    /// Projects v_0; the change relative to max |v_0|.
    pub(crate) fn project_initial(&mut self, exec: &dyn Exec) -> f64 {
        let (grid, threads, tolerance) = (
            &self.levels.finest,
            self.settings.carrier.threads,
            self.settings.projection_tolerance,
        );
        let projection = Projection::carve(&self.levels, 0, 1, threads, &mut Pool::new(&mut *self.region));
        poisson::project_given(
            exec,
            grid,
            projection,
            &mut self.initial,
            &mut self.w,
            tolerance,
            self.sums,
        )
    }

    /// The forces of the result, after [`Self::make_feasible`].
    pub(crate) fn force(&self) -> Vector<'_, T> {
        view(&self.w)
    }

    /// The whole pass.
    pub fn step(
        &mut self,
        exec: &dyn Exec,
        observer: &mut dyn Observer,
        keyframes: &Keyframes<'_, T>,
    ) -> Progress {
        let mut progress = Progress {
            iteration: 1,
            ..Progress::default()
        };
        let ended = match self.march(exec, observer, keyframes) {
            Ok(()) => self.make_feasible(exec, keyframes),
            Err(Stop::Cancelled) => Err(Status::Cancelled),
            Err(Stop::TooFast) => Err(Status::NotFinite),
        };
        progress.status = Some(match ended {
            Ok(objective) => {
                progress.objective = objective;
                Status::Converged
            }
            Err(status) => status,
        });
        progress
    }

    /// Simulates all steps.
    fn march(
        &mut self,
        exec: &dyn Exec,
        observer: &mut dyn Observer,
        keyframes: &Keyframes<'_, T>,
    ) -> Result<(), Stop> {
        let slots = self.settings.carrier.slots;
        put_everywhere(exec, &self.levels.finest, view(&self.initial), &mut self.v, slots);
        self.marched = false;
        if observer.on(Event::IterationBegin { iteration: 1 }).is_break() {
            return Err(Stop::Cancelled);
        }
        for k in 1..=slots {
            let kept = match self.push(exec, observer, keyframes, k) {
                Ok(kept) => kept,
                Err(stop) => return Err(self.without(exec, k - 1, stop)),
            };
            let Self {
                levels,
                v,
                initial,
                w,
                region,
                sums,
                settings,
                ..
            } = self;
            let mut step = Step::carve(levels, 0, settings.step(), &mut Pool::new(region));
            let at = |k: usize| Slot::at(k, view(initial), view(v), slots);
            let (before, earlier) = (at(k - 1), at(k.saturating_sub(2)));
            step.give(
                exec,
                [
                    (kept, before),
                    (
                        1.0,
                        Slot {
                            field: view(w),
                            slots,
                            slot: k - 1,
                        },
                    ),
                ],
            );
            step.guess(exec, [(2.0, before), (-1.0, earlier)]);
            step.advance::<S>(exec, observer, sums)?;
            put(exec, &levels.finest, view(&step.v), v, k - 1);
        }
        self.carry(exec, observer, keyframes, slots)
            .map_err(|stop| self.without(exec, slots, stop))?;
        self.marched = true;
        Ok(())
    }

    /// Puts v_0 in the place of v_step where that was too fast to carry a density: what was simulated before it is a result.
    fn without(&mut self, exec: &dyn Exec, step: usize, stop: Stop) -> Stop {
        if let (Stop::TooFast, Some(slot)) = (stop, step.checked_sub(1)) {
            put(exec, &self.levels.finest, view(&self.initial), &mut self.v, slot);
        }
        stop
    }

    /// Density k and, in slot k of w, the force that it asks for; what v_{k-1} keeps of its momentum.
    fn push(
        &mut self,
        exec: &dyn Exec,
        observer: &mut dyn Observer,
        keyframes: &Keyframes<'_, T>,
        k: usize,
    ) -> Result<f64, Stop> {
        self.carry(exec, observer, keyframes, k - 1)?;
        let Self {
            levels,
            rho,
            w,
            region,
            sums,
            settings,
            ..
        } = self;
        let grid = &levels.finest;
        let rho = &rho[k * grid.cells()..][..grid.cells()];
        Ok(match settings.push {
            Push::Buoyancy(b) => {
                buoyancy(exec, grid, b, rho, w, k - 1);
                1.0
            }
            Push::Target(pd) => {
                let (target, steps) = next_target(keyframes, k, grid.cells());
                let mut drive = Drive::carve(
                    levels,
                    settings.carrier.metric,
                    settings.carrier.threads,
                    &mut Pool::new(region),
                );
                drive.load(exec, rho, target);
                let [kept, impulse] = pd.step(steps);
                drive.force(exec, impulse, w, k - 1, sums);
                kept
            }
        })
    }

    /// Density `step + 1` from the one before.
    fn carry(
        &mut self,
        exec: &dyn Exec,
        observer: &mut dyn Observer,
        keyframes: &Keyframes<'_, T>,
        step: usize,
    ) -> Result<(), Stop> {
        let Self {
            levels,
            v,
            initial,
            rho,
            region,
            sums,
            settings,
            ..
        } = self;
        let (grid, flow) = (
            &levels.finest,
            Flow {
                initial: view(initial),
                v: view(v),
                along: None,
            },
        );
        let mut carrier = Carrier::carve(levels, 0, &settings.carrier, &mut Pool::new(region));
        carrier.carry_step(exec, observer, &flow, rho, step, sums)?;
        if let Push::Target(pd) = settings.push
            && pd.gathering > 0.0
        {
            let rho = &mut rho[(step + 1) * grid.cells()..][..grid.cells()];
            let (target, steps) = next_target(keyframes, step + 1, grid.cells());
            let mut drive = Drive::carve(
                levels,
                settings.carrier.metric,
                settings.carrier.threads,
                &mut Pool::new(region),
            );
            drive.load(exec, rho, target);
            drive.gather(exec, pd.gathering / steps as f64, rho, target, sums)?;
        }
        Ok(())
    }

    /// Projects v, takes the forces from it, and transports rho_0 by it, but where densities were gathered; the objective.
    pub(crate) fn make_feasible(
        &mut self,
        exec: &dyn Exec,
        keyframes: &Keyframes<'_, T>,
    ) -> Result<Objective, Status> {
        let gathered = matches!(self.settings.push, Push::Target(pd) if pd.gathering > 0.0) && self.marched;
        let Self {
            levels,
            v,
            initial,
            rho,
            w,
            region,
            sums,
            settings,
            ..
        } = self;
        let Settings {
            carrier,
            viscosity,
            force_weight,
            projection_tolerance,
            ..
        } = *settings;
        let (grid, setup) = (
            &levels.finest,
            flow::Setup {
                carrier,
                viscosity,
                force_weight,
                projection_tolerance,
            },
        );
        let keyframes = *keyframes;
        let mut evaluation = Evaluation {
            levels,
            level: 0,
            setup,
            initial: view(initial),
            rho,
            keyframes,
            region,
            sums,
        };
        let mut objective = Objective::default();
        if gathered {
            let mut carrier = Carrier::carve(levels, 0, &carrier, &mut Pool::new(&mut *evaluation.region));
            objective.data = carrier.data(exec, evaluation.rho, &evaluation.keyframes, evaluation.sums);
            evaluation
                .force::<S>(exec, &mut Silent, view(v), w)
                .map_err(|_| Status::Cancelled)?;
        } else {
            objective = evaluation.finish::<S>(exec, v, w)?;
        }
        // Where hardly any force acts the first projection leaves more than there is.
        evaluation
            .project(exec, &mut Silent, w, evaluation.setup.projection_tolerance)
            .map_err(|_| Status::Cancelled)?;
        objective.force =
            0.5 * force_weight * sums::sum_squares(exec, grid, carrier.slots, view(w), evaluation.sums);
        if objective.total().is_finite() {
            Ok(objective)
        } else {
            Err(Status::NotFinite)
        }
    }
}

/// The target of the first keyframe not before `step`, or of the last one, and the steps from the keyframe before it.
fn next_target<'a, T>(keyframes: &Keyframes<'a, T>, step: usize, cells: usize) -> (&'a [T], usize) {
    let last = keyframes.count() - 1;
    let index = keyframes.steps().position(|at| at >= step).unwrap_or(last);
    let before = keyframes.steps().take(index).last().unwrap_or(0);
    let at = keyframes.steps().nth(index).unwrap_or(before);
    (keyframes.density(index, cells), at - before)
}
