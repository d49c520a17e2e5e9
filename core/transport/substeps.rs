//! The sub-steps of a step, forward and backward.

use super::held::{Held, Place, STATES};
use super::rows::Velocity;
use super::terms::{Backward, Terms};
use super::{Transport, limited, semi_lagrangian, series};
use crate::exec::Exec;
use crate::field::{Vector, VectorMut, reborrow, view};
use crate::grid::Grid;
use crate::grid::solids::OUTSIDE;
use crate::memory::pooled;
use crate::problem::Scheme;
use crate::real::Real;

/// Values of a field below this part of the cut are set to 0: a quarter of the square root of the rounding error, which makes 1e-9
/// of max rho_0 in single precision with the default cut and keeps mass to 1e-7. Far from the smoke they would otherwise fade into
/// denormal numbers, on which processors are a hundred times slower; and rows without smoke are passed over.
pub fn negligible<T: Real>() -> f64 {
    0.25 * libm::sqrt(T::EPSILON)
}

/// What all schemes know of a sub-step.
#[derive(Clone, Copy)]
struct Substep<'a, T> {
    grid: &'a Grid,
    scheme: Scheme,
    velocity: Velocity<'a, T>,
    open: Velocity<'a, T>,
    tau: f64,
    cut: f64,
    everywhere: bool,
}

impl<'a, T: Real> Substep<'a, T> {
    fn new(
        grid: &'a Grid,
        scheme: Scheme,
        [velocity, open]: [&'a VectorMut<'_, T>; 2],
        count: usize,
        cut: f64,
        everywhere: bool,
    ) -> Self {
        Self {
            grid,
            scheme,
            velocity: Velocity(view(velocity)),
            open: Velocity(view(open)),
            tau: 1.0 / count as f64,
            cut,
            everywhere,
        }
    }

    fn series(self) -> series::Series<'a, T> {
        series::Series {
            grid: self.grid,
            velocity: self.velocity,
            weights: series::weights(self.scheme),
            tau: self.tau,
            cut: self.cut,
            negligible: self.cut * negligible::<T>(),
            everywhere: self.everywhere,
        }
    }

    fn limited(self) -> limited::Substep<'a, T> {
        limited::Substep {
            grid: self.grid,
            velocity: self.velocity,
            open: self.open,
            tau: self.tau,
            negligible: self.cut * negligible::<T>(),
            everywhere: self.everywhere,
        }
    }
}

impl<T: Real> Transport<'_, T> {
    /// `to = A[from, v]` with the velocity that was loaded; fields of cells.
    pub fn forward(&mut self, exec: &dyn Exec, from: &[T], to: &mut [T]) {
        let states = core::mem::take(&mut self.states);
        self.carry(exec, self.substeps, from, [&mut *to, &mut states[..from.len()]]);
        self.states = states;
        self.forget_outside(to);
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
        let (grid, stride) = (self.grid, Self::stride(self.grid));
        let faces = [&self.velocity, &self.open];
        let sub = Substep::new(grid, self.scheme, faces, self.substeps, self.cut, self.everywhere);
        let terms = Terms {
            fields: &mut self.terms[begin * stride..],
            stride,
            sizes: &mut self.sizes[begin * grid.rows()..],
        };
        match self.scheme {
            Scheme::Quick | Scheme::Central if self.rolling => {
                series::sum_rolling(exec, &sub.series(), from, terms, to, self.scratch);
                Some(0)
            }
            Scheme::Quick | Scheme::Central => {
                series::sum(exec, &sub.series(), from, terms, to, self.scratch)
            }
            Scheme::Limited => limited::forward(exec, &sub.limited(), from, terms, to, self.scratch),
            Scheme::SemiLagrangian => {
                if !to.is_empty() {
                    semi_lagrangian::trace(exec, grid, sub.velocity, sub.tau, from, to);
                }
                Some(0)
            }
        }
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

    /// Sets a field of cells to 0 outside the box: smoke that has left it in a step is gone.
    fn forget_outside(&self, field: &mut [T]) {
        if self.grid.is_open() {
            let (n, solids) = (self.grid.n[0], self.solids);
            let rows = field.chunks_exact_mut(n).enumerate();
            rows.for_each(|(row, values)| solids.clear(n, row, OUTSIDE, values));
        }
    }

    /// The adjoint of the step from `rho`: `mu` <- A_rho^T mu where there is smoke (elsewhere it may stay as it is, which no gradient
    /// by a velocity depends on, unless it goes back [everywhere](Self::everywhere)), and [`Self::gradient`] = A_v^T mu.
    pub fn backward(&mut self, exec: &dyn Exec, rho: &[T], mu: &mut [T]) {
        self.forget_outside(mu);
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
        let (grid, stride) = (self.grid, Self::stride(self.grid));
        let faces = [&self.velocity, &self.open];
        let sub = Substep::new(grid, self.scheme, faces, self.substeps, self.cut, self.everywhere);
        let kept = Terms {
            fields: &self.terms[terms.begin * stride..],
            stride,
            sizes: &self.sizes[terms.begin * grid.rows()..],
        };
        let mut back = Backward {
            mu,
            work: self.adjoint.each_mut().map(|z| &mut **z),
            gradient: reborrow(&mut self.gradient),
            first,
        };
        match self.scheme {
            Scheme::Quick | Scheme::Central => {
                series::adjoint(exec, &sub.series(), rho, kept, terms.count, back, self.scratch);
            }
            Scheme::Limited => limited::backward(exec, &sub.limited(), rho, kept, back, self.scratch),
            Scheme::SemiLagrangian => {
                if first {
                    back.gradient
                        .iter_mut()
                        .for_each(|component| component.fill(T::ZERO));
                }
                let after = &mut back.work[0][..back.mu.len()];
                after.copy_from_slice(back.mu);
                let step = semi_lagrangian::Step {
                    grid,
                    velocity: sub.velocity,
                    tau: sub.tau,
                    rho,
                    mu: after,
                };
                semi_lagrangian::gradient(exec, &step, back.gradient);
                semi_lagrangian::adjoint(exec, &step, back.mu);
            }
        }
    }

    /// A_v^T mu of the last [`Self::backward`], at the faces.
    #[must_use]
    pub fn gradient(&self) -> Vector<'_, T> {
        view(&self.gradient)
    }
}
