//! Target-driven smoke (Fattal & Lischinski 2004): a force towards the next keyframe, and gathering of what is astray.
//!
//! ```text
//! v' = F - attenuation v,  F = drive rho~ grad(rho*~) / rho*~          rho' = gathering div(rho rho*~ grad(rho - rho*))
//! ```
//!
//! Blurs rho~ = C rho / (m + 1) by the metric of the objective, whose Gaussians reach across the box: a narrow one alone leaves no slope
//! where the target is far, a wide one alone no shape where it is near. The unit of time is the way from one keyframe to the next,
//! the unit of length the longest side, so that one choice serves all sizes.

use crate::exec::{Exec, RowBuffers, for_rows};
use crate::field::{VectorMut, reborrow, rows, sums};
use crate::grid::levels::Levels;
use crate::grid::{Grid, Side};
use crate::memory::{Pool, Sharing};
use crate::operators::blur::{Blur, Metric};
use crate::real::Real;
use crate::transport::Stop;

/// rho*~ is at least this part of its maximum where it divides.
const FLOOR: f64 = 1e-6;
/// Sub-steps of gathering at most.
const MOST_SUBSTEPS: f64 = 4096.0;

/// Blurred densities and what they drive.
pub struct Drive<'a, T> {
    grid: &'a Grid,
    filters: usize,
    smoke: &'a mut [T],
    target: &'a mut [T],
    gathered: &'a mut [T],
    blur: Blur<'a, T>,
}

impl<'a, T: Real> Drive<'a, T> {
    /// Takes its workspace from a pool, for the finest grid.
    pub fn carve(
        hierarchy: &'a Levels<'_, T>,
        metric: Metric,
        threads: usize,
        pool: &mut Pool<'a, T>,
    ) -> Self {
        let grid = &hierarchy.finest;
        let len = hierarchy.finest.cells();
        pool.group("driving force", Sharing::Together, |pool| {
            let [smoke, target, gathered] = pool.line("blurred densities, gathered smoke", |pool| {
                [(); 3].map(|()| pool.take("field", len))
            });
            Self {
                grid,
                filters: metric.filters,
                smoke,
                target,
                gathered,
                blur: Blur::carve(hierarchy, 0, metric, threads, pool),
            }
        })
    }

    /// Blurs the smoke and its target.
    pub fn load(&mut self, exec: &dyn Exec, rho: &[T], target: &[T]) {
        self.blur.apply(exec, rho, self.smoke);
        self.blur.apply(exec, target, self.target);
    }

    /// Slot `slot` of the trajectory `out` = `s` rho~ grad(rho*~) / rho*~.
    pub fn force(&self, exec: &dyn Exec, s: f64, out: &mut VectorMut<'_, T>, slot: usize, sums: &mut [f64]) {
        let (grid, smoke, target) = (self.grid, &*self.smoke, &*self.target);
        let n = grid.n[0];
        let largest = sums::largest(exec, grid, sums, |row| {
            rows::max_abs(&target[row * n..(row + 1) * n])
        });
        let s = s / (self.filters + 1) as f64;
        at_faces(exec, grid, out, slot, |axis, low, high| {
            let [near, far] = [low, high].map(|cell| target[cell].to_f64());
            let middle = (0.5 * (near + far)).max(FLOOR * largest);
            s * 0.5 * (smoke[low] + smoke[high]).to_f64() * (far - near) / (grid.h[axis] * middle)
        });
    }

    /// `rho += s div(rho rho*~ grad(rho - rho*))`, in as many sub-steps as keep it stable; no flux through walls,
    /// nor where transport has undershot 0, which would gather the wrong way.
    ///
    /// # Errors
    /// [`Stop::TooFast`] when that is too many.
    pub fn gather(
        &mut self,
        exec: &dyn Exec,
        s: f64,
        rho: &mut [T],
        goal: &[T],
        sums: &mut [f64],
    ) -> Result<(), Stop> {
        let (grid, target) = (self.grid, &*self.target);
        let n = grid.n[0];
        let top = |field: &[T], sums: &mut [f64]| {
            sums::largest(exec, grid, sums, |row| {
                rows::max_abs(&field[row * n..(row + 1) * n])
            })
        };
        let s = s / (self.filters + 1) as f64;
        let stiffness: f64 = (0..grid.dims).map(|a| 4.0 / (grid.h[a] * grid.h[a])).sum();
        let rate = s * stiffness * top(rho, sums) * top(target, sums);
        if !(rate <= MOST_SUBSTEPS) {
            return Err(Stop::TooFast);
        }
        let substeps = libm::ceil(rate).max(1.0);
        let next = &mut *self.gathered;
        for _ in 0..substeps as usize {
            let from = &*rho;
            let flux = |axis: usize, low: usize, high: usize| {
                let [at, around] = [from, target].map(|field| 0.5 * (field[low] + field[high]).to_f64());
                at.max(0.0) * around * ((from[high] - goal[high]) - (from[low] - goal[low])).to_f64()
                    / grid.h[axis]
            };
            // Through exits nothing is gathered.
            let beside = |at, axis, side| beside_inside(grid, at, axis, side);
            for_rows(exec, grid.rows(), RowBuffers::fields([&mut *next]), |task| {
                let [next] = task.fields;
                for (x, next) in next.iter_mut().enumerate() {
                    let (at, here) = (grid.cell_at(task.row, x), task.row * n + x);
                    let along = |axis: usize| {
                        let low = beside(at, axis, Side::Low);
                        let low = low.map_or(0.0, |low| flux(axis, grid.index(low), here));
                        let high = beside(at, axis, Side::High);
                        let high = high.map_or(0.0, |high| flux(axis, here, grid.index(high)));
                        (high - low) / grid.h[axis]
                    };
                    *next = from[here] + T::from_f64(s / substeps * (0..grid.dims).map(along).sum::<f64>());
                }
            });
            rho.copy_from_slice(next);
        }
        Ok(())
    }
}

/// Writes `value(axis, low cell, high cell)` to every face of slot `slot`, 0 on walls and at exits.
fn at_faces<T: Real>(
    exec: &dyn Exec,
    grid: &Grid,
    out: &mut VectorMut<'_, T>,
    slot: usize,
    value: impl Fn(usize, usize, usize) -> f64 + Sync,
) {
    let n = grid.n[0];
    for_rows(exec, grid.rows(), RowBuffers::fields(reborrow(out)), |task| {
        for (axis, out) in task.fields.into_iter().enumerate().take(grid.dims) {
            for (x, out) in out[slot * n..(slot + 1) * n].iter_mut().enumerate() {
                let high = grid.cell_at(task.row, x);
                let low = beside_inside(grid, high, axis, Side::Low);
                let low = low.map(|low| grid.index(low));
                *out = low.map_or(T::ZERO, |low| T::from_f64(value(axis, low, task.row * n + x)));
            }
        }
    });
}

/// The cell beside one, where both are in the box.
fn beside_inside(grid: &Grid, at: [usize; 3], axis: usize, side: Side) -> Option<[usize; 3]> {
    let beside = grid.beside(at, axis, side)?;
    let exit = grid.is_open() && (grid.is_outside(beside) || grid.is_outside(at));
    (!exit).then_some(beside)
}
