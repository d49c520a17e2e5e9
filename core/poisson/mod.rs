//! The projection Q onto div v = 0 (mathematics section 1): v - grad q with div grad q = div v, for many slots at once.
//!
//! The Poisson problem is solved by eigenvectors where no axis is too long for that, else by multigrid.

pub mod multigrid;
pub mod spectral;

use crate::exec::{Exec, RowBuffers, for_rows};
use crate::field::{Block, Vector, VectorMut, rows, sums, transform, view};
use crate::grid::levels::Levels;
use crate::grid::spectrum::Spectrum;
use crate::grid::{Grid, Side};
use crate::memory::{Ledger, Pool, Sharing, pooled};
use crate::observe::{Observer, Silent};
use crate::operators::divergence::{RowFaces, add_gradient, divergence};
use crate::real::Real;
use core::ops::{ControlFlow, Range};
use multigrid::Multigrid;
use spectral::Spectral;

/// Slots that are projected together at most.
const MAX_BATCH: usize = 16;
/// Defect corrections at most: each starts from the divergence of the result, so single precision reaches its own floor.
const PASSES: usize = 4;

/// The projection's workspace.
#[derive(Debug)]
pub struct Projection<'a, T> {
    grid: &'a Grid,
    batch: usize,
    solver: Solver<'a, T>,
}

