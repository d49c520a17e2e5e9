//! Steps: the boundary moves, then iterations until the gradient is small (condensation, section 1).

use super::condenser::Condenser;
use super::error::CondenseError;
use super::settings::{Order, Update};
use crate::exec::{Capped, Exec};
use crate::observe::{Event, Observer, Phase};
use crate::progress::Status;
use crate::real::Real;

/// Armijo's part of the slope.
const ENOUGH: f64 = 1e-4;
/// What rounding may add to the energy, in parts of it and of the precision's rounding.
const ROUNDING: f64 = 8.0;
/// How often a step is halved.
const HALVES: usize = 30;
/// Iterations that must halve the residual of an adaptive basis.
const WINDOW: usize = 4;

/// The basis, or H0's factor, is built.
pub const BUILD: Phase = Phase {
    name: "build",
    words: "building the basis",
    measure: "",
};
/// The gradient, the Hessian and the direction are made.
pub const DIRECTION: Phase = Phase {
    name: "direction",
    words: "finding the direction",
    measure: "",
};
/// The step along it is found.
pub const SEARCH: Phase = Phase {
    name: "search",
    words: "searching along it",
    measure: "",
};

/// What happens in a step before it is solved.
#[derive(Clone, Copy, Debug, Default)]
pub struct Step<'a> {
    /// By how much each vertex moves, held or not, `D` numbers each; nothing moves where it is empty.
    pub shift: &'a [f64],
    /// Acceleration of all vertices.
    pub gravity: [f64; 3],
}

/// The state before an iteration, or at the end of a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Iteration {
    /// How many iterations of this step came before.
    pub iteration: usize,
    /// E.
    pub energy: f64,
    /// What is compared with the tolerance.
    pub residual: f64,
    /// Part of the last direction that was gone, 0 at the beginning.
    pub length: f64,
    /// Builds so far.
    pub builds: usize,
}

/// How a step went.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stepped {
    /// How it ended.
    pub status: Status,
    /// Its iterations.
    pub iterations: usize,
    /// Builds for it.
    pub builds: usize,
}

