//! The sub-steps of a step, forward and backward.

use super::held::{Held, Place, STATES};
use super::rows::Velocity;
use super::{Transport, semi_lagrangian, series};
use crate::exec::Exec;
use crate::field::{Vector, reborrow, view};
use crate::memory::pooled;
use crate::problem::Scheme;
use crate::real::Real;

impl<T: Real> Transport<'_, T> {
    /// `to = A[from, v]` with the velocity that was loaded; fields of cells.
    pub fn forward(&mut self, exec: &dyn Exec, from: &[T], to: &mut [T]) {
        let states = core::mem::take(&mut self.states);
        self.carry(exec, self.substeps, from, [to, &mut states[..from.len()]]);
        self.states = states;
    }

    /// `count` sub-steps, at least one, from `from` to `to`, by way of a field of work.
    fn carry(&mut self, exec: &dyn Exec, count: usize, from: &[T], [mut to, mut other]: [&mut [T]; 2]) {
        if count.is_multiple_of(2) {
            core::mem::swap(&mut to, &mut other);
        }
        self.substep(exec, from, to, 0);
        for _ in 1..count {
            self.substep(exec, to, other, 0);
            core::mem::swap(&mut to, &mut other);
        }
    }

    /// One sub-step; `to` may be empty. The series' terms go to `terms` from field `begin` on. Returns how many there are, or `None`
    /// where they find no room.
    fn substep(&mut self, exec: &dyn Exec, from: &[T], to: &mut [T], begin: usize) -> Option<usize> {
        let (grid, velocity) = (self.grid, Velocity(view(&self.velocity)));
        if self.scheme == Scheme::SemiLagrangian {
            if !to.is_empty() {
                semi_lagrangian::trace(exec, grid, velocity, 1.0 / self.substeps as f64, from, to);
            }
            return Some(0);
        }
        let series = series::Series {
            grid,
            velocity,
            weights: series::weights(self.scheme),
            tau: 1.0 / self.substeps as f64,
            cut: self.cut,
        };
        let stride = Self::stride(grid);
        let terms = series::Terms {
            fields: &mut self.terms[begin * stride..],
            stride,
            sizes: &mut self.sizes[begin * grid.rows()..],
        };
        series::sum(exec, &series, from, terms, to, self.scratch)
    }

    /// The terms of the step's last sub-steps from `rho`, which [`Self::backward`] begins with: it calls this itself if nobody did.
    pub fn prepare(&mut self, exec: &dyn Exec, rho: &[T]) {
        self.held = Some(self.hold(exec, rho, (self.substeps - 1) / STATES * STATES));
    }

    /// The terms of the sub-steps from `first` on, as far as there are states for.
    fn hold(&mut self, exec: &dyn Exec, rho: &[T], first: usize) -> Held {
        let (len, stride) = (rho.len(), pooled(rho.len()));
        let count = STATES.min(self.substeps - first);
        let states = core::mem::take(&mut self.states);
        if first > 0 {
            let (begin, work) = states.split_at_mut(stride);
            self.carry(exec, first, rho, [&mut begin[..len], &mut work[..len]]);
        }
        let mut held = Held::default();
        for state in 0..count {
            let (before, after) = states.split_at_mut((state + 1) * stride);
            let from = if first + state == 0 {
                rho
            } else {
                &before[state * stride..][..len]
            };
            let to = if state + 1 < count {
                &mut after[..len]
            } else {
                &mut []
            };
            held.push(|begin| self.substep(exec, from, to, begin));
        }
        self.states = states;
        held
    }

    /// The adjoint of the step from `rho`: `mu` <- A_rho^T mu where there is smoke (elsewhere it may stay as it is, which no gradient
    /// depends on), and [`Self::gradient`] = A_v^T mu.
    pub fn backward(&mut self, exec: &dyn Exec, rho: &[T], mu: &mut [T]) {
        let (len, stride) = (rho.len(), pooled(rho.len()));
        for first in (0..self.substeps).step_by(STATES).rev() {
            let held = match self.held.take() {
                Some(held) => held,
                None => self.hold(exec, rho, first),
            };
            let states = core::mem::take(&mut self.states);
            for state in (0..STATES.min(self.substeps - first)).rev() {
                let from = if first + state == 0 {
                    rho
                } else {
                    &states[state * stride..][..len]
                };
                let terms = held.get(state).unwrap_or_else(|| Place {
                    begin: 0,
                    count: self.substep(exec, from, &mut [], 0).unwrap_or(0),
                });
                self.substep_backward(exec, from, terms, mu, first + state + 1 == self.substeps);
            }
            self.states = states;
        }
    }

    /// The adjoint of the sub-step from `rho`: `mu` and the gradient, which begins with the `first`.
    fn substep_backward(&mut self, exec: &dyn Exec, rho: &[T], terms: Place, mu: &mut [T], first: bool) {
        let (grid, velocity) = (self.grid, Velocity(view(&self.velocity)));
        if self.scheme == Scheme::SemiLagrangian {
            if first {
                self.gradient
                    .iter_mut()
                    .for_each(|component| component.fill(T::ZERO));
            }
            let after = &mut self.adjoint[0][..mu.len()];
            after.copy_from_slice(mu);
            let step = semi_lagrangian::Step {
                grid,
                velocity,
                tau: 1.0 / self.substeps as f64,
                rho,
                mu: after,
            };
            semi_lagrangian::gradient(exec, &step, reborrow(&mut self.gradient));
            return semi_lagrangian::adjoint(exec, &step, mu);
        }
        let series = series::Series {
            grid,
            velocity,
            weights: series::weights(self.scheme),
            tau: 1.0 / self.substeps as f64,
            cut: self.cut,
        };
        let backward = series::Backward {
            mu,
            work: self.adjoint.each_mut().map(|z| &mut **z),
            gradient: reborrow(&mut self.gradient),
            first,
        };
        let stride = Self::stride(grid);
        let held = series::Terms {
            fields: &self.terms[terms.begin * stride..],
            stride,
            sizes: &self.sizes[terms.begin * grid.rows()..],
        };
        series::adjoint(exec, &series, rho, held, terms.count, backward, self.scratch);
    }

    /// A_v^T mu of the last [`Self::backward`], at the faces.
    #[must_use]
    pub fn gradient(&self) -> Vector<'_, T> {
        view(&self.gradient)
    }
}
