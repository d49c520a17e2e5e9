//! The multiplier: lambda/K <- lambda/K + beta (v - v*), where v* = t + lambda/K.

use super::Admm;
use super::report::Course;
use crate::exec::{Exec, RowBuffers, for_rows};
use crate::field::{Vector, reborrow, rows, sums, view};
use crate::grid::{Grid, Space};
use crate::progress::Status;
use crate::real::Real;

impl<T: Real, S: Space> Admm<'_, T, S> {
    /// Measures max |v - v*| and updates the multiplier, unless the plain augmented Lagrangian holds it.
    pub(super) fn update_multiplier(&mut self, exec: &dyn Exec, course: &mut Course) -> Result<(), Status> {
        let (grid, slots) = (&self.animation.levels.finest, self.slots());
        let lost = self.history.damped && self.spare[0].is_empty();
        let (v, target) = (view(&self.animation.v), view(&self.target));
        let speed = sums::max_abs(exec, grid, slots, v, self.animation.sums);
        let gap = if lost {
            f64::INFINITY
        } else {
            gap(
                exec,
                grid,
                slots,
                [v, target, view(&self.multiplier)],
                self.animation.sums,
            )
        };
        course.gap = if speed > 0.0 { gap / speed } else { 0.0 };
        course.held = !lost && self.history.hold(course.gap);
        if !course.held {
            let beta = T::from_f64(self.setup.params.relaxation);
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
        let residual = course.nso_residuals.last().copied().unwrap_or(f64::NAN);
        let of_density = course.ao_residuals.last().copied().unwrap_or(f64::NAN);
        course.kkt = rows::largest([gap, of_density, residual]);
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
