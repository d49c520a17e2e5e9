//! Adjoint control of smoke (Treuille et al. 2003, McNamara et al. 2004): L-BFGS over the forces. Every evaluation simulates the
//! flow, every gradient is the exact adjoint of the simulation (see [`evaluate`]).

pub mod evaluate;
pub mod params;
mod start;

use crate::checkpoint::{Damaged, MANY, Mix, Record};
use crate::exec::Exec;
use crate::field::trajectory::{self, Shape};
use crate::field::{Vector, VectorMut, reborrow, rows, sums, view};
use crate::grid::{Grid, Space};
use crate::memory::{Layout, Ledger, Pool, Sharing, TooSmall};
use crate::method::animation::Animation;
use crate::method::contract::{Contract, Measure, Parts, fits, pairs_that_fit};
use crate::method::params::Params;
use crate::method::refusal::PlanError;
use crate::objective::flow::{self, Evaluation};
use crate::objective::keyframes::Keyframes;
use crate::objective::sweep;
use crate::observe::Observer;
use crate::optimise::descent::{Course, Descent, Function, Outcome};
use crate::optimise::quasi_newton;
use crate::optimise::quasi_newton::fields::{Fields, Initial};
use crate::optimise::quasi_newton::recursion::{Borrowed, QuasiNewton};
use crate::problem::Problem;
use crate::progress::{Objective, Progress, Status};
use crate::real::Real;
use crate::transport::Stop;
use core::marker::PhantomData;
use evaluate::{Simulated, Warm};
use params::LbfgsParams;

/// All that a solve follows from but its densities, in scaled numbers.
#[derive(Clone, Copy, Debug)]
pub struct Setup {
    /// The grid.
    pub grid: Grid,
    /// The objective of a flow; max rho_0 is set with the source.
    pub flow: flow::Setup,
    /// Keyframes.
    pub keyframes: usize,
    /// Pairs of L-BFGS.
    pub history: usize,
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
            tolerance,
            nested,
        } = params.lbfgs;
        Self {
            grid: problem.grid(),
            flow: flow::Setup::new(problem, params.threads),
            keyframes: problem.keyframes.len(),
            history: history.unwrap_or(LbfgsParams::MOST),
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
            animation: Animation::new(&setup.grid, sweep.slots, sweep.metric.filters),
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
            Simulated::measure(levels, &sweep, pool);
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

    fn work<'a>(&'a mut self, keyframes: &Keyframes<'a, T>) -> Work<'a, 'm, T> {
        let setup = &self.setup;
        let mut pool = Pool::new(&mut *self.rest);
        let fields = quasi_newton::fields::take(&setup.grid, self.animation.slots, setup.history, &mut pool);
        let (evaluation, v) = self.animation.evaluation(setup.flow, keyframes, pool.into_rest());
        Work {
            simulated: Simulated {
                evaluation,
                tolerance: setup.step_tolerance,
            },
            v: reborrow(v),
            u: reborrow(&mut self.u),
            fields,
            change: None,
        }
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
            tolerance,
            nested,
        } = params.lbfgs;
        mix.word(history.unwrap_or(LbfgsParams::MOST) as u64);
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

    fn layout(&mut self, layout: &mut Layout<'_, 'm, T>) -> Result<(), TooSmall> {
        let setup = self.setup;
        let sums = quasi_newton::fields::sums_per_row(setup.history) * setup.grid.rows();
        self.animation.layout(layout, sums)?;
        let len = setup.grid.cells() * self.animation.slots;
        layout.keep_vector("force u", &mut self.u, S::DIM, len)?;
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
        keyframes: &Keyframes<'_, T>,
        progress: &mut Progress,
    ) -> Result<(), Status> {
        self.iteration += 1;
        progress.cells = self.setup.grid.n;
        progress.begin(self.iteration, observer)?;
        if !self.begun {
            self.begin(exec, observer, keyframes)?;
        }
        let mut descent = core::mem::replace(&mut self.descent, Descent::new(self.setup.history));
        let tolerance = self.setup.tolerance;
        let mut course = Course::default();
        let mut work = self.work(keyframes);
        let outcome = descent.iterate::<T, S>(exec, observer, &mut work, tolerance, &mut course);
        drop(work);
        course.tell(progress);
        match outcome {
            Ok((outcome, objective)) => {
                progress.objective = objective;
                self.descent = descent;
                match outcome {
                    Outcome::Goes if self.descent.iterations < self.setup.iterations => Ok(()),
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

    fn finish(&mut self, exec: &dyn Exec, keyframes: &Keyframes<'_, T>) -> Result<Objective, Status> {
        self.descent = Descent::new(self.setup.history);
        let Work {
            mut simulated,
            mut v,
            mut u,
            ..
        } = self.work(keyframes);
        simulated.evaluation.finish::<S>(exec, &mut v, &mut u)
    }

    fn force(&self) -> Vector<'_, T> {
        view(&self.u)
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
            slots: setup.sweep.slots,
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
        let direction = view(&self.fields[newton.direction]);
        let sums = &mut *self.simulated.evaluation.sums;
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
