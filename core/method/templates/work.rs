//! One quasi-Newton iteration over the unknowns, and the end.

use super::Templates;
use super::search::{Search, trajectories};
use crate::exec::Exec;
use crate::field::reborrow;
use crate::grid::Space;
use crate::memory::Pool;
use crate::method::lbfgs::evaluate::Simulated;
use crate::objective::script::Script;
use crate::observe::Observer;
use crate::optimise::descent::Descent;
use crate::optimise::quasi_newton;
use crate::progress::{Objective, Progress, Status};
use crate::real::Real;

impl<'m, T: Real, S: Space> Templates<'m, T, S> {
    fn search<'a>(&'a mut self, script: &Script<'a, T>) -> Search<'a, 'm, T> {
        let setup = self.setup;
        let mut pool = Pool::new(&mut *self.rest);
        let fields = quasi_newton::fields::take(&setup.unknowns, 1, setup.history, &mut pool);
        let [trial, gradient] = trajectories(&setup.grid, self.animation.slots, &mut pool);
        let (evaluation, v) = self.animation.evaluation(setup.flow, script, pool.into_rest());
        Search {
            simulated: Simulated {
                evaluation,
                tolerance: setup.step_tolerance,
            },
            unknowns: setup.unknowns,
            z: self.z,
            u: reborrow(&mut self.u),
            v: reborrow(v),
            trial,
            gradient,
            fields,
            scale: &mut self.scale,
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
        let mut search = self.search(script);
        let (descent, outcome) = descent.step::<T, S>(exec, observer, &mut search, tolerance, progress)?;
        drop(search);
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
        let Search {
            mut simulated,
            mut v,
            mut u,
            ..
        } = self.search(script);
        simulated.evaluation.finish::<S>(exec, &mut v, &mut u)
    }
}
