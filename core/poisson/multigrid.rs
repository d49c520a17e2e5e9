//! Poisson's problem by V(2,2) cycles on the grids of a hierarchy, for a batch of slots at once.
//!
//! The smoother is Richardson's with the Chebyshev parameters of the upper part of the spectrum: flat loops that need no
//! colours, on any box.

use super::batch::{Batch, Measured, divergence_in_row, subtract_gradient_in_row};
use super::richardson::{self, residual_row};
use crate::exec::{Exec, RowBuffers, for_rows};
use crate::field::transfer::{Move, Place, Placed};
use crate::field::{Block, Vector, rows};
use crate::grid::Grid;
use crate::grid::levels::{Levels, MAX_LEVELS};
use crate::grid::tables::Tables;
use crate::grid::taps::Transfer;
use crate::memory::Pool;
use crate::observe::{Event, Observer};
use crate::operators::divergence::divergence;
use crate::real::Real;
use core::ops::ControlFlow;

/// The most V-cycles of a pass.
const CYCLES: usize = 12;
/// The factor that a pass may gain; then the next starts from fresh residuals.
const GAIN: f64 = 1e-4;
/// What a smoothing may leave of the upper part of the spectrum: two steps are enough unless cells are much longer than wide.
const SMOOTHED: f64 = 0.4;
/// What smoothing on the coarsest grid may leave of the whole spectrum.
const SOLVED: f64 = 1e-4;
/// Rows of scratch: two shifts, a residual, a sum.
const SCRATCH_ROWS: usize = 4;

/// The numbers of one level: potential, its next iterate, right-hand side.
#[derive(Debug)]
struct LevelMut<'a, T> {
    grid: &'a Grid,
    q: &'a mut [T],
    next: &'a mut [T],
    rhs: &'a mut [T],
}

/// The workspace.
#[derive(Debug)]
pub struct Multigrid<'a, T> {
    levels: heapless::Vec<LevelMut<'a, T>, MAX_LEVELS>,
    tables: heapless::Vec<&'a Tables<'a, T>, MAX_LEVELS>,
    pub(super) scratch: &'a mut [T],
}

/// Numbers of scratch of a thread.
#[must_use]
pub fn scratch_per_thread(finest: &Grid, batch: usize) -> usize {
    SCRATCH_ROWS * Block::largest(finest.n[0], batch)
}

