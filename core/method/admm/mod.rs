//! The paper's method (its section 4): ADMM between the advection problem (AO) and the Navier-Stokes problem (NSO).
//!
//! ```text
//! v*   <- argmin 1/2 <e, C e> + K/2 |v* - v - lambda/K|^2        density: AO, with buoyancy + r/2 |w|^2
//! v, w <- argmin K/2 |v - v* + lambda/K|^2 + r/2 |w|^2            velocity: NSO with t = v* - lambda/K
//! lambda <- lambda + K beta (v - v*)                              multiplier
//! ```
//!
//! Two vector fields serve both problems. During AO they are v* and lambda/K; NSO needs only t, and the new lambda/K is
//! v - t when beta = 1, so the second one is free for damping. The bytes of w hold AO's direction, since w follows from v, p.

mod alternate;
pub mod ao;
mod check;
mod history;
mod nested;
pub mod params;
mod report;
mod setup;
mod update_density;
mod update_multiplier;
mod update_velocity;

use crate::checkpoint::{Damaged, MANY, Mix, Record};
use crate::exec::Exec;
use crate::field::slot::RETREATS;
use crate::field::{Vector, VectorMut, means, view};
use crate::grid::Space;
use crate::memory::{Layout, Ledger, Pool, Sharing, TooSmall};
use crate::method::animation::Animation;
use crate::method::contract::{Contract, Measure, Parts};
use crate::method::params::Params;
use crate::method::refusal::PlanError;
use crate::nso::{Bases, NsoSolver, SmootherMemory, Workspace, newton, transfer};
use crate::objective::coarse;
use crate::objective::script::Script;
use crate::observe::Observer;
use crate::problem::{Feature, Problem};
use crate::progress::{Falls, Objective, Progress, Rule, Status};
use crate::real::Real;
use core::marker::PhantomData;
use history::History;
use params::AdmmParams;
use report::Course;
use setup::Setup;

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
        let animation = Animation::new(&setup.grid, sweep);
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
            NsoSolver::Stfas if setup.ao.flow.lifts() => {
                pool.group(
                    "Navier-Stokes problem among densities",
                    Sharing::Together,
                    |pool| {
                        setup.ao.flow.lift(levels).take(pool);
                        Workspace::<T, S>::carve(levels, bases, &nso, pool);
                    },
                );
            }
            NsoSolver::Stfas => {
                Workspace::<T, S>::carve(levels, bases, &nso, &mut pool);
            }
            NsoSolver::NewtonCg => newton::measure(levels, &nso, &mut pool),
        }
        self.animation.measure_initial(sweep.threads, ledger);
        self.measure_coarse(setup, ledger);
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

    /// Its two problems have closed steps for |u|^2 alone.
    fn takes(params: &Params, feature: Feature) -> bool {
        match feature {
            // STFAS knows no faces that are exits, and none that stick.
            Feature::Open | Feature::Sticking => params.admm.nso.solver == NsoSolver::NewtonCg,
            Feature::Solids | Feature::Buoyancy | Feature::Emitters | Feature::Regions | Feature::Release => {
                true
            }
            Feature::Smoothness | Feature::Schedule | Feature::Mask | Feature::Templates | Feature::Jets => {
                false
            }
        }
    }

    /// The fastest way of using memory within the ceiling and the paper's bound. Where none keeps both, the fastest within the ceiling,
    /// or the least memory where none keeps that; without a ceiling the fastest of all.
    fn fit(problem: &Problem<'_>, params: &Params, measure: &Measure<'_>) -> Result<Params, PlanError> {
        let with = |memory: SmootherMemory| with(params, memory);
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

    fn reach(params: &Params) -> Option<usize> {
        Some(match params.admm.nso.solver {
            NsoSolver::Stfas => transfer::REACH,
            NsoSolver::NewtonCg => coarse::REACH,
        })
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

    fn spent(&mut self) -> Option<(Parts<'_, 'm, T>, Vector<'_, T>)> {
        let parts = Parts {
            animation: &mut self.animation,
            setup: &mut self.setup.ao.flow,
            region: self.region,
        };
        Some((parts, view(&self.w)))
    }

    fn layout(&mut self, layout: &mut Layout<'_, 'm, T>) -> Result<(), TooSmall> {
        let grid = self.setup.grid;
        let (len, parts) = (grid.cells() * self.slots(), grid.parts());
        // A rank has all of coarser grids, which may be more than its part of the finest.
        let grids = self.animation.levels.grids.iter();
        let of_means = grids.map(|grid| means::sums_len(grid, self.slots())).max();
        let sums = of_means.unwrap_or(0).max(2 * grid.rows() + self.slots());
        self.animation.layout(layout, sums)?;
        layout.tables(|arena| {
            self.bases = Bases::carve::<S>(arena, &self.animation.levels)?;
            Ok(())
        })?;
        layout.keep_vector("force w (AO: direction)", &mut self.w, (S::DIM, len), parts)?;
        layout.keep_vector("target t (AO: v*)", &mut self.target, (S::DIM, len), parts)?;
        layout.keep_vector(
            "multiplier lambda / K (NSO: damping)",
            &mut self.multiplier,
            (S::DIM, len),
            parts,
        )?;
        if self.setup.params.relaxation != 1.0 {
            let name = "damping of NSO beside the multiplier (beta is not 1)";
            layout.keep_vector(name, &mut self.spare, (S::DIM, len), parts)?;
        }
        layout.keep_fields("pressure p", &mut self.p, (1, len), parts)?;
        layout.keep_fields("pressure pbar", &mut self.pbar, (1, len), parts)?;
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
        if !(0.0..=1.0).contains(&step) {
            return Err(Damaged);
        }
        (self.step, self.iteration, self.history) = (step, iteration, history);
        Ok(())
    }

    fn step(
        &mut self,
        exec: &dyn Exec,
        observer: &mut dyn Observer,
        script: &Script<'_, T>,
        progress: &mut Progress,
    ) -> Result<(), Status> {
        if self.iteration == 0 {
            self.nested_start(exec, observer, script)?;
        }
        self.iteration += 1;
        progress.begin(self.iteration, observer)?;
        let mut course = Course::default();
        let ended = self.alternate(exec, observer, script, progress, &mut course);
        course.tell(&mut progress.report);
        progress.rule = (self.iteration > 1).then_some(Rule {
            value: course.density_change,
            bound: self.setup.params.density_tolerance,
            falls: Falls::Geometrically,
        });
        ended
    }

    /// Projects v, takes w from it and transports rho_0 by it. A flow that is not finite, or too fast to be transported, is taken back
    /// towards v_0 until it is.
    fn finish(&mut self, exec: &dyn Exec, script: &Script<'_, T>) -> Result<Objective, Status> {
        let mut finished = self.finish_as_is(exec, script);
        for keep in RETREATS {
            if finished != Err(Status::NotFinite) {
                break;
            }
            self.retreat(exec, keep);
            finished = self.finish_as_is(exec, script);
        }
        finished
    }

    fn force(&self) -> Vector<'_, T> {
        view(&self.w)
    }
}

/// `params` with this use of the smoother's memory.
fn with(params: &Params, memory: SmootherMemory) -> Params {
    let admm = AdmmParams {
        memory: Some(memory),
        ..params.admm
    };
    Params { admm, ..*params }
}
