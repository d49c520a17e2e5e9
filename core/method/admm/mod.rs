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
mod history;
mod nested;
pub mod params;
mod report;
mod update_density;
mod update_multiplier;
mod update_velocity;

use crate::checkpoint::{Damaged, MANY, Mix, Record};
use crate::exec::Exec;
use crate::field::slot::{RETREATS, pull_towards};
use crate::field::trajectory;
use crate::field::{Vector, VectorMut, means, view};
use crate::grid::{Grid, Space};
use crate::memory::{Layout, Ledger, Pool, TooSmall};
use crate::method::animation::Animation;
use crate::method::contract::{Contract, Measure, Parts};
use crate::method::params::Params;
use crate::method::refusal::PlanError;
use crate::nso::damping::LocalDamping;
use crate::nso::{self, Bases, NsoSolver, SmootherMemory, Workspace, newton};
use crate::objective::flow;
use crate::objective::keyframes::Keyframes;
use crate::observe::{Observer, Silent};
use crate::poisson::Projection;
use crate::problem::Problem;
use crate::progress::{Objective, Progress, Status};
use crate::real::Real;
use core::marker::PhantomData;
use history::History;
use params::AdmmParams;
use report::Course;

/// All that a solve follows from but its densities, in scaled numbers.
#[derive(Clone, Copy, Debug)]
pub struct Setup {
    /// The finest grid.
    pub grid: Grid,
    /// AO's numbers, the objective among them; max rho_0 is set with the source.
    pub ao: ao::Setup,
    /// The caller's choices.
    pub params: AdmmParams,
    /// How the smoother uses memory.
    pub memory: SmootherMemory,
    /// Outer iterations at most.
    pub iterations: usize,
}

impl Setup {
    /// That of `problem`.
    #[must_use]
    pub fn new(problem: &Problem<'_>, params: &Params) -> Self {
        let admm = params.admm;
        let units = problem.units();
        Self {
            grid: problem.grid(),
            ao: ao::Setup {
                penalty: admm.penalty * units.velocity * units.velocity,
                iterations: admm.ao_iterations,
                momentum: admm.ao_momentum,
                flow: flow::Setup::new(problem, params.threads),
            },
            params: admm,
            memory: admm.memory.unwrap_or(SmootherMemory::LEAST),
            iterations: params.iterations,
        }
    }
}

impl Setup {
    /// How the Navier-Stokes problem of an iteration is posed and solved.
    fn nso(&self) -> nso::Setup {
        let flow::Setup {
            sweep,
            viscosity,
            force_weight,
            projection_tolerance,
        } = self.ao.flow;
        nso::Setup {
            kappa: self.ao.penalty / force_weight,
            viscosity,
            slots: sweep.slots,
            threads: sweep.threads,
            params: self.params.nso,
            damping: LocalDamping::USUAL,
            memory: self.memory,
            projection_tolerance,
        }
    }
}

/// ADMM's state.
#[derive(Debug)]
pub struct Admm<'m, T, S> {
    animation: Animation<'m, T>,
    bases: Bases<'m, T>,
    /// Forces w_k; AO's direction.
    w: VectorMut<'m, T>,
    p: &'m mut [T],
    pbar: &'m mut [T],
    /// v* during AO, t during NSO.
    target: VectorMut<'m, T>,
    /// lambda / K during AO; during NSO free for damping once it is not needed.
    multiplier: VectorMut<'m, T>,
    /// A field of its own for damping, when beta is not 1; otherwise empty.
    spare: VectorMut<'m, T>,
    /// What AO and NSO use in turn.
    region: &'m mut [T],
    setup: Setup,
    step: f64,
    iteration: usize,
    history: History,
    space: PhantomData<S>,
}

impl<'m, T: Real, S: Space> Admm<'m, T, S> {
    /// That of `setup`, without its buffers.
    #[inline(never)]
    fn with(setup: &Setup) -> Self {
        let sweep = &setup.ao.flow.sweep;
        let animation = Animation::new(&setup.grid, sweep.slots, sweep.metric.filters);
        Self {
            bases: Bases::bare(&animation.levels.grids),
            animation,
            w: Default::default(),
            p: &mut [],
            pbar: &mut [],
            target: Default::default(),
            multiplier: Default::default(),
            spare: Default::default(),
            region: &mut [],
            setup: *setup,
            step: 1.0,
            iteration: 0,
            history: History::default(),
            space: PhantomData,
        }
    }

