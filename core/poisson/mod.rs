//! The projection Q onto div v = 0 (mathematics section 1): v - grad q with div grad q = div v, for many slots at once.
//!
//! The Poisson problem is solved by eigenvectors, among solid cells by conjugate gradients on top of that. Where some flow matters more than
//! other, the rest can be made to give way ([`Projection::project_weighted`]).

mod batch;
mod conjugate;
mod eigen;
mod recursion;
pub mod spectral;
mod weighted;

use crate::exec::{Exec, RowBuffers, for_rows};
use crate::field::{VectorMut, reborrow, rows, transform, view};
use crate::grid::Grid;
use crate::grid::levels::Levels;
use crate::grid::solids::{Solids, closed};
use crate::memory::{Pool, Sharing, pooled};
use crate::observe::Observer;
use crate::real::Real;
use batch::{Batch, MAX_BATCH, Measured, divergence_in_row, velocity};
use core::ops::ControlFlow;
use spectral::Spectral;

/// The most defect corrections. Each starts from the divergence of the result, so that single precision reaches its rounding floor.
const PASSES: usize = 4;

/// The projection's workspace.
#[derive(Debug)]
pub struct Projection<'a, T> {
    grid: &'a Grid,
    solids: Solids<'a>,
    /// Slots of the trajectories.
    slots: usize,
    /// Slots of a batch.
    batch: usize,
    solver: Spectral<'a, T>,
}

/// The slots of a batch: about as many in each, at most [`MAX_BATCH`] and no more than there are rows.
fn batch_of(grid: &Grid, slots: usize) -> usize {
    slots.div_ceil(slots.div_ceil(MAX_BATCH.min(grid.whole().rows())))
}

impl<'a, T: Real> Projection<'a, T> {
    /// Takes its workspace from a pool. The grid is number `level` of the hierarchy.
    pub fn carve(
        hierarchy: &'a Levels<'_, T>,
        level: usize,
        slots: usize,
        threads: usize,
        pool: &mut Pool<'a, T>,
    ) -> Self {
        let grid = &hierarchy.grids[level];
        let batch = batch_of(grid, slots);
        let scratch = pooled(threads * transform::scratch_len(grid));
        pool.group("projection", Sharing::Together, |pool| {
            let of_grid = (hierarchy.spectrum(level), hierarchy.solids(level));
            let solver = Spectral::carve(grid, of_grid, batch, scratch, pool);
            Self {
                grid,
                solids: hierarchy.solids(level),
                slots,
                batch,
                solver,
            }
        })
    }

    /// max |div v| h_x / max |v|, the largest of all batches of slots of the trajectory `v`, and max |v|; not finite where `v` is not.
    /// `sums` holds two values a row.
    pub fn relative_divergence(
        &mut self,
        exec: &dyn Exec,
        v: &VectorMut<'_, T>,
        sums: &mut [f64],
    ) -> [f64; 2] {
        let (grid, solids) = (self.grid, self.solids);
        let v = view(v);
        let mut fastest: f64 = 0.0;
        let sums = &mut sums[..Measured::SUMS * grid.rows()];
        let relative = rows::largest(Batch::all(self.slots, self.batch).map(|batch| {
            let scratch = &mut *self.solver.scratch;
            for_rows(
                exec,
                grid.rows(),
                RowBuffers::sums(&mut *sums).with_scratch(scratch),
                |task| {
                    let block = batch.block(grid);
                    let of = |axis: usize, row: usize| block.of(v[axis], row);
                    divergence_in_row((grid, solids), task.row, of, &mut [], task.scratch).write(task.sums);
                },
            );
            let Measured { divergence, speed } = Measured::read(exec, grid, sums);
            fastest = rows::largest([fastest, speed]);
            if divergence > 0.0 {
                divergence * grid.h[0] / speed
            } else {
                divergence
            }
        }));
        [relative, fastest]
    }

    /// Projects every slot of the trajectory `v`, to max |div v| at most `tolerance` times what it was, or the rounding floor
    /// of `v`. With `potential`, a trajectory of cells p for which v holds + grad p, p changes along. Returns max |div v| after.
    ///
    /// `sums` holds two values a row.
    pub fn project(
        &mut self,
        exec: &dyn Exec,
        observer: &mut dyn Observer,
        v: &mut VectorMut<'_, T>,
        potential: Option<&mut [T]>,
        tolerance: f64,
        sums: &mut [f64],
    ) -> ControlFlow<(), f64> {
        self.close(exec, v);
        let [v0, v1, v2] = reborrow(v);
        let mut fields = [v0, v1, v2, potential.unwrap_or(&mut [])];
        let mut worst: f64 = 0.0;
        for batch in Batch::all(self.slots, self.batch) {
            let divergence = self.project_batch(exec, observer, batch, &mut fields, tolerance, sums)?;
            worst = rows::largest([worst, divergence]);
        }
        ControlFlow::Continue(worst)
    }

    /// Sets v to 0 at the closed faces of solid cells.
    pub fn close(&self, exec: &dyn Exec, v: &mut VectorMut<'_, T>) {
        let (grid, solids) = (self.grid, self.solids);
        if !solids.there() {
            return;
        }
        for_rows(exec, grid.rows(), RowBuffers::fields(reborrow(v)), |task| {
            for (axis, faces) in task.fields.into_iter().enumerate().take(grid.dims) {
                solids.clear(grid.n[0], task.row, closed(axis), faces);
            }
        });
    }

    /// Projects some slots of `fields`, the components of v and p.
    fn project_batch(
        &mut self,
        exec: &dyn Exec,
        observer: &mut dyn Observer,
        batch: Batch,
        fields: &mut [&mut [T]; 4],
        tolerance: f64,
        sums: &mut [f64],
    ) -> ControlFlow<(), f64> {
        let solver = &mut self.solver;
        let Measured {
            mut divergence,
            speed,
        } = solver.divergence(exec, batch, velocity(fields), sums);
        let goal = (tolerance * divergence).max(4.0 * T::EPSILON * speed / self.grid.h[0]);
        for pass in 0..PASSES {
            if !(divergence > goal) {
                break;
            }
            if pass > 0 {
                // The right-hand side of the correction; the pass before only measured it.
                solver.divergence(exec, batch, velocity(fields), sums);
            }
            solver.solve(exec, observer, batch, 0.5 * goal, None)?;
            divergence = solver.subtract_gradient(exec, batch, fields, sums).divergence;
        }
        ControlFlow::Continue(divergence)
    }
}
