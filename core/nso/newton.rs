//! NSO without a multigrid in time: Newton's method on the flow alone (`reduced`), its
//! systems by conjugate gradients.
//!
//! They are preconditioned by (kappa + S)^-1, exact in time for a flow at rest (mathematics section 6).
//! Systems are solved inexactly, and left where the curvature is not positive (Nocedal & Wright, algorithm
//! 7.1, Newton-CG with a line search).

use super::info::{Ended, Info, cycle_event};
use super::params::Setup;
use super::reduced::{self, Force, Reduced};
use crate::exec::Exec;
use crate::field::trajectory;
use crate::field::view;
use crate::force;
use crate::grid::Space;
use crate::grid::levels::Levels;
use crate::memory::{Pool, Sharing};
use crate::observe::Observer;
use crate::poisson::Projection;
use crate::real::Real;

pub use super::reduced::Problem;

/// Conjugate gradients for one system at most.
const INNER: usize = 30;
/// A system is solved until its residual is at most this part of the gradient.
const INEXACT: f64 = 0.1;
/// Part of the decrease that the slope promises, which a step must keep (Armijo).
const ENOUGH: f64 = 1e-4;
/// Halvings of the step at most.
const HALVINGS: usize = 20;

/// What a call takes of a region, for a pool that measures.
pub fn measure<'l, T: Real>(levels: &'l Levels<'_, T>, setup: &Setup, pool: &mut Pool<'l, T>) {
    let Setup { slots, threads, .. } = *setup;
    let grid = &levels.finest;
    let name = "Navier-Stokes problem (NSO) by Newton's method";
    pool.group(name, Sharing::Together, |pool| {
        reduced::take_fields(grid, slots, pool);
        pool.group("projection or force", Sharing::InTurn, |pool| {
            Projection::carve(levels, 0, slots, threads, pool);
            pool.take(
                "force: rows of a block",
                threads * force::scratch_per_thread(grid, slots),
            );
        });
    });
}

/// Iterates from `problem.v` to the tolerance. `sums` holds two values a row and one a slot.
pub fn solve<T: Real, S: Space>(
    exec: &dyn Exec,
    observer: &mut dyn Observer,
    levels: &Levels<'_, T>,
    setup: &Setup,
    problem: Problem<'_, T>,
    pool: Pool<'_, T>,
    sums: &mut [f64],
) -> Info {
    let mut info = Info::default();
    let mut at = Reduced::new(levels, setup, problem, pool, sums);
    for cycle in 0..=setup.params.cycles {
        let Some(residual) = at.gradient::<S>(exec, observer) else {
            return info.ended(Ended::Cancelled);
        };
        let phi = at.phi(exec, Force::Accepted);
        let _ = info.residuals.push(residual);
        if !residual.is_finite() {
            return info.ended(Ended::NotFinite);
        }
        if cycle > 0 && observer.on(cycle_event(cycle, residual)).is_break() {
            return info.ended(Ended::Cancelled);
        }
        if residual < setup.params.tolerance {
            return info.ended(Ended::Converged);
        }
        if cycle == setup.params.cycles {
            break;
        }
        match at
            .conjugate_gradients::<S>(exec, observer)
            .and_then(|slope| at.search::<S>(exec, observer, phi, slope))
        {
            Some(true) => {}
            Some(false) => break,
            None => return info.ended(Ended::Cancelled),
        }
    }
    info
}

impl<T: Real> Reduced<'_, '_, T> {
    /// step = about -H^-1 g; <g, step>.
    fn conjugate_gradients<S: Space>(&mut self, exec: &dyn Exec, observer: &mut dyn Observer) -> Option<f64> {
        let shape = self.shape();
        let mut left = self.precondition(exec);
        let enough = INEXACT * INEXACT * left;
        let mut slope = 0.0;
        trajectory::add(exec, shape, &mut self.direction, 0.0, 1.0, view(&self.work));
        trajectory::add(exec, shape, &mut self.step, 0.0, 0.0, view(&self.work));
        for inner in 0..INNER {
            self.apply::<S>(exec, observer)?;
            let curvature = trajectory::dot(exec, shape, view(&self.direction), view(&self.image), self.sums);
            let negative = !(curvature > 0.0);
            if negative && inner > 0 {
                break;
            }
            // The first direction is that of steepest descent: where it curves down, it is the step.
            let length = if negative { 1.0 } else { left / curvature };
            trajectory::add(exec, shape, &mut self.step, 1.0, length, view(&self.direction));
            slope -= length * left;
            if negative {
                break;
            }
            trajectory::add(exec, shape, &mut self.residual, 1.0, -length, view(&self.image));
            let next = self.precondition(exec);
            if next <= enough {
                break;
            }
            let turn = next / left;
            trajectory::add(exec, shape, &mut self.direction, turn, 1.0, view(&self.work));
            left = next;
        }
        Some(slope)
    }

    /// Moves v along the step by the first of 1, 1/2, 1/4, .. with which phi falls enough, w with it; false,
    /// with v where it was, if there is none.
    fn search<S: Space>(
        &mut self,
        exec: &dyn Exec,
        observer: &mut dyn Observer,
        before: f64,
        slope: f64,
    ) -> Option<bool> {
        if !slope.is_finite() {
            return Some(false);
        }
        let (mut length, mut moved) = (1.0, 0.0);
        for _ in 0..HALVINGS {
            self.move_along(exec, length - moved);
            moved = length;
            self.force::<S>(exec, observer)?;
            if self.phi(exec, Force::OfTrial) <= before + ENOUGH * length * slope {
                let shape = self.shape();
                trajectory::add(exec, shape, &mut self.problem.w, 0.0, 1.0, view(&self.work));
                return Some(true);
            }
            length *= 0.5;
        }
        self.move_along(exec, -moved);
        Some(false)
    }

    /// v += `s` step.
    fn move_along(&mut self, exec: &dyn Exec, s: f64) {
        let shape = self.shape();
        trajectory::add(exec, shape, &mut self.problem.v, 1.0, s, view(&self.step));
    }
}