    /// What AO and NSO take of a region in turn, by `setup`.
    fn measure(&self, setup: &Setup, ledger: &mut Ledger) {
        let (levels, bases) = (&self.animation.levels, &self.bases);
        let sweep = setup.ao.flow.sweep;
        let mut pool = Pool::measuring(ledger);
        ao::measure(levels, &setup.ao, &mut pool);
        let nso = setup.nso();
        match nso.params.solver {
            NsoSolver::Stfas => {
                Workspace::<T, S>::carve(levels, bases, &nso, &mut pool);
            }
            NsoSolver::NewtonCg => newton::measure(levels, &nso, &mut pool),
        }
        self.animation.measure_initial(sweep.threads, ledger);
    }

    fn slots(&self) -> usize {
        self.animation.slots
    }

    fn threads(&self) -> usize {
        self.setup.ao.flow.sweep.threads
    }
}

impl<'m, T: Real, S: Space> Contract<'m, T, S> for Admm<'m, T, S> {
    fn new(problem: &Problem<'_>, params: &Params) -> Self {
        Self::with(&Setup::new(problem, params))
    }

    /// The fastest way of using memory within the ceiling and the paper's bound. Where none keeps both, the fastest within the ceiling,
    /// or the least memory where none keeps that; without a ceiling the fastest of all.
    fn fit(problem: &Problem<'_>, params: &Params, measure: &Measure<'_>) -> Result<Params, PlanError> {
        let with = |memory: SmootherMemory| {
            let admm = AdmmParams {
                memory: Some(memory),
                ..params.admm
            };
            Params { admm, ..*params }
        };
        if let Some(memory) = params.admm.memory {
            return Ok(with(memory));
        }
        let (mut fastest, mut within_ceiling) = (None, None);
        let mut smallest: Option<(usize, SmootherMemory)> = None;
        for memory in SmootherMemory::all::<T, S>(&problem.grid()) {
            let size = measure(&with(memory))?;
            let fits = params.ceiling.is_none_or(|ceiling| size.bytes <= ceiling);
            if fits && size.method <= size.paper_bound {
                return Ok(with(memory));
            }
            if fits {
                within_ceiling = within_ceiling.or(Some(memory));
            }
            if smallest.is_none_or(|(bytes, _)| size.bytes < bytes) {
                smallest = Some((size.bytes, memory));
            }
            fastest = fastest.or(Some(memory));
        }
        let chosen = if params.ceiling.is_some() {
            within_ceiling.or(smallest.map(|(_, memory)| memory))
        } else {
            fastest
        };
        chosen.map(with).ok_or(PlanError::TooLarge)
    }

    fn mix(params: &Params, mix: &mut Mix) {
        params.admm.mix(mix);
    }

    fn animation(&self) -> &Animation<'m, T> {
        &self.animation
    }

    fn parts(&mut self) -> Parts<'_, 'm, T> {
        Parts {
            animation: &mut self.animation,
            setup: &mut self.setup.ao.flow,
            region: self.region,
        }
    }

    fn layout(&mut self, layout: &mut Layout<'_, 'm, T>) -> Result<(), TooSmall> {
        let grid = self.setup.grid;
        let len = grid.cells() * self.slots();
        let sums = means::sums_len(&grid, self.slots()).max(2 * grid.rows() + self.slots());
        self.animation.layout(layout, sums)?;
        layout.tables(|arena| {
            self.bases = Bases::carve::<S>(arena, &self.animation.levels.grids)?;
            Ok(())
        })?;
        layout.keep_vector("force w (AO: direction)", &mut self.w, S::DIM, len)?;
        layout.keep_vector("target t (AO: v*)", &mut self.target, S::DIM, len)?;
        layout.keep_vector(
            "multiplier lambda / K (NSO: damping)",
            &mut self.multiplier,
            S::DIM,
            len,
        )?;
        if self.setup.params.relaxation != 1.0 {
            let name = "damping of NSO beside the multiplier (beta is not 1)";
            layout.keep_vector(name, &mut self.spare, S::DIM, len)?;
        }
        layout.keep("pressure p", &mut self.p, len)?;
        layout.keep("pressure pbar", &mut self.pbar, len)?;
        let mut region = core::mem::take(&mut self.region);
        let done = layout.in_turn(&mut region, 0, |ledger| self.measure(&self.setup, ledger));
        self.region = region;
        done
    }

    fn scalars(&mut self, record: &mut Record<'_>) -> Result<(), Damaged> {
        let (mut step, mut iteration, mut history) = (self.step, self.iteration, self.history);
        record.real(&mut step)?;
        record.count(&mut iteration, MANY)?;
        history.record(record)?;
        (self.step, self.iteration, self.history) = (step, iteration, history);
        Ok(())
    }

    fn step(
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
        progress.begin(self.iteration, observer)?;
        let mut course = Course::default();
        let ended = self.alternate(exec, observer, keyframes, progress, &mut course);
        course.tell(&mut progress.report);
        ended
    }

    /// Projects v, takes w from it and transports rho_0 by it. A flow that is not finite, or too fast to be transported, is taken back
    /// towards v_0 until it is.
    fn finish(&mut self, exec: &dyn Exec, keyframes: &Keyframes<'_, T>) -> Result<Objective, Status> {
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

    fn force(&self) -> Vector<'_, T> {
        view(&self.w)
    }
}

