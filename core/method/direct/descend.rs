//! One quasi-Newton iteration on the grid that the solve has come to.

use super::Direct;
use super::there::There;
use super::work::{Work, is_usable};
use crate::exec::{Capped, Exec};
use crate::field::trajectory;
use crate::field::view;
use crate::grid::Space;
use crate::method::first_hessian;
use crate::objective::script::Script;
use crate::observe::Observer;
use crate::optimise::descent::{Descent, Function, Outcome};
use crate::optimise::quasi_newton::recursion::{Borrowed, QuasiNewton};
use crate::progress::{Objective, Progress, Status};
use crate::real::Real;
use crate::transport::Stop;

impl<T: Real, S: Space> Direct<'_, T, S> {
    /// Takes the flow and its densities back from a device that has them.
    pub(super) fn fetch_flow(&mut self, exec: &dyn Exec, script: &Script<'_, T>) {
        if let (Some(device), Some(level)) = (exec.device(), self.there) {
            There::new(device, &mut self.work(level, script)).read_flow();
        }
    }

    /// Takes the fields of L-BFGS back too.
    pub(super) fn fetch_fields(&mut self, exec: &dyn Exec, script: &Script<'_, T>) {
        if let (Some(device), Some(level)) = (exec.device(), self.there) {
            There::new(device, &mut self.work(level, script)).read_fields();
        }
    }

    /// One iteration on the current grid.
    pub(super) fn descend(
        &mut self,
        exec: &dyn Exec,
        observer: &mut dyn Observer,
        script: &Script<'_, T>,
        progress: &mut Progress,
    ) -> Result<Outcome, Status> {
        let level = self.level.unwrap_or(0);
        let tolerance = self.tolerance_on(level);
        let descent = core::mem::replace(&mut self.descent, Descent::new(self.setup.history));
        let is_there = self.there == Some(level);
        let device = exec.device().filter(|_| self.goes_there);
        self.there = device.map(|_| level);
        let mut work = self.work(level, script);
        let exec = &Capped::new(exec, work.evaluation.setup.sweep.threads);
        (progress.cells, progress.level) = (work.shape().grid.whole().counts_inside(), level);
        let (descent, outcome) = match device {
            None => descent.step::<T, S>(exec, observer, &mut work, tolerance, progress)?,
            Some(device) => {
                let mut there = There::new(device, &mut work);
                if !is_there {
                    there.begin(&descent);
                }
                descent.step::<T, S>(exec, observer, &mut there, tolerance, progress)?
            }
        };
        drop(work);
        self.descent = descent;
        Ok(outcome)
    }
}

impl<T: Real, S: Space> Function<T, S> for Work<'_, '_, T> {
    fn direction(
        &mut self,
        exec: &dyn Exec,
        observer: &mut dyn Observer,
        newton: &mut QuasiNewton,
    ) -> Result<f64, Stop> {
        let slope = newton.descend(exec, self.shape(), &mut self.fields);
        let left = self
            .evaluation
            .clean(exec, observer, &mut self.fields[newton.direction])?;
        Ok(if is_usable(left) { slope } else { f64::NAN })
    }

    fn move_along(&mut self, exec: &dyn Exec, direction: usize, s: f64) {
        let shape = self.shape();
        trajectory::add(exec, shape, &mut self.v, 1.0, s, view(&self.fields[direction]));
    }

    fn retreat(&mut self, exec: &dyn Exec, keep: f64) {
        self.evaluation.retreat(exec, &mut self.v, keep);
    }

    fn value(
        &mut self,
        exec: &dyn Exec,
        observer: &mut dyn Observer,
        force: usize,
        bound: f64,
    ) -> Result<Objective, Stop> {
        self.evaluation
            .value::<S>(exec, observer, view(&self.v), &mut self.fields[force], bound)
    }

    fn gradient(
        &mut self,
        exec: &dyn Exec,
        observer: &mut dyn Observer,
        force: usize,
        into: usize,
    ) -> Result<(), Stop> {
        let mut gradient = core::mem::take(&mut self.fields[into]);
        let done = self.evaluation.gradient::<S>(
            exec,
            observer,
            view(&self.v),
            view(&self.fields[force]),
            &mut gradient,
        );
        self.fields[into] = gradient;
        done
    }

    fn arrive(&mut self, exec: &dyn Exec, newton: &mut QuasiNewton, borrowed: Borrowed, step: Option<f64>) {
        let evaluation = &mut self.evaluation;
        first_hessian::arrive::<T, S>(
            exec,
            evaluation,
            Some(self.line),
            &mut self.fields,
            newton,
            (borrowed, step),
        );
    }
}
