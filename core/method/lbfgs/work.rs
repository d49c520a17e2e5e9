//! One quasi-Newton iteration over the forces.

use super::Lbfgs;
use super::evaluate::{Push, Simulated, Warm};
use crate::exec::Exec;
use crate::field::trajectory::{self, Shape};
use crate::field::{VectorMut, reborrow, rows, sums, view};
use crate::grid::Space;
use crate::memory::Pool;
use crate::method::first_hessian;
use crate::objective::script::Script;
use crate::observe::Observer;
use crate::optimise::descent::{Descent, Function};
use crate::optimise::quasi_newton;
use crate::optimise::quasi_newton::fields::Fields;
use crate::optimise::quasi_newton::recursion::{Borrowed, QuasiNewton};
use crate::progress::{Objective, Progress, Status};
use crate::real::Real;
use crate::transport::Stop;

/// What an iteration uses.
struct Work<'a, 'm, T> {
    simulated: Simulated<'a, 'm, T>,
    v: VectorMut<'a, T>,
    u: VectorMut<'a, T>,
    fields: Fields<'a, T>,
    /// The direction that u was moved along, and how far in all, since v was its flow.
    change: Option<(usize, f64)>,
}

impl<'a, T: Real> Work<'a, '_, T> {
    fn shape(&self) -> Shape<'a> {
        self.simulated.evaluation.shape()
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
            .gradient::<S>(exec, observer, Push::by(view(&self.u)), v, &mut gradient);
        if done.is_ok() {
            let shape = self.shape();
            trajectory::add(exec, shape, &mut self.v, 0.0, 1.0, view(&self.fields[work]));
        }
        self.fields[into] = gradient;
        done
    }

    fn arrive(&mut self, exec: &dyn Exec, newton: &mut QuasiNewton, borrowed: Borrowed, step: Option<f64>) {
        let evaluation = &mut self.simulated.evaluation;
        first_hessian::arrive::<T, S>(exec, evaluation, None, &mut self.fields, newton, (borrowed, step));
    }
}

impl<'m, T: Real, S: Space> Lbfgs<'m, T, S> {
    fn work<'a>(&'a mut self, script: &Script<'a, T>) -> Work<'a, 'm, T> {
        let setup = &self.setup;
        let mut pool = Pool::new(&mut *self.rest);
        let fields = quasi_newton::fields::take(&setup.grid, self.animation.slots, setup.history, &mut pool);
        let (evaluation, v) = self.animation.evaluation(setup.flow, script, pool.into_rest());
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

    /// One iteration.
    pub(super) fn descend(
        &mut self,
        exec: &dyn Exec,
        observer: &mut dyn Observer,
        script: &Script<'_, T>,
        progress: &mut Progress,
    ) -> Result<(), Status> {
        let descent = core::mem::replace(&mut self.descent, Descent::new(self.setup.history));
        let tolerance = self.setup.tolerance;
        let mut work = self.work(script);
        let (descent, outcome) = descent.step::<T, S>(exec, observer, &mut work, tolerance, progress)?;
        drop(work);
        self.descent = descent;
        self.descent.goes_on(outcome, self.setup.iterations)
    }

    /// v and the forces made feasible; the objective.
    pub(super) fn make_feasible(
        &mut self,
        exec: &dyn Exec,
        script: &Script<'_, T>,
    ) -> Result<Objective, Status> {
        self.descent = Descent::new(self.setup.history);
        let Work {
            mut simulated,
            mut v,
            mut u,
            ..
        } = self.work(script);
        simulated.evaluation.finish::<S>(exec, &mut v, &mut u)
    }
}
