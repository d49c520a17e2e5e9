//! The projection Q onto div v = 0 (mathematics section 1): v - grad q with div grad q = div v, for many slots at once.
//!
//! The Poisson problem is solved by eigenvectors where no axis is too long for that, else by multigrid.

mod batch;
mod conjugate;
mod eigen;
pub mod multigrid;
mod richardson;
pub mod spectral;

use crate::exec::{Exec, RowBuffers, for_rows};
use crate::field::{VectorMut, reborrow, rows, transform, view};
use crate::grid::Grid;
use crate::grid::levels::Levels;
use crate::grid::solids::{Solids, closed};
use crate::memory::{Pool, Sharing, pooled};
use crate::observe::Observer;
use crate::operators::divergence::divergence;
use crate::real::Real;
use batch::{Batch, MAX_BATCH, Measured, divergence_in_row};
use core::ops::ControlFlow;
use multigrid::Multigrid;
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
    solver: Solver<'a, T>,
}

/// The solver of Poisson's problem.
#[derive(Debug)]
#[expect(
    clippy::large_enum_variant,
    reason = "there is no allocator, and one of it lives at a time"
)]
enum Solver<'a, T> {
    Spectral(Spectral<'a, T>),
    Multigrid(Multigrid<'a, T>),
}

/// Calls a method that both solvers have.
macro_rules! each {
    ($solver:expr, $inner:ident => $call:expr) => {
        match $solver {
            Solver::Spectral($inner) => $call,
            Solver::Multigrid($inner) => $call,
        }
    };
}

/// The slots of a batch: about as many in each, at most [`MAX_BATCH`] and no more than there are rows.
fn batch_of(grid: &Grid, slots: usize) -> usize {
    slots.div_ceil(slots.div_ceil(MAX_BATCH.min(grid.rows())))
}

fn scratch_len(finest: &Grid, spectral: bool, batch: usize, threads: usize) -> usize {
    let a_thread = if spectral {
        transform::scratch_len(finest)
    } else {
        multigrid::scratch_per_thread(finest, batch)
    };
    pooled(threads * a_thread)
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
        let spectral = hierarchy.spectrum(level).is_some();
        let scratch = scratch_len(grid, spectral, batch, threads);
        pool.group("projection", Sharing::Together, |pool| {
            let solver = match hierarchy.spectrum(level) {
                Some(spectrum) => {
                    let of_grid = (spectrum, hierarchy.solids(level));
                    Solver::Spectral(Spectral::carve(grid, of_grid, batch, scratch, pool))
                }
                None => Solver::Multigrid(Multigrid::carve(hierarchy, level, batch, scratch, pool)),
            };
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
        let grid = self.grid;
        let v = view(v);
        let mut fastest: f64 = 0.0;
        let sums = &mut sums[..Measured::SUMS * grid.rows()];
        let relative = rows::largest(Batch::all(self.slots, self.batch).map(|batch| {
            let scratch = each!(&mut self.solver, solver => &mut *solver.scratch);
            for_rows(
                exec,
                grid.rows(),
                RowBuffers::sums(&mut *sums).with_scratch(scratch),
                |task| {
                    let out = rows::part_mut(task.scratch, 0..grid.n[0]);
                    divergence_in_row(grid, batch, task.row, v, |faces, scales| {
                        divergence(faces, scales, out)
                    })
                    .write(task.sums);
                },
            );
            let Measured { divergence, speed } = Measured::read(sums);
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
    fn close(&self, exec: &dyn Exec, v: &mut VectorMut<'_, T>) {
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
        let mut goal = None;
        for pass in 0.. {
            let v = [&*fields[0], &*fields[1], &*fields[2]];
            let Measured { divergence, speed } =
                each!(&mut self.solver, solver => solver.divergence(exec, batch, v, sums));
            let goal = *goal.get_or_insert_with(|| {
                (tolerance * divergence).max(4.0 * T::EPSILON * speed / self.grid.h[0])
            });
            if pass == PASSES || !(divergence > goal) {
                return ControlFlow::Continue(divergence);
            }
            match &mut self.solver {
                Solver::Spectral(solver) => solver.solve(exec, observer, batch, 0.5 * goal)?,
                Solver::Multigrid(solver) => solver.solve(exec, observer, batch, divergence, goal, sums)?,
            }
            each!(&mut self.solver, solver => solver.subtract_gradient(exec, batch, fields));
            let [v0, v1, v2, _] = fields;
            self.close(exec, &mut [&mut **v0, &mut **v1, &mut **v2]);
        }
        ControlFlow::Continue(f64::NAN)
    }
}
