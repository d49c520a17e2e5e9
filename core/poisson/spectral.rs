//! Poisson's problem by eigenvectors: a transform along every axis, a division by the eigenvalues, and back, slot by slot.

use super::batch::{Batch, MAX_BATCH, Measured, divergence_in_row, subtract_gradient_in_row, velocity};
use super::{conjugate, eigen};
use crate::exec::{Exec, RowBuffers, Serial, Slabs, for_rows, for_slabs};
use crate::field::turned::Turned;
use crate::field::{Vector, rows};
use crate::grid::solids::{Solids, closed};
use crate::grid::spectrum::Spectrum;
use crate::grid::{Grid, Side};
use crate::memory::Pool;
use crate::observe::{Event, Observer};
use crate::real::Real;
use core::ops::{ControlFlow, Range};

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
        let sums = rows::part_mut(sums, 0..Measured::SUMS * grid.rows());
        let mut slots = self.q.chunks_exact_mut(grid.cells().max(1)).take(batch.count);
        let fields: [_; MAX_BATCH] = core::array::from_fn(|_| slots.next().unwrap_or(&mut []));
        for_rows(
            exec,
            grid.rows(),
            RowBuffers::fields(fields).with_sums(&mut *sums),
            |mut task| {
                let (block, outs) = (
                    batch.block(grid),
                    rows::part_mut(&mut task.fields, 0..batch.count),
                );
                let of = |axis: usize, row: usize| block.of(v[axis], row);
                divergence_in_row((grid, solids), task.row, of, outs, &mut []).write(task.sums);
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

    /// v -= grad q, 0 at closed faces, and, unless p is empty, p -= q; `fields` are the components of v and p. Returns max |div v| and max |v| after.
    /// `sums` holds two values a row.
    pub fn subtract_gradient(
        &mut self,
        exec: &dyn Exec,
        batch: Batch,
        fields: &mut [&mut [T]; 4],
        sums: &mut [f64],
    ) -> Measured {
        let (grid, solids, q) = (self.grid, self.solids, &*self.q);
        let (block, nx) = (batch.block(grid), grid.n[0]);
        let sums = rows::part_mut(sums, 0..Measured::SUMS * grid.rows());
        let lag = Lag::new(exec, grid, block.len());
        let len = batch.slots * nx;
        let buffers = RowBuffers::fields(fields.each_mut().map(|field| &mut **field))
            .with_sums(&mut *sums)
            .with_scratch(&mut *self.scratch);
        for_slabs(exec, lag.slabs, buffers, |task| {
            let (all, mut fields) = (task.rows, task.fields);
            let here = |row: usize| {
                let start = (row - all.start) * len + batch.first * nx;
                start..start + block.len()
            };
            for (index, row) in all.clone().enumerate() {
                let mut slots = fields
                    .each_mut()
                    .map(|field| rows::part_mut(field, here(row)).chunks_exact_mut(nx.max(1)));
                for q in q.chunks_exact(grid.cells().max(1)).take(batch.count) {
                    let fields = slots.each_mut().map(|slots| slots.next().unwrap_or(&mut []));
                    subtract_gradient_in_row(grid, row, q, fields);
                }
                if solids.there() {
                    for (axis, faces) in fields.iter_mut().enumerate().take(grid.dims) {
                        solids.clear(nx, row, closed(axis), rows::part_mut(faces, here(row)));
                    }
                }
                let Some(row) = index.checked_sub(lag.rows).map(|index| all.start + index) else {
                    continue;
                };
                if lag.is_within(grid, row, &all) {
                    let of = |axis: usize, row: usize| rows::part(&*fields[axis], here(row));
                    let sums = rows::part_mut(task.sums, Measured::of_row(row - all.start));
                    divergence_in_row((grid, solids), row, of, &mut [], task.scratch).write(sums);
                }
            }
        });
        let v = velocity(fields);
        let buffers = RowBuffers::sums(&mut *sums).with_scratch(&mut *self.scratch);
        for_rows(exec, grid.rows(), buffers, |task| {
            if !lag.is_within(grid, task.row, &lag.slabs.rows_of(lag.slabs.slab_of(task.row))) {
                let of = |axis: usize, row: usize| block.of(v[axis], row);
                divergence_in_row((grid, solids), task.row, of, &mut [], task.scratch).write(task.sums);
            }
        });
        Measured::read(exec, grid, sums)
    }
}

/// Which rows are measured so many rows after they were written, while they and those above them are in the cache; the others are at the end of a slab, or
/// have a row above them that a ring brings round.
#[derive(Clone, Copy, Debug)]
struct Lag {
    /// Those of one task each.
    slabs: Slabs,
    /// From a row to the farthest one above it.
    rows: usize,
}

impl Lag {
    fn new(exec: &dyn Exec, grid: &Grid, row_len: usize) -> Self {
        let rows = if grid.dims > 2 { grid.n[1] } else { 1 };
        Self {
            slabs: Slabs::among(exec, grid.rows(), row_len, 4 * rows),
            rows,
        }
    }

    /// Whether `row`, of the slab `of`, is one of those.
    fn is_within(self, grid: &Grid, row: usize, of: &Range<usize>) -> bool {
        let written = of.start..row + self.rows + 1;
        let above = |axis: usize| grid.neighbour(row, axis, Side::High);
        written.end <= of.end
            && (1..grid.dims).all(|axis| above(axis).is_none_or(|above| written.contains(&above)))
    }
}
