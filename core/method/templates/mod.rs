//! Control by templates (Treuille et al. 2003): the force is a sum of a few winds and vortices, and L-BFGS searches for their amplitudes,
//! middles and radii. Values and gradients by the force are those of adjoint control ([`lbfgs`](super::lbfgs)).

pub mod params;
pub mod search;
pub mod sum;
pub mod unknowns;
mod work;

use crate::checkpoint::{Damaged, MANY, Mix, Record};
use crate::exec::Exec;
use crate::field::slot::put_everywhere;
use crate::field::{Vector, VectorMut, view};
use crate::grid::{Boundary, Grid, Space};
use crate::memory::{Layout, Ledger, Pool, Sharing, TooSmall};
use crate::method::animation::Animation;
use crate::method::contract::{Contract, Measure, Parts};
use crate::method::lbfgs::evaluate::Simulated;
use crate::method::params::Params;
use crate::method::refusal::PlanError;
use crate::objective::flow;
use crate::objective::script::Script;
use crate::observe::Observer;
use crate::optimise::descent::Descent;
use crate::optimise::quasi_newton;
use crate::optimise::quasi_newton::history::{History, MAX_PAIRS};
use crate::problem::{Feature, Problem, ProblemError};
use crate::progress::{Objective, Progress, Status};
use crate::real::Real;
use core::marker::PhantomData;
use params::TemplatesParams;

/// All that a solve follows from but its densities and templates, in scaled numbers.
#[derive(Clone, Copy, Debug)]
pub struct Setup {
    /// The grid.
    pub grid: Grid,
    /// The objective of a flow; max rho_0 is set with the source.
    pub flow: flow::Setup,
    /// The unknowns as a grid of one row.
    pub unknowns: Grid,
    /// The most unknowns that a template has.
    pub most: usize,
    /// Whether a template acts on smoke.
    pub pulls: bool,
    /// Pairs of L-BFGS.
    pub history: History,
    /// What an iteration must gain, relative to the objective.
    pub tolerance: f64,
    /// Relative tolerance of a simulated step.
    pub step_tolerance: f64,
    /// Iterations at most.
    pub iterations: usize,
}

impl Setup {
    /// That of `problem`.
    #[must_use]
    pub fn new(problem: &Problem<'_>, params: &Params) -> Self {
        let TemplatesParams { history, tolerance } = params.templates;
        let (dims, slots) = (problem.cells.len(), problem.slots());
        let counts = problem
            .templates
            .iter()
            .map(|template| template.unknowns(dims, slots));
        Self {
            grid: problem.grid(),
            flow: flow::Setup::new(problem, params.threads),
            unknowns: Grid::new(&[counts.clone().sum()], &[Boundary::Wall]),
            most: counts.max().unwrap_or(0),
            pulls: problem.templates.iter().any(|template| template.kind.on_smoke()),
            history: History::full(history),
            tolerance,
            step_tolerance: params.simulation.tolerance,
            iterations: params.iterations,
        }
    }
}

/// The state of a search over templates.
#[derive(Debug)]
pub struct Templates<'m, T, S> {
    /// Of which v is the flow of the force.
    animation: Animation<'m, T>,
    /// The unknowns.
    z: &'m mut [T],
    /// The forces u_0 .. u_{N-2} that they stand for.
    u: VectorMut<'m, T>,
    /// Gradients, directions and pairs, then trajectories and work.
    rest: &'m mut [T],
    setup: Setup,
    descent: Descent,
    /// The first inverse Hessian: so many times the gradient by z.
    scale: f64,
    begun: bool,
    iteration: usize,
    space: PhantomData<S>,
}

impl<T: Real, S: Space> Templates<'_, T, S> {
    /// What iterations take of `rest`.
    fn measure(&self, ledger: &mut Ledger) {
        let (levels, setup) = (&self.animation.levels, &self.setup);
        let mut pool = Pool::measuring(ledger);
        pool.group("L-BFGS", Sharing::Together, |pool| {
            quasi_newton::fields::take(&setup.unknowns, 1, setup.history, pool);
            search::trajectories(&setup.grid, self.animation.slots, pool);
            flow::priced(&setup.grid, &setup.flow, pool);
            Simulated::measure(levels, &setup.flow, setup.pulls, pool);
        });
    }

    /// Elements of quasi-Newton's fields, which are the first of `rest`.
    fn pairs(setup: &Setup) -> usize {
        let mut ledger = Ledger::new();
        let mut pool = Pool::<T>::measuring(&mut ledger);
        quasi_newton::fields::take(&setup.unknowns, 1, setup.history, &mut pool);
        ledger.elements(T::BYTES)
    }

    /// Sets the unknowns and the flow to where a search begins.
    fn begin(&mut self, exec: &dyn Exec, script: &Script<'_, T>) {
        let Animation {
            levels,
            initial,
            v,
            slots,
            ..
        } = &mut self.animation;
        put_everywhere(exec, &levels.finest, view(initial), v, *slots);
        for place in unknowns::places(script.templates(), &self.setup.grid, *slots) {
            place.begin(self.z);
        }
        self.descent = Descent::new(self.setup.history);
        self.begun = true;
    }
}

