//! The multiplier: lambda/K <- lambda/K + beta (v - v*), where v* = t + lambda/K.

use super::Admm;
use crate::exec::{Exec, RowBuffers, for_rows};
use crate::field::{Vector, reborrow, rows, sums, view};
use crate::grid::{Grid, Space};
use crate::progress::{Progress, Status};
use crate::real::Real;

impl<T: Real, S: Space> Admm<'_, T, S> {
    /// Measures max |v - v*| and updates the multiplier, unless the plain augmented Lagrangian holds it.
    pub(super) fn update_multiplier(
        &mut self,
        exec: &dyn Exec,
        progress: &mut Progress,
    ) -> Result<(), Status> {
        let (grid, slots) = (&self.levels.finest, self.settings.dimensions.slots);
        let lost = self.history.damped && self.spare[0].is_empty();
        let (v, target) = (view(&self.v), view(&self.target));
        let speed = sums::max_abs(exec, grid, slots, v, self.sums);
        let gap = if lost {
            f64::INFINITY
        } else {
            gap(exec, grid, slots, [v, target, view(&self.multiplier)], self.sums)
        };
        progress.admm.gap = if speed > 0.0 { gap / speed } else { 0.0 };
        progress.admm.held = !lost && self.history.hold(progress.admm.gap);
        if !progress.admm.held {
            let beta = T::from_f64(self.settings.params.relaxation);
            for_rows(
                exec,
                grid.rows(),
                RowBuffers::fields(reborrow(&mut self.multiplier)),
                |task| {
                    for (axis, multiplier) in task.fields.into_iter().enumerate().take(S::DIM) {
                        let (v, t) = (
                            sums::row(grid, slots, v[axis], task.row),
                            sums::row(grid, slots, target[axis], task.row),
                        );
                        if lost {
                            multiplier.fill(T::ZERO);
                            rows::add_difference(multiplier, T::ONE, v, t);
                        } else {
                            rows::relax(multiplier, beta, v, t);
                        }
                    }
                },
            );
        }
        let residual = progress.admm.nso_residuals.last().copied().unwrap_or(f64::NAN);
        let of_density = progress.admm.ao_residuals.last().copied().unwrap_or(f64::NAN);
        progress.admm.kkt = rows::largest([gap, of_density, residual]);
        if speed.is_finite() {
            Ok(())
        } else {
            Err(Status::NotFinite)
        }
    }
}

/// max |v - t - lambda/K|.
fn gap<T: Real>(
    exec: &dyn Exec,
    grid: &Grid,
    slots: usize,
    [v, target, multiplier]: [Vector<'_, T>; 3],
    sums: &mut [f64],
) -> f64 {
    sums::largest(exec, grid, sums, |row| {
        rows::largest((0..grid.dims).map(|axis| {
            let [v, t, multiplier] =
                [v[axis], target[axis], multiplier[axis]].map(|field| sums::row(grid, slots, field, row));
            rows::max_distance(v, t, multiplier)
        }))
    })
}