impl<T: Real, const D: usize> Condenser<'_, T, D> {
    /// The next step. `tell` hears of the state before each iteration and at the end; `observer` can stop it before an iteration, and before a build
    /// at its beginning: then nothing has changed, and `tell` hears of no state.
    ///
    /// # Errors
    /// [`CondenseError::Values`]; nothing has changed then.
    pub fn step(
        &mut self,
        exec: &dyn Exec,
        step: &Step<'_>,
        observer: &mut dyn Observer,
        tell: &mut dyn FnMut(&Iteration),
    ) -> Result<Stepped, CondenseError> {
        if step.gravity.iter().any(|x| !x.is_finite()) {
            return Err(CondenseError::Values);
        }
        let exec: &dyn Exec = &Capped::new(exec, self.params.threads);
        let before = self.builds;
        // From the last converged state: built on the mesh that the boundary has jerked, a basis is worse.
        let due = self.builds == 0
            || (self.params.basis.is_rebuilt() && self.steps.is_multiple_of(self.params.rebuild));
        self.check_shift(step.shift)?;
        if self.params.method.is_built() && due && self.build(exec, observer).is_err() {
            return Ok(Stepped {
                status: Status::Cancelled,
                iterations: 0,
                builds: self.builds - before,
            });
        }
        self.gravity = step.gravity;
        self.lead();
        self.add(step.shift);
        let (status, iterations) = self.minimise(exec, observer, tell);
        self.steps += 1;
        Ok(Stepped {
            status,
            iterations,
            builds: self.builds - before,
        })
    }

    /// x~ = x_t + dt v_t + dt^2 g, with v_t = (x_t - x_{t-1}) / dt.
    fn lead(&mut self) {
        let Some(dt) = self.params.dt else { return };
        let gravity = self.gravity;
        let buffers = &mut self.buffers;
        let now = buffers
            .displacement
            .chunks_exact(D)
            .zip(buffers.before.chunks_exact_mut(D));
        for (target, (now, before)) in buffers.target.chunks_exact_mut(D).zip(now) {
            for (((target, now), before), gravity) in target.iter_mut().zip(now).zip(before).zip(gravity) {
                let (x, old) = (now.to_f64(), before.to_f64());
                *target = T::from_f64(x + (x - old) + dt * dt * gravity);
                *before = *now;
            }
        }
    }

    fn build(&mut self, exec: &dyn Exec, observer: &mut dyn Observer) -> Result<(), Status> {
        phase_of(observer, BUILD, || self.build_here(exec))
    }

    fn minimise(
        &mut self,
        exec: &dyn Exec,
        observer: &mut dyn Observer,
        tell: &mut dyn FnMut(&Iteration),
    ) -> (Status, usize) {
        let mut energy = self.energy_of(exec, false);
        let mut past = [f64::INFINITY; WINDOW];
        let (mut since, mut length, mut iteration) = (0, 0.0, 0);
        self.first = 0.0;
        self.fill_gradient(exec);
        self.first = if D == 1 { self.residual() } else { 0.0 };
        loop {
            let residual = self.residual();
            let builds = self.builds;
            tell(&Iteration {
                iteration,
                energy,
                residual,
                length,
                builds,
            });
            if let Some(status) = self.ended(energy, residual, iteration) {
                return (status, iteration);
            }
            let number = self.steps * self.params.cap + iteration + 1;
            if observer
                .on(Event::IterationBegin { iteration: number })
                .is_break()
            {
                return (Status::Cancelled, iteration);
            }
            let slow = since >= WINDOW && past.get(since % WINDOW).is_some_and(|old| residual > 0.5 * old);
            if self.params.basis.is_adaptive() && slow {
                if self.build(exec, observer).is_err() {
                    return (Status::Cancelled, iteration);
                }
                since = 0;
            }
            if let Some(old) = past.get_mut(since % WINDOW) {
                *old = residual;
            }
            since += 1;
            match self.iterate(exec, observer, energy) {
                Ok(Some((value, part))) => (energy, length) = (value, part),
                Ok(None) => return (Status::Stalled, iteration),
                Err(status) => return (status, iteration),
            }
            iteration += 1;
            self.fill_gradient(exec);
        }
    }

    fn ended(&self, energy: f64, residual: f64, iteration: usize) -> Option<Status> {
        if !energy.is_finite() || !residual.is_finite() {
            return Some(Status::NotFinite);
        }
        // A rod without any force is where it belongs.
        if residual < self.params.tolerance || (D == 1 && residual == 0.0) {
            return Some(Status::Converged);
        }
        (iteration >= self.params.cap).then_some(Status::MaxIterations)
    }

    /// One iteration: the energy and the part of the direction that was gone, or nothing where no step was found.
    fn iterate(
        &mut self,
        exec: &dyn Exec,
        observer: &mut dyn Observer,
        energy: f64,
    ) -> Result<Option<(f64, f64)>, Status> {
        let method = self.params.method;
        if self.params.order == Order::Jacobi {
            let slope = phase_of(observer, DIRECTION, || self.descending(exec, method))?;
            return phase_of(observer, SEARCH, || self.go(exec, energy, slope));
        }
        let (mut energy, mut farthest) = (energy, None);
        for colour in 0..self.topology.colours() {
            let slope = phase_of(observer, DIRECTION, || {
                if colour > 0 {
                    self.fill_gradient(exec);
                }
                self.find_direction(exec, method, Some(colour))
            })?;
            if (slope < 0.0 || !self.params.search)
                && let Some((value, part)) = phase_of(observer, SEARCH, || self.go(exec, energy, slope))?
            {
                energy = value;
                farthest = Some(part.max(farthest.unwrap_or(0.0)));
            }
        }
        Ok(farthest.map(|part: f64| (energy, part)))
    }

    /// A direction, that of `plain` where the method's does not descend; <g, d>.
    fn descending(&mut self, exec: &dyn Exec, method: Update) -> f64 {
        let slope = self.find_direction(exec, method, None);
        // A NaN does not descend.
        if slope < 0.0 || !self.params.search {
            slope
        } else {
            if !method.reads_hessian() {
                self.fill_hessian(exec, true, None);
            }
            self.direct(exec, Update::Plain, None)
        }
    }

    /// Goes along the direction; where to, and how far.
    fn go(&mut self, exec: &dyn Exec, energy: f64, slope: f64) -> Option<(f64, f64)> {
        let slack = ROUNDING * T::EPSILON * energy.abs();
        let mut part = 1.0;
        for _ in 0..=HALVES {
            let buffers = &mut self.buffers;
            let both = buffers.displacement.iter().zip(&*buffers.direction);
            for (trial, (x, d)) in buffers.trial.iter_mut().zip(both) {
                *trial = T::from_f64(x.to_f64() + part * d.to_f64());
            }
            let value = self.energy_of(exec, true);
            if !self.params.search || value <= energy + ENOUGH * part * slope + slack {
                core::mem::swap(&mut self.buffers.displacement, &mut self.buffers.trial);
                return Some((value, part));
            }
            part *= 0.5;
        }
        None
    }
}

/// Tells the observer that `work` begins and ends.
fn phase_of<R>(observer: &mut dyn Observer, phase: Phase, work: impl FnOnce() -> R) -> Result<R, Status> {
    let begun = observer.on(Event::PhaseBegin(phase));
    if begun.is_break() {
        return Err(Status::Cancelled);
    }
    let result = work();
    // What is done is done: a break is heard at the next beginning.
    let _ = observer.on(Event::PhaseEnd(phase));
    Ok(result)
}