/// What solves Poisson's problem.
#[derive(Debug)]
#[expect(
    clippy::large_enum_variant,
    reason = "there is no allocator, and one of it lives at a time"
)]
enum Solver<'a, T> {
    Spectral(Spectral<'a, T>),
    Multigrid(Multigrid<'a, T>),
}

/// Calls the same method of whichever it is.
macro_rules! each {
    ($solver:expr, $inner:ident => $call:expr) => {
        match $solver {
            Solver::Spectral($inner) => $call,
            Solver::Multigrid($inner) => $call,
        }
    };
}

/// As many slots in every batch, and no more than there are rows.
fn batch_of(grid: &Grid, slots: usize) -> usize {
    slots.div_ceil(slots.div_ceil(MAX_BATCH.min(grid.rows())))
}

fn scratch_len<T: Real>(finest: &Grid, batch: usize, threads: usize) -> usize {
    let a_thread = if Spectrum::<T>::exists(finest) {
        transform::scratch_len(finest)
    } else {
        multigrid::scratch_per_thread(finest, batch)
    };
    pooled(threads * a_thread)
}

impl<'a, T: Real> Projection<'a, T> {
    /// Writes the ledger lines of [`Self::carve`].
    pub fn requirement(ledger: &mut Ledger, finest: &Grid, slots: usize, threads: usize) {
        let batch = batch_of(finest, slots);
        ledger.group("projection", Sharing::Together, |ledger| {
            if Spectrum::<T>::exists(finest) {
                ledger.line(
                    "potentials of a batch of slots",
                    pooled(finest.cells() * batch),
                    T::BYTES,
                );
            } else {
                ledger.line(
                    "potentials of a batch of slots, all levels",
                    multigrid::numbers(finest, batch),
                    T::BYTES,
                );
            }
            ledger.line(
                "rows and panels",
                scratch_len::<T>(finest, batch, threads),
                T::BYTES,
            );
        });
    }

    /// Takes its numbers from the shared pool. The grid is number `level` of the hierarchy.
    pub fn carve(
        hierarchy: &'a Levels<'_, T>,
        level: usize,
        slots: usize,
        threads: usize,
        pool: &mut Pool<'a, T>,
    ) -> Self {
        let grid = &hierarchy.grids[level];
        let batch = batch_of(grid, slots);
        let scratch = scratch_len::<T>(grid, batch, threads);
        let solver = match hierarchy.spectrum(level) {
            Some(spectrum) => Solver::Spectral(Spectral::carve(grid, spectrum, batch, scratch, pool)),
            None => Solver::Multigrid(Multigrid::carve(hierarchy, level, batch, scratch, pool)),
        };
        Self { grid, batch, solver }
    }

    /// max |div v| h_x / max |v|, the largest of all batches of slots of the trajectory `v`, and max |v|; not finite where `v` is not.
    /// `sums` holds two numbers a row.
    pub fn relative_divergence(
        &mut self,
        exec: &dyn Exec,
        slots: usize,
        v: &VectorMut<'_, T>,
        sums: &mut [f64],
    ) -> [f64; 2] {
        let (grid, v) = (self.grid, view(v));
        let mut fastest: f64 = 0.0;
        let sums = &mut sums[..Measured::SUMS * grid.rows()];
        let relative = rows::largest(Batch::all(slots, self.batch).map(|batch| {
            let scratch = each!(&mut self.solver, solver => &mut *solver.scratch);
            for_rows(
                exec,
                grid.rows(),
                RowBuffers::sums(&mut *sums).with_scratch(scratch),
                |task| {
                    let out = task.scratch.get_mut(..grid.n[0]).unwrap_or_default();
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
    /// `sums` holds two numbers a row.
    pub fn project(
        &mut self,
        exec: &dyn Exec,
        observer: &mut dyn Observer,
        slots: usize,
        v: &mut VectorMut<'_, T>,
        mut potential: Option<&mut [T]>,
        tolerance: f64,
        sums: &mut [f64],
    ) -> ControlFlow<(), f64> {
        let mut worst: f64 = 0.0;
        for batch in Batch::all(slots, self.batch) {
            worst = rows::largest([
                worst,
                self.project_batch(
                    exec,
                    observer,
                    batch,
                    v,
                    potential.as_deref_mut(),
                    tolerance,
                    sums,
                )?,
            ]);
        }
        ControlFlow::Continue(worst)
    }

    fn project_batch(
        &mut self,
        exec: &dyn Exec,
        observer: &mut dyn Observer,
        batch: Batch,
        v: &mut VectorMut<'_, T>,
        mut potential: Option<&mut [T]>,
        tolerance: f64,
        sums: &mut [f64],
    ) -> ControlFlow<(), f64> {
        let mut goal = None;
        for pass in 0.. {
            let Measured { divergence, speed } =
                each!(&mut self.solver, solver => solver.divergence(exec, batch, v, sums));
            let goal = *goal.get_or_insert_with(|| {
                (tolerance * divergence).max(4.0 * T::EPSILON * speed / self.grid.h[0])
            });
            if pass == PASSES || !(divergence > goal) {
                return ControlFlow::Continue(divergence);
            }
            match &mut self.solver {
                Solver::Spectral(solver) => solver.solve(exec, observer, batch)?,
                Solver::Multigrid(solver) => solver.solve(exec, observer, batch, divergence, goal, sums)?,
            }
            each!(&mut self.solver, solver => solver.subtract_gradient(exec, batch, v, potential.as_deref_mut()));
        }
        ControlFlow::Continue(f64::NAN)
    }
}

/// Some slots of a trajectory, whose potentials are held together.
#[derive(Clone, Copy, Debug)]
pub struct Batch {
    slots: usize,
    first: usize,
    count: usize,
}

impl Batch {
    /// Batches of up to `count` slots that cover all.
    fn all(slots: usize, count: usize) -> impl Iterator<Item = Self> {
        (0..slots).step_by(count).map(move |first| Self {
            slots,
            first,
            count: count.min(slots - first),
        })
    }

    /// One slot of it.
    fn slot(self, grid: &Grid, index: usize) -> Block<'_> {
        Block {
            grid,
            slots: self.slots,
            first: self.first + index,
            count: 1,
        }
    }

    /// The blocks of the trajectory that cover the batch.
    fn blocks(self, grid: &Grid) -> impl Iterator<Item = Block<'_>> {
        Block::all(grid, self.count).map(move |block| Block {
            slots: self.slots,
            first: self.first + block.first,
            ..block
        })
    }

    /// The same block in the batch.
    fn compact<'g>(self, block: &Block<'g>) -> Block<'g> {
        Block {
            slots: self.count,
            first: block.first - self.first,
            ..*block
        }
    }
}

/// max |div v| and max |v| of some slots.
#[derive(Clone, Copy, Debug, Default)]
pub struct Measured {
    divergence: f64,
    speed: f64,
}

impl Measured {
    /// Sums of a row.
    const SUMS: usize = 2;

    /// Takes others in.
    fn add(&mut self, other: Self) {
        self.divergence = rows::largest([self.divergence, other.divergence]);
        self.speed = rows::largest([self.speed, other.speed]);
    }

    /// Into the sums of a row.
    fn write(self, sums: &mut [f64]) {
        sums.iter_mut()
            .zip([self.divergence, self.speed])
            .for_each(|(sum, own)| *sum = own);
    }

    /// The largest of all rows.
    fn read(sums: &[f64]) -> Self {
        let largest = |which: usize| rows::largest(sums.iter().skip(which).step_by(Self::SUMS).copied());
        Self {
            divergence: largest(0),
            speed: largest(1),
        }
    }
}

/// Hands a row's faces in every slot of the batch to `divergence`, with 1 / h, and collects what it measures.
fn divergence_in_row<T: Real>(
    grid: &Grid,
    batch: Batch,
    row: usize,
    v: Vector<'_, T>,
    mut divergence: impl FnMut(&RowFaces<'_, T>, [T; 3]) -> [f64; 2],
) -> Measured {
    let scales = grid.h.map(|h| T::from_f64(1.0 / h));
    let next = [1, 2].map(|axis| {
        if axis < grid.dims {
            grid.neighbour(row, axis, Side::High)
        } else {
            None
        }
    });
    let mut measured = Measured::default();
    for index in 0..batch.count {
        let slot = batch.slot(grid, index);
        let of = |axis: usize, row: Option<usize>| row.map_or(&[][..], |row| slot.of(v[axis], row));
        let x = slot.of(v[0], row);
        let low = [x, of(1, Some(row)), of(2, (grid.dims > 2).then_some(row))];
        let faces = RowFaces {
            low,
            end: grid
                .axis(0)
                .cell(grid.n[0] as isize)
                .map_or(T::ZERO, |first| x[first]),
            high: [of(1, next[0]), of(2, next[1])],
        };
        let [divergence, speed] = divergence(&faces, scales);
        measured.add(Measured { divergence, speed });
    }
    measured
}

/// v -= grad q and, where there is a p, p -= q at `span` of a row of `fields`, v by components and p. `block` is how q is stored.
fn subtract_gradient_in_row<T: Real>(
    block: &Block<'_>,
    row: usize,
    q: &[T],
    span: Range<usize>,
    fields: &mut [&mut [T]; 4],
    scratch: &mut [T],
) {
    let [v0, v1, v2, p] = fields;
    for (axis, v) in [v0, v1, v2].into_iter().enumerate().take(block.grid.dims) {
        add_gradient(
            block,
            row,
            axis,
            -T::ONE,
            q,
            &mut v[span.clone()],
            &mut scratch[..block.len()],
        );
    }
    if !p.is_empty() {
        rows::sub(&mut p[span], block.of(q, row));
    }
}

/// Projects the given velocity v_0, a field of one slot; the change relative to max |v_0|. `copy` is work of as many numbers.
pub fn project_given<T: Real>(
    exec: &dyn Exec,
    grid: &Grid,
    mut projection: Projection<'_, T>,
    given: &mut VectorMut<'_, T>,
    copy: &mut VectorMut<'_, T>,
    tolerance: f64,
    sums: &mut [f64],
) -> f64 {
    let speed = sums::max_abs(exec, grid, 1, view(given), sums);
    if speed == 0.0 {
        return 0.0;
    }
    for (copy, given) in copy.iter_mut().zip(&*given) {
        copy[..given.len()].copy_from_slice(given);
    }
    let _ = projection.project(exec, &mut Silent, 1, given, None, tolerance, sums);
    let (copy, given) = (view(copy), view(given));
    let change = sums::largest(exec, grid, sums, |row| {
        rows::largest((0..grid.dims).map(|a| {
            rows::max_gap(
                sums::row(grid, 1, copy[a], row),
                sums::row(grid, 1, given[a], row),
                T::ONE,
            )
        }))
    });
    change / speed
}
