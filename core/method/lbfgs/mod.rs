//! Adjoint control of smoke (Treuille et al. 2003, McNamara et al. 2004): L-BFGS over the forces. Every evaluation simulates the
//! flow, every gradient is the exact adjoint of the simulation (see [`evaluate`]).

mod backward;
pub mod evaluate;
pub mod params;
mod start;
mod work;

use crate::checkpoint::{Damaged, MANY, Mix, Record};
use crate::exec::Exec;
use crate::field::{Vector, VectorMut, view};
use crate::grid::{Grid, Space};
use crate::memory::{Layout, Ledger, Pool, Sharing, TooSmall};
use crate::method::animation::Animation;
use crate::method::contract::{Contract, Measure, Parts, fits, pairs_that_fit};
use crate::method::params::Params;
use crate::method::refusal::PlanError;
use crate::objective::flow;
use crate::objective::script::Script;
use crate::objective::sweep;
use crate::observe::Observer;
use crate::optimise::descent::Descent;
use crate::optimise::quasi_newton::{self, history::History};
use crate::problem::Problem;
use crate::progress::{Objective, Progress, Status};
use crate::real::Real;
use core::marker::PhantomData;
use evaluate::Simulated;
use params::LbfgsParams;

/// All that a solve follows from but its densities, in scaled numbers.
#[derive(Clone, Copy, Debug)]
pub struct Setup {
    /// The grid.
    pub grid: Grid,
    /// The objective of a flow; max rho_0 is set with the source.
    pub flow: flow::Setup,
    /// Fields of the script.
    pub fields: usize,
    /// Pairs of L-BFGS.
    pub history: History,
    /// What an iteration must gain, relative to the objective.
    pub tolerance: f64,
    /// Whether the forces begin on coarser grids.
    pub nested: bool,
    /// Relative tolerance of a simulated step.
    pub step_tolerance: f64,
    /// Iterations at most.
    pub iterations: usize,
}

impl Setup {
    /// That of `problem`.
    #[must_use]
    pub fn new(problem: &Problem<'_>, params: &Params) -> Self {
        let LbfgsParams {
            history,
            history_precision,
            tolerance,
            nested,
        } = params.lbfgs;
        Self {
            grid: problem.grid(),
            flow: flow::Setup::new(problem, params.threads),
            fields: problem.fields(),
            history: History {
                pairs: history.unwrap_or(LbfgsParams::MOST),
                precision: history_precision,
            },
            tolerance,
            nested,
            step_tolerance: params.simulation.tolerance,
            iterations: params.iterations,
        }
    }
}

/// The state of adjoint control.
#[derive(Debug)]
pub struct Lbfgs<'m, T, S> {
    /// Of which v is the flow of the forces.
    animation: Animation<'m, T>,
    /// The forces u_0 .. u_{N-2}.
    u: VectorMut<'m, T>,
    /// Gradients, directions, pairs and work, or the coarse solve before them.
    rest: &'m mut [T],
    setup: Setup,
    descent: Descent,
    begun: bool,
    iteration: usize,
    space: PhantomData<S>,
}

impl<'m, T: Real, S: Space> Lbfgs<'m, T, S> {
    /// That of `setup`, without its buffers.
    #[inline(never)]
    fn with(setup: &Setup) -> Self {
        let sweep = &setup.flow.sweep;
        Self {
            animation: Animation::new(&setup.grid, sweep),
            u: Default::default(),
            rest: &mut [],
            setup: *setup,
            descent: Descent::new(setup.history),
            begun: false,
            iteration: 0,
            space: PhantomData,
        }
    }

    /// What iterations take of `rest`, planned for `threads`.
    fn measure(&self, threads: usize, ledger: &mut Ledger) {
        let (levels, setup) = (&self.animation.levels, &self.setup);
        let sweep = sweep::Setup {
            threads,
            ..setup.flow.sweep
        };
        let mut pool = Pool::measuring(ledger);
        pool.group("L-BFGS", Sharing::Together, |pool| {
            quasi_newton::fields::take(&setup.grid, sweep.slots, setup.history, pool);
            let flow = flow::Setup { sweep, ..setup.flow };
            flow::priced(&setup.grid, &flow, pool);
            Simulated::measure(levels, &flow, false, pool);
        });
    }