impl<'a, T: Real> Multigrid<'a, T> {
    /// Takes its numbers. The grid is number `level` of the hierarchy.
    pub fn carve(
        hierarchy: &'a Levels<'_, T>,
        level: usize,
        batch: usize,
        scratch: usize,
        pool: &mut Pool<'a, T>,
    ) -> Self {
        let levels = pool.line("potentials of a batch of slots, all levels", |pool| {
            let mut field = |grid: &Grid| pool.take("field", grid.cells() * batch);
            let level_of = |grid: &'a Grid| LevelMut {
                grid,
                q: field(grid),
                next: field(grid),
                rhs: field(grid),
            };
            hierarchy.grids[level..].iter().map(level_of).collect()
        });
        Self {
            levels,
            tables: hierarchy.tables[level..].iter().collect(),
            scratch: pool.take("rows and panels", scratch),
        }
    }

    /// q with div grad q = rhs but for `goal`, or as much as a pass can gain on `divergence`.
    pub fn solve(
        &mut self,
        exec: &dyn Exec,
        observer: &mut dyn Observer,
        batch: Batch,
        divergence: f64,
        goal: f64,
        sums: &mut [f64],
    ) -> ControlFlow<()> {
        self.levels[0].q.fill(T::ZERO);
        let enough = goal.max(GAIN * divergence);
        for _ in 0..CYCLES {
            self.vcycle(exec, batch.count);
            observer.on(Event::Work)?;
            if !(self.residual(exec, batch.count, sums) > enough) {
                break;
            }
        }
        ControlFlow::Continue(())
    }

    /// Writes the right-hand side div v and returns max |div v| and max |v|. `sums` holds two values a row.
    pub fn divergence(
        &mut self,
        exec: &dyn Exec,
        batch: Batch,
        v: Vector<'_, T>,
        sums: &mut [f64],
    ) -> Measured {
        let LevelMut { grid, rhs, .. } = &mut self.levels[0];
        let grid = *grid;
        let sums = &mut sums[..Measured::SUMS * grid.rows()];
        let rhs = &mut rhs[..grid.cells() * batch.count];
        for_rows(
            exec,
            grid.rows(),
            RowBuffers::fields([rhs]).with_sums(&mut *sums),
            |task| {
                let [rhs] = task.fields;
                let mut slots = rhs.chunks_exact_mut(grid.n[0]);
                divergence_in_row(grid, batch, task.row, v, |faces, scales| {
                    divergence(faces, scales, slots.next().unwrap_or(&mut []))
                })
                .write(task.sums);
            },
        );
        Measured::read(sums)
    }

    /// v -= grad q and, unless p is empty, p -= q; `fields` are the components of v and p.
    pub fn subtract_gradient(&mut self, exec: &dyn Exec, batch: Batch, fields: &mut [&mut [T]; 4]) {
        let LevelMut { grid, q, .. } = &self.levels[0];
        let grid = *grid;
        let q = &q[..grid.cells() * batch.count];
        let fields = fields.each_mut().map(|field| &mut **field);
        for_rows(
            exec,
            grid.rows(),
            RowBuffers::fields(fields).with_scratch(&mut *self.scratch),
            |task| {
                let mut fields = task.fields;
                for block in batch.blocks(grid) {
                    subtract_gradient_in_row(
                        &batch.compact(&block),
                        task.row,
                        q,
                        block.span_in_row(),
                        &mut fields,
                        task.scratch,
                    );
                }
            },
        );
    }

    fn vcycle(&mut self, exec: &dyn Exec, slots: usize) {
        let coarsest = self.levels.len() - 1;
        for level in 0..coarsest {
            self.smooth(exec, level, slots, SMOOTHED);
            self.descend(exec, level, slots);
        }
        self.smooth(exec, coarsest, slots, SOLVED);
        for level in (0..coarsest).rev() {
            self.ascend(exec, level, slots);
            self.smooth(exec, level, slots, SMOOTHED);
        }
    }

    /// Richardson steps q + (div grad q - rhs) / (diagonal root), with the roots of the Chebyshev polynomial on the upper spectrum.
    /// That begins where one axis alone oscillates: low on grids whose cells are longer along it, and then there are more steps.
    fn smooth(&mut self, exec: &dyn Exec, level: usize, slots: usize, leave: f64) {
        let LevelMut { grid, q, next, rhs } = &mut self.levels[level];
        let len = grid.cells() * slots;
        let grid = *grid;
        let rhs = &rhs[..len];
        let (mut q, mut next) = (&mut q[..len], &mut next[..len]);
        let stiffness = |a: usize| 2.0 / (grid.h[a] * grid.h[a]);
        let diagonal: f64 = (0..grid.dims).map(stiffness).sum();
        let lowest = (0..grid.dims).map(stiffness).fold(diagonal, f64::min) / diagonal;
        let degree = richardson::degree(lowest, leave);
        for step in 0..degree {
            let root = richardson::root(lowest, degree, step);
            let omega = T::from_f64(1.0 / (root * diagonal));
            let from = &*q;
            for_rows(
                exec,
                grid.rows(),
                RowBuffers::fields([&mut *next]).with_scratch(&mut *self.scratch),
                |task| {
                    let [out] = task.fields;
                    for block in Block::all(grid, slots) {
                        let out = &mut out[block.span_in_row()];
                        residual_row(&block, task.row, from, rhs, out, task.scratch);
                        rows::combine(out, omega, block.of(from, task.row));
                    }
                },
            );
            core::mem::swap(&mut q, &mut next);
        }
    }

    /// The coarse right-hand side: the mean of div grad q - rhs with its sign turned, and a coarse potential of zero.
    fn descend(&mut self, exec: &dyn Exec, level: usize, slots: usize) {
        let tables = self.tables[level];
        let (fine, coarse) = self.levels.split_at_mut(level + 1);
        let (fine, coarse) = (&fine[level], &mut coarse[0]);
        let len = coarse.grid.cells() * slots;
        coarse.q[..len].fill(T::ZERO);
        let (grid, fine_grid) = (coarse.grid, fine.grid);
        let (q, rhs) = (
            &fine.q[..fine_grid.cells() * slots],
            &fine.rhs[..fine_grid.cells() * slots],
        );
        let step = Move {
            tables,
            source: fine_grid,
            target: grid,
            cell: Transfer::RestrictCell,
            face: Transfer::RestrictCell,
        };
        for_rows(
            exec,
            grid.rows(),
            RowBuffers::fields([&mut coarse.rhs[..len]]).with_scratch(&mut *self.scratch),
            |task| {
                let [out] = task.fields;
                for block in Block::all(fine_grid, slots) {
                    let (shifts, rest) = task.scratch.split_at_mut(2 * block.len());
                    let (residual, sum) = rest.split_at_mut(block.len());
                    let sum = &mut sum[..block.len()];
                    sum.fill(T::ZERO);
                    step.each_source_row(Place::Cell, task.row, |row, weight| {
                        residual_row(&block, row, q, rhs, residual, shifts);
                        rows::add_scaled(sum, -weight, residual);
                    });
                    let out = &mut out[Block { grid, ..block }.span_in_row()];
                    out.fill(T::ZERO);
                    tables.add_along_x(Transfer::RestrictCell, sum, fine_grid.n[0], out, grid.n[0]);
                }
            },
        );
    }

    /// q += P q_c.
    fn ascend(&mut self, exec: &dyn Exec, level: usize, slots: usize) {
        let tables = self.tables[level];
        let (fine, coarse) = self.levels.split_at_mut(level + 1);
        let (fine, coarse) = (&mut fine[level], &coarse[0]);
        let step = Move {
            tables,
            source: coarse.grid,
            target: fine.grid,
            cell: Transfer::ProlongCell,
            face: Transfer::ProlongCell,
        };
        let grid = fine.grid;
        let q = Placed {
            place: Place::Cell,
            values: &coarse.q[..coarse.grid.cells() * slots],
        };
        let buffers =
            RowBuffers::fields([&mut fine.q[..grid.cells() * slots]]).with_scratch(&mut *self.scratch);
        for_rows(exec, grid.rows(), buffers, |task| {
            let [out] = task.fields;
            for block in Block::all(grid, slots) {
                let out = &mut out[block.span_in_row()];
                step.add_row(q, &block, task.row, T::ONE, out, task.scratch);
            }
        });
    }

    /// max |rhs - div grad q| on the finest level.
    fn residual(&mut self, exec: &dyn Exec, slots: usize, sums: &mut [f64]) -> f64 {
        let LevelMut { grid, q, rhs, .. } = &self.levels[0];
        let grid = *grid;
        let (q, rhs) = (&q[..grid.cells() * slots], &rhs[..grid.cells() * slots]);
        let sums = &mut sums[..grid.rows()];
        for_rows(
            exec,
            grid.rows(),
            RowBuffers::sums(&mut *sums).with_scratch(&mut *self.scratch),
            |task| {
                task.sums[0] = 0.0;
                for block in Block::all(grid, slots) {
                    let (shifts, rest) = task.scratch.split_at_mut(2 * block.len());
                    let out = &mut rest[..block.len()];
                    residual_row(&block, task.row, q, rhs, out, shifts);
                    task.sums[0] = rows::largest([task.sums[0], rows::max_abs(out)]);
                }
            },
        );
        rows::largest(sums.iter().copied())
    }
}