impl<T: Real, S: Space> Admm<'_, T, S> {
    /// The three updates and the check.
    fn alternate(
        &mut self,
        exec: &dyn Exec,
        observer: &mut dyn Observer,
        keyframes: &Keyframes<'_, T>,
        progress: &mut Progress,
        course: &mut Course,
    ) -> Result<(), Status> {
        let mut carried = self.update_density(exec, observer, keyframes, course);
        // A flow from a coarser grid may be too fast for this one.
        for keep in RETREATS {
            if carried != Err(Status::NotFinite) {
                break;
            }
            self.retreat(exec, keep);
            carried = self.update_density(exec, observer, keyframes, course);
        }
        carried?;
        let improved = self
            .update_velocity(exec, observer, course)
            .and_then(|()| self.objective(exec, observer, keyframes))
            .and_then(finite);
        if improved == Err(Status::NotFinite) {
            self.return_to_star(exec);
        }
        progress.objective = improved?;
        self.update_multiplier(exec, course)?;
        self.check(progress.objective, course)
    }

    /// v = v*, the last flow that was carried to its end, in the place of one that is not finite or too fast; v = t where damping overwrote
    /// lambda / K.
    fn return_to_star(&mut self, exec: &dyn Exec) {
        let lost = self.history.damped && self.spare[0].is_empty();
        let Animation { levels, v, slots, .. } = &mut self.animation;
        let shape = trajectory::Shape {
            grid: &levels.finest,
            slots: *slots,
        };
        trajectory::add(exec, shape, v, 0.0, 1.0, view(&self.target));
        if !lost {
            trajectory::add(exec, shape, v, 1.0, 1.0, view(&self.multiplier));
        }
        self.p.fill(T::ZERO);
        self.pbar.fill(T::ZERO);
    }

    /// Takes the flow back towards v_0 in all time levels: `keep` of the way from there is left.
    fn retreat(&mut self, exec: &dyn Exec, keep: f64) {
        let Animation {
            levels,
            v,
            initial,
            slots,
            ..
        } = &mut self.animation;
        pull_towards(exec, &levels.finest, view(initial), v, *slots, keep);
    }

    /// Projects v, takes w from it and transports rho_0 by it.
    fn finish_as_is(&mut self, exec: &dyn Exec, keyframes: &Keyframes<'_, T>) -> Result<Objective, Status> {
        self.project(exec, &mut Silent)?;
        self.consistent_force(exec, &mut Silent)?;
        let objective = self.objective(exec, &mut Silent, keyframes).and_then(finite)?;
        let rho = &mut self.animation.rho;
        rho.copy_from_slice(&self.region[..rho.len()]);
        Ok(objective)
    }

    /// Projects v.
    fn project(&mut self, exec: &dyn Exec, observer: &mut dyn Observer) -> Result<(), Status> {
        let (slots, threads) = (self.slots(), self.threads());
        let tolerance = self.setup.ao.flow.projection_tolerance;
        let Animation { levels, v, sums, .. } = &mut self.animation;
        let mut pool = Pool::new(&mut *self.region);
        let projected = Projection::carve(levels, 0, slots, threads, &mut pool)
            .project(exec, observer, v, None, tolerance, sums);
        if projected.is_break() {
            Err(Status::Cancelled)
        } else {
            Ok(())
        }
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
