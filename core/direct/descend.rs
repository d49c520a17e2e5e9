//! One quasi-Newton iteration: direction, line search, gradient.

use super::Direct;
use super::level::Work;
use crate::exec::Exec;
use crate::field::view;
use crate::grid::Space;
use crate::nested::Fewer;
use crate::observe::Observer;
use crate::problem::keyframes::Keyframes;
use crate::progress::{Objective, Progress, Status};
use crate::quasi_newton::{self, Borrowed, QuasiNewton};
use crate::real::Real;
use crate::transport::Stop;

/// Part of the decrease that the slope promises, which a step must keep (Armijo).
const ENOUGH: f64 = 1e-4;
/// The smallest step that is tried.
const SMALLEST_STEP: f64 = 1.0 / (1 << 20) as f64;
/// Iterations in a row that may gain less than the tolerance.
const PATIENCE: usize = 2;

/// How an iteration ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Outcome {
    /// There is more to gain.
    Goes,
    /// The gain has been below the tolerance for a while, or the gradient is 0.
    Converged,
    /// No step along the preconditioned gradient gains anything.
    Stalled,
}

/// The state of the minimisation on one grid.
#[derive(Clone, Debug)]
pub(super) struct Descent {
    pub newton: QuasiNewton,
    /// F at v, once it is known with its gradient.
    objective: Option<Objective>,
    /// Iterations on this grid.
    pub iterations: usize,
    slow: usize,
}

impl Descent {
    pub fn new(history: usize) -> Self {
        Self { newton: QuasiNewton::new(history), objective: None, iterations: 0, slow: 0 }
    }
}

impl<T: Real, S: Space> Direct<'_, T, S> {
    /// One iteration on the current grid.
    pub(super) fn descend(
        &mut self,
        exec: &dyn Exec,
        observer: &mut dyn Observer,
        keyframes: &Keyframes<'_, T>,
        progress: &mut Progress,
    ) -> Result<Outcome, Status> {
        let (level, tolerance) = (self.level.unwrap_or(0), self.settings.params.tolerance);
        let mut descent = core::mem::replace(&mut self.descent, Descent::new(self.settings.history));
        let mut work = self.work(level, keyframes);
        let exec = &Fewer::new(exec, work.evaluation.setup.carrier.threads);
        let outcome = work.iterate::<S>(exec, observer, &mut descent, tolerance, progress);
        (progress.direct.cells, progress.direct.level) = (work.shape().grid.n, level);
        progress.direct.level_iteration = descent.iterations;
        drop(work);
        match outcome {
            Ok(outcome) => {
                self.descent = descent;
                Ok(outcome)
            }
            Err(Stop::Cancelled) => Err(Status::Cancelled),
            Err(Stop::TooFast) => Err(Status::NotFinite),
        }
    }
}

impl<T: Real> Work<'_, '_, T> {
    fn iterate<S: Space>(
        &mut self,
        exec: &dyn Exec,
        observer: &mut dyn Observer,
        descent: &mut Descent,
        tolerance: f64,
        progress: &mut Progress,
    ) -> Result<Outcome, Stop> {
        let newton = &mut descent.newton;
        let before = match descent.objective {
            Some(objective) => objective,
            None => {
                let (force, gradient) = (newton.direction, newton.gradient);
                let objective = self.value::<S>(exec, observer, force, f64::INFINITY)?;
                self.gradient::<S>(exec, observer, force, gradient)?;
                progress.direct.evaluations += 1;
                *descent.objective.insert(objective)
            }
        };
        descent.iterations += 1;
        let mut slope = self.direction(exec, newton);
        if !(slope < 0.0) && newton.has_pairs() {
            newton.forget();
            slope = self.direction(exec, newton);
        }
        progress.objective = before;
        progress.direct.slope = slope;
        if !before.total().is_finite() || !slope.is_finite() {
            return Err(Stop::TooFast);
        }
        if slope >= 0.0 {
            return Ok(Outcome::Converged);
        }
        let Some(borrowed) = newton.borrow() else { return Ok(Outcome::Stalled) };
        let Some((length, after)) = self.search::<S>(exec, observer, newton, borrowed, before.total(), slope, progress)? else {
            newton.give_back(borrowed);
            let again = newton.has_pairs();
            newton.forget();
            return Ok(if again { Outcome::Goes } else { Outcome::Stalled });
        };
        self.gradient::<S>(exec, observer, borrowed.work, borrowed.gradient)?;
        let initial = self.initial();
        newton.remember(exec, self.shape(), &mut self.fields, borrowed, length, &initial, self.evaluation.sums);
        descent.objective = Some(after);
        progress.objective = after;
        progress.direct.step = length;
        let slow = before.total() - after.total() < tolerance * after.total();
        descent.slow = if slow { descent.slow + 1 } else { 0 };
        Ok(if descent.slow >= PATIENCE { Outcome::Converged } else { Outcome::Goes })
    }

    /// F(v), with its force in field `force`.
    pub fn value<S: Space>(&mut self, exec: &dyn Exec, observer: &mut dyn Observer, force: usize, bound: f64) -> Result<Objective, Stop> {
        self.evaluation.value::<S>(exec, observer, view(&self.v), &mut self.fields[force], bound)
    }

    /// The gradient at v into field `into`, from the force in field `force`.
    fn gradient<S: Space>(&mut self, exec: &dyn Exec, observer: &mut dyn Observer, force: usize, into: usize) -> Result<(), Stop> {
        let mut gradient = core::mem::take(&mut self.fields[into]);
        let done = self.evaluation.gradient::<S>(exec, observer, view(&self.v), view(&self.fields[force]), &mut gradient);
        self.fields[into] = gradient;
        done
    }

    /// The direction's field = -H g; <g, direction>.
    fn direction(&mut self, exec: &dyn Exec, newton: &QuasiNewton) -> f64 {
        let initial = self.initial();
        newton.descend(exec, self.shape(), &mut self.fields, &initial, self.evaluation.sums)
    }

    /// Moves v along the direction by the first of 1, 1/2, 1/4, .. with which F falls enough; the step and F there. Leaves v where
    /// it was if there is none.
    fn search<S: Space>(
        &mut self,
        exec: &dyn Exec,
        observer: &mut dyn Observer,
        newton: &QuasiNewton,
        borrowed: Borrowed,
        before: f64,
        slope: f64,
        progress: &mut Progress,
    ) -> Result<Option<(f64, Objective)>, Stop> {
        let (mut length, mut moved) = (1.0, 0.0);
        while length >= SMALLEST_STEP {
            self.move_along(exec, newton.direction, length - moved);
            moved = length;
            let bound = before + ENOUGH * length * slope;
            progress.direct.evaluations += 1;
            match self.value::<S>(exec, observer, borrowed.work, bound) {
                Ok(after) if after.total() <= bound => return Ok(Some((length, after))),
                Ok(_) | Err(Stop::TooFast) => length *= 0.5,
                Err(Stop::Cancelled) => return Err(Stop::Cancelled),
            }
        }
        self.move_along(exec, newton.direction, -moved);
        Ok(None)
    }

    /// v += `s` direction.
    fn move_along(&mut self, exec: &dyn Exec, direction: usize, s: f64) {
        let shape = self.shape();
        quasi_newton::add(exec, shape, &mut self.v, 1.0, s, view(&self.fields[direction]));
    }
}