impl<'m, T: Real, S: Space> Contract<'m, T, S> for Templates<'m, T, S> {
    #[inline(never)]
    fn new(problem: &Problem<'_>, params: &Params) -> Self {
        let setup = Setup::new(problem, params);
        Self {
            animation: Animation::new(&setup.grid, &setup.flow.sweep),
            z: &mut [],
            u: Default::default(),
            rest: &mut [],
            setup,
            descent: Descent::new(setup.history),
            scale: 1.0,
            begun: false,
            iteration: 0,
            space: PhantomData,
        }
    }

    fn fit(problem: &Problem<'_>, params: &Params, _: &Measure<'_>) -> Result<Params, PlanError> {
        if problem.templates.is_empty() {
            return Err(ProblemError::NoTemplate.into());
        }
        Ok(*params)
    }

    fn takes(_: &Params, feature: Feature) -> bool {
        // Templates say where force acts.
        feature != Feature::Mask
    }

    fn mix(params: &Params, mix: &mut Mix) {
        // Every field by name: a new one does not compile until it is mixed in.
        let TemplatesParams { history, tolerance } = params.templates;
        mix.word(history as u64);
        mix.real(tolerance);
        params.simulation.mix(mix);
    }

    fn animation(&self) -> &Animation<'m, T> {
        &self.animation
    }

    fn parts(&mut self) -> Parts<'_, 'm, T> {
        Parts {
            animation: &mut self.animation,
            setup: &mut self.setup.flow,
            region: self.rest,
        }
    }

    fn idle_parts(&mut self) -> Parts<'_, 'm, T> {
        Parts {
            region: quasi_newton::fields::behind(&self.setup.unknowns, 1, self.setup.history, self.rest),
            animation: &mut self.animation,
            setup: &mut self.setup.flow,
        }
    }

    fn layout(&mut self, layout: &mut Layout<'_, 'm, T>) -> Result<(), TooSmall> {
        let setup = self.setup;
        // Three for each row serve the objective, and so many in all the passes over the unknowns.
        let sums = (setup.most.max(3) * setup.grid.rows()).max(History::full(MAX_PAIRS).sums_per_row());
        self.animation.layout(layout, sums)?;
        layout.keep("unknowns of templates", &mut self.z, setup.unknowns.cells())?;
        let len = setup.grid.cells() * self.animation.slots;
        layout.keep_vector("force u", &mut self.u, (S::DIM, len), None)?;
        let mut rest = core::mem::take(&mut self.rest);
        let done = layout.in_turn(&mut rest, Self::pairs(&setup), |ledger| {
            self.measure(ledger);
            self.animation.measure_initial(setup.flow.sweep.threads, ledger);
        });
        self.rest = rest;
        done
    }

    fn scalars(&mut self, record: &mut Record<'_>) -> Result<(), Damaged> {
        let (mut descent, mut begun) = (self.descent.clone(), self.begun);
        let (mut iteration, mut scale) = (self.iteration, self.scale);
        record.flag(&mut begun)?;
        record.count(&mut iteration, MANY)?;
        record.real(&mut scale)?;
        descent.record(record)?;
        (self.descent, self.begun) = (descent, begun);
        (self.iteration, self.scale) = (iteration, scale);
        Ok(())
    }

    fn step(
        &mut self,
        exec: &dyn Exec,
        observer: &mut dyn Observer,
        script: &Script<'_, T>,
        progress: &mut Progress,
    ) -> Result<(), Status> {
        self.iteration += 1;
        progress.cells = self.setup.grid.whole().counts_inside();
        progress.begin(self.iteration, observer)?;
        if !self.begun {
            self.begin(exec, script);
        }
        self.descend(exec, observer, script, progress)
    }

    fn finish(&mut self, exec: &dyn Exec, script: &Script<'_, T>) -> Result<Objective, Status> {
        self.make_feasible(exec, script)
    }

    fn force(&self) -> Vector<'_, T> {
        view(&self.u)
    }

    fn unknowns(&self) -> &[T] {
        self.z
    }
}
