//! Smoke that is added on the way: rho_{i+1} = A[rho_i, v_i] + s_i.
//!
//! An emitter of shape E adds `rate` E at every step from `from` to `to`, or fills up to `target` E there:
//! s_i = max(0, target E - A[rho_i, v_i]) where E is positive. What is filled up depends on nothing before, so mu is 0 there on the way back.

use super::Script;
use crate::exec::{Exec, RowBuffers, for_rows};
use crate::field::rows::{self, part};
use crate::grid::Grid;
use crate::real::Real;

/// What an emitter does at one step.
pub(super) struct Supply<'a, T> {
    /// Its number.
    pub index: usize,
    pub shape: &'a [T],
    /// Density that is added where the shape is 1.
    pub added: f64,
    /// Density up to which it is filled where the shape is 1; 0 where it is not.
    pub target: f64,
}

impl<'a, T: Real> Script<'a, T> {
    /// What emitters do when the density has come to `step`.
    pub(super) fn supplies(&self, step: usize, cells: usize) -> impl Iterator<Item = Supply<'a, T>> + Clone {
        let (first, stride) = (self.lists.emitters_begin(), self.stride.get());
        let at = |step: usize| self.first + step as u32 * stride;
        let (begin, end) = (at(step.saturating_sub(1)), at(step));
        let fields = self.fields;
        let spans = self.lists.spans.as_chunks().0;
        let supplies = spans.iter().zip(self.lists.supplies.as_chunks().0).enumerate();
        supplies.filter_map(move |(index, (&[from, to], &[rate, target]))| {
            let steps = to.min(end).saturating_sub(from.max(begin));
            let at = (first + index) * cells;
            (steps > 0).then(|| Supply {
                index,
                shape: part(fields, at..at + cells),
                added: rate * f64::from(steps),
                target,
            })
        })
    }

    /// What emitter `index` does when the density has come to `step`, where it does anything: what it adds where its shape is 1, and up to what
    /// it fills there.
    #[must_use]
    pub fn supply(&self, step: usize, index: usize, cells: usize) -> Option<[f64; 2]> {
        self.supplies(step, cells)
            .find(|supply| supply.index == index)
            .map(|supply| [supply.added, supply.target])
    }

    /// The largest density that emitter `index` adds at a step, or fills up to.
    #[must_use]
    pub fn most_emitted(&self, index: usize, cells: usize) -> f64 {
        let supply = self.lists.supplies.get(2 * index..2 * index + 2).unwrap_or(&[]);
        let first = (self.lists.emitters_begin() + index) * cells;
        let shape = part(self.fields, first..first + cells).iter();
        let most = shape.fold(0.0, |most: f64, &x| most.max(x.to_f64()));
        supply.iter().fold(0.0, |sum, &supply| sum + supply * most)
    }

    /// Adds to `rho`, the density that was carried to `step`, what is emitted on the way there: first by rates, then up to targets.
    pub fn emit(&self, exec: &dyn Exec, grid: &Grid, step: usize, rho: &mut [T]) {
        let (n, supplies) = (grid.n[0], self.supplies(step, grid.cells()));
        if supplies.clone().next().is_none() {
            return;
        }
        for_rows(exec, grid.rows(), RowBuffers::fields([rho]), |task| {
            let ([rho], span) = (task.fields, task.row * n..(task.row + 1) * n);
            for supply in supplies.clone().filter(|supply| supply.added > 0.0) {
                rows::add_scaled(rho, T::from_f64(supply.added), part(supply.shape, span.clone()));
            }
            for supply in supplies.clone().filter(|supply| supply.target > 0.0) {
                let target = T::from_f64(supply.target);
                for (rho, &shape) in rho.iter_mut().zip(part(supply.shape, span.clone())) {
                    if shape > T::ZERO {
                        *rho = rho.max(target * shape);
                    }
                }
            }
        });
    }

    /// Sets mu to 0 where the density `rho` of `step` was filled up to a target.
    pub fn forget(&self, exec: &dyn Exec, grid: &Grid, step: usize, rho: &[T], mu: &mut [T]) {
        let n = grid.n[0];
        let filled = self
            .supplies(step, grid.cells())
            .filter(|supply| supply.target > 0.0);
        if filled.clone().next().is_none() {
            return;
        }
        for_rows(exec, grid.rows(), RowBuffers::fields([mu]), |task| {
            let ([mu], span) = (task.fields, task.row * n..(task.row + 1) * n);
            for supply in filled.clone() {
                let target = T::from_f64(supply.target);
                let cells = part(rho, span.clone())
                    .iter()
                    .zip(part(supply.shape, span.clone()));
                for (mu, (&rho, &shape)) in mu.iter_mut().zip(cells) {
                    if shape > T::ZERO && rho <= target * shape {
                        *mu = T::ZERO;
                    }
                }
            }
        });
    }
}
