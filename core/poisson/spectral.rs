//! Poisson's problem by eigenvectors: a transform along every axis, a division by the eigenvalues, and back, slot by slot.

use super::batch::{Batch, MAX_BATCH, Measured, divergence_in_row, inside, subtract_gradient_in_row};
use super::{conjugate, eigen};
use crate::exec::{Exec, RowBuffers, Serial, for_rows};
use crate::field::turned::Turned;
use crate::field::{Block, Vector};
use crate::grid::Grid;
use crate::grid::solids::Solids;
use crate::grid::spectrum::Spectrum;
use crate::memory::Pool;
use crate::observe::{Event, Observer};
use crate::operators::divergence::divergence;
use crate::real::Real;
use core::ops::ControlFlow;

/// The workspace: potentials slot by slot, each with the cells of a slot side by side.
#[derive(Debug)]
pub struct Spectral<'a, T> {
    grid: &'a Grid,
    spectrum: Spectrum<'a, T>,
    q: &'a mut [T],
    solids: Solids<'a>,
    /// Fields of conjugate gradients for every slot of a batch, where there are solid cells.
    work: &'a mut [T],
    /// Where ranks share the box.
    turned: Turned<'a, T>,
    pub(super) scratch: &'a mut [T],
}

impl<'a, T: Real> Spectral<'a, T> {
    /// Takes its numbers.
    pub fn carve(
        grid: &'a Grid,
        (spectrum, solids): (Spectrum<'a, T>, Solids<'a>),
        batch: usize,
        scratch: usize,
        pool: &mut Pool<'a, T>,
    ) -> Self {
        Self {
            grid,
            spectrum,
            q: pool.take("potentials of a batch of slots", grid.cells() * batch),
            work: if solids.obstacles() {
                pool.take("conjugate gradients", conjugate::FIELDS * grid.cells() * batch)
            } else {
                &mut []
            },
            solids,
            turned: Turned::carve(grid, batch, pool),
            scratch: pool.take("rows and panels", scratch),
        }
    }

    /// Writes the right-hand side div v and returns max |div v| and max |v|. `sums` holds two values a row.
    pub fn divergence(
        &mut self,
        exec: &dyn Exec,
        batch: Batch,
        v: Vector<'_, T>,
        sums: &mut [f64],
    ) -> Measured {
        let (grid, solids) = (self.grid, self.solids);
        let sums = &mut sums[..Measured::SUMS * grid.rows()];
        let mut slots = self.q.chunks_exact_mut(grid.cells()).take(batch.count);
        let fields: [_; MAX_BATCH] = core::array::from_fn(|_| slots.next().unwrap_or(&mut []));
        for_rows(
            exec,
            grid.rows(),
            RowBuffers::fields(fields).with_sums(&mut *sums),
            |task| {
                let mut slots = task.fields.into_iter();
                divergence_in_row(grid, batch, task.row, v, |faces, scales| {
                    let out = slots.next().unwrap_or(&mut []);
                    let found = divergence(faces, scales, out);
                    inside(grid, solids, task.row, found, out)
                })
                .write(task.sums);
            },
        );
        Measured::read(exec, grid, sums)
    }

    /// q with div grad q = the right-hand side, or div W^-2 grad q with an `importance` W of cells; among solid cells until what is left is below
    /// `goal`.
    pub fn solve(
        &mut self,
        exec: &dyn Exec,
        observer: &mut dyn Observer,
        batch: Batch,
        goal: f64,
        importance: Option<&[T]>,
    ) -> ControlFlow<()> {
        let (grid, spectrum, solids) = (self.grid, &self.spectrum, self.solids);
        let q = &mut self.q[..grid.cells() * batch.count];
        let obstacles = solids.obstacles();
        let fields = if obstacles { conjugate::FIELDS } else { 0 };
        let work = &mut self.work[..fields * grid.cells() * batch.count];
        if grid.is_part() {
            let (cells, turned) = (grid.cells().max(1), &mut self.turned);
            if obstacles {
                let work = work.chunks_exact_mut(conjugate::FIELDS * cells);
                for (q, work) in q.chunks_exact_mut(cells).zip(work) {
                    let grids = (grid, spectrum, solids);
                    conjugate::solve(exec, grids, goal, importance, q, work, turned, self.scratch);
                }
            } else {
                eigen::solve_turned(exec, (grid, spectrum), q, turned, self.scratch);
            }
            return observer.on(Event::Work);
        }
        let one = |exec: &dyn Exec, q: &mut [T], work: &mut [T], scratch: &mut [T]| {
            if obstacles {
                let (grids, turned) = ((grid, spectrum, solids), &mut Turned::default());
                conjugate::solve(exec, grids, goal, importance, q, work, turned, scratch);
            } else {
                eigen::solve(exec, (grid, spectrum), q, scratch);
            }
        };
        // A slot for each thread; a slot alone, in which there is less to share, on all of them.
        if batch.count == 1 {
            one(exec, q, work, self.scratch);
        } else {
            let buffers = RowBuffers::fields([q, work]).with_scratch(&mut *self.scratch);
            for_rows(exec, batch.count, buffers, |task| {
                let [q, work] = task.fields;
                one(&Serial, q, work, task.scratch);
            });
        }
        observer.on(Event::Work)
    }

    /// The potentials that were found, slot by slot.
    pub fn potentials(&self) -> &[T] {
        self.q
    }

    /// v -= grad q and, unless p is empty, p -= q; `fields` are the components of v and p.
    pub fn subtract_gradient(&mut self, exec: &dyn Exec, batch: Batch, fields: &mut [&mut [T]; 4]) {
        let grid = self.grid;
        let q = &*self.q;
        let fields = fields.each_mut().map(|field| &mut **field);
        for_rows(
            exec,
            grid.rows(),
            RowBuffers::fields(fields).with_scratch(&mut *self.scratch),
            |task| {
                let mut fields = task.fields;
                let alone = Block {
                    grid,
                    slots: 1,
                    first: 0,
                    count: 1,
                };
                for (index, q) in q.chunks_exact(grid.cells()).take(batch.count).enumerate() {
                    subtract_gradient_in_row(
                        &alone,
                        task.row,
                        q,
                        batch.slot(grid, index).span_in_row(),
                        &mut fields,
                        task.scratch,
                    );
                }
            },
        );
    }
}