    /// Elements of quasi-Newton's fields, which are the first of `rest`: the rest of it is work.
    fn pairs(setup: &Setup) -> usize {
        let mut ledger = Ledger::new();
        let slots = setup.flow.sweep.slots;
        quasi_newton::fields::take(
            &setup.grid,
            slots,
            setup.history,
            &mut Pool::<T>::measuring(&mut ledger),
        );
        ledger.elements(T::BYTES)
    }
}

impl<'m, T: Real, S: Space> Contract<'m, T, S> for Lbfgs<'m, T, S> {
    fn new(problem: &Problem<'_>, params: &Params) -> Self {
        Self::with(&Setup::new(problem, params))
    }

    /// As many pairs as are asked for, or as many as the ceiling allows on one thread, so that results do not depend on threads.
    fn fit(_: &Problem<'_>, params: &Params, measure: &Measure<'_>) -> Result<Params, PlanError> {
        let with = |pairs: usize, threads: usize| {
            let lbfgs = LbfgsParams {
                history: Some(pairs),
                ..params.lbfgs
            };
            Params {
                lbfgs,
                threads,
                ..*params
            }
        };
        let alone = |pairs: usize| fits(&with(pairs, 1), measure);
        let pairs = pairs_that_fit(params.lbfgs.history, LbfgsParams::MOST, alone)?;
        Ok(with(pairs, params.threads))
    }

    fn mix(params: &Params, mix: &mut Mix) {
        // Every field by name: a new one does not compile until it is mixed in.
        let LbfgsParams {
            history,
            history_precision,
            tolerance,
            nested,
        } = params.lbfgs;
        mix.word(history.unwrap_or(LbfgsParams::MOST) as u64);
        mix.word(history_precision as u64);
        mix.real(tolerance);
        mix.word(u64::from(nested));
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
        let (slots, history) = (self.animation.slots, self.setup.history);
        Parts {
            region: quasi_newton::fields::behind(&self.setup.grid, slots, history, self.rest),
            animation: &mut self.animation,
            setup: &mut self.setup.flow,
        }
    }

    fn spent(&mut self) -> Option<(Parts<'_, 'm, T>, Vector<'_, T>)> {
        let (slots, history) = (self.animation.slots, self.setup.history);
        let parts = Parts {
            region: quasi_newton::fields::behind(&self.setup.grid, slots, history, self.rest),
            animation: &mut self.animation,
            setup: &mut self.setup.flow,
        };
        Some((parts, view(&self.u)))
    }

    /// The forces begin as those that v needs.
    fn begin_at(&mut self, exec: &dyn Exec, script: &Script<'_, T>) -> bool {
        self.begun = self.make_feasible(exec, script).is_ok();
        self.begun
    }

    fn layout(&mut self, layout: &mut Layout<'_, 'm, T>) -> Result<(), TooSmall> {
        let setup = self.setup;
        let sums = setup.history.sums_per_row() * setup.grid.rows();
        self.animation.layout(layout, sums)?;
        let len = setup.grid.cells() * self.animation.slots;
        layout.keep_vector("force u", &mut self.u, (S::DIM, len), None)?;
        let mut rest = core::mem::take(&mut self.rest);
        let done = layout.in_turn(&mut rest, Self::pairs(&setup), |ledger| {
            let threads = setup.flow.sweep.threads;
            self.measure(threads, ledger);
            self.animation.measure_initial(threads, ledger);
        });
        self.rest = rest;
        done
    }

    fn scalars(&mut self, record: &mut Record<'_>) -> Result<(), Damaged> {
        let (mut descent, mut begun) = (self.descent.clone(), self.begun);
        let mut iteration = self.iteration;
        record.flag(&mut begun)?;
        record.count(&mut iteration, MANY)?;
        descent.record(record)?;
        (self.descent, self.begun, self.iteration) = (descent, begun, iteration);
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
            self.begin(exec, observer, script)?;
        }
        self.descend(exec, observer, script, progress)
    }

    fn finish(&mut self, exec: &dyn Exec, script: &Script<'_, T>) -> Result<Objective, Status> {
        self.make_feasible(exec, script)
    }

    fn force(&self) -> Vector<'_, T> {
        view(&self.u)
    }
}
