//! Batches of slots that are projected together, and what is done to each row of them.

use crate::exec::Exec;
use crate::field::{Block, Vector, rows, sums};
use crate::grid::solids::{OUTSIDE, Solids};
use crate::grid::{Grid, Side};
use crate::operators::divergence::{RowFaces, add_gradient};
use crate::real::Real;
use core::ops::Range;

/// The most slots that are projected together.
pub const MAX_BATCH: usize = 16;

/// Some slots of a trajectory whose potentials are stored together.
#[derive(Clone, Copy, Debug)]
pub struct Batch {
    /// Slots of the trajectory.
    pub slots: usize,
    /// The first slot of the batch.
    pub first: usize,
    /// Slots of the batch.
    pub count: usize,
}

impl Batch {
    /// Batches of up to `count` slots that cover all.
    pub fn all(slots: usize, count: usize) -> impl Iterator<Item = Self> {
        (0..slots).step_by(count).map(move |first| Self {
            slots,
            first,
            count: count.min(slots - first),
        })
    }

    /// One slot of the batch.
    pub fn slot(self, grid: &Grid, index: usize) -> Block<'_> {
        Block {
            grid,
            slots: self.slots,
            first: self.first + index,
            count: 1,
        }
    }

    /// The blocks of the trajectory that cover the batch.
    pub fn blocks(self, grid: &Grid) -> impl Iterator<Item = Block<'_>> {
        Block::all(grid, self.count).map(move |block| Block {
            slots: self.slots,
            first: self.first + block.first,
            ..block
        })
    }

    /// The same block in the batch.
    pub fn compact<'g>(self, block: &Block<'g>) -> Block<'g> {
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
    /// max |div v|.
    pub divergence: f64,
    /// max |v|.
    pub speed: f64,
}

impl Measured {
    /// The sums of a row.
    pub const SUMS: usize = 2;

    /// The largest of both.
    fn add(&mut self, other: Self) {
        self.divergence = rows::largest([self.divergence, other.divergence]);
        self.speed = rows::largest([self.speed, other.speed]);
    }

    /// Writes the sums of a row.
    pub fn write(self, sums: &mut [f64]) {
        sums.iter_mut()
            .zip([self.divergence, self.speed])
            .for_each(|(sum, own)| *sum = own);
    }

    /// The largest of the sums of all rows of `grid`.
    pub fn read(exec: &dyn Exec, grid: &Grid, sums: &[f64]) -> Self {
        let largest = |which: usize| {
            let of_rows = sums.iter().skip(which).step_by(Self::SUMS).copied();
            sums::most(exec, grid, of_rows)
        };
        Self {
            divergence: largest(0),
            speed: largest(1),
        }
    }
}

/// Calls `divergence` with the faces around a row in every slot of the batch and 1 / h. It returns max |div v| and max |v|, of which this is
/// the largest.
pub fn divergence_in_row<T: Real>(
    grid: &Grid,
    batch: Batch,
    row: usize,
    v: Vector<'_, T>,
    mut divergence: impl FnMut(&RowFaces<'_, T>, [T; 3]) -> [f64; 2],
) -> Measured {
    let scales = grid.h.map(|h| T::from_f64(1.0 / h));
    let above = |axis: usize| grid.neighbour(row, axis, Side::High);
    let next = [above(1), if grid.dims > 2 { above(2) } else { None }];
    let end = grid.axis(0).cell(grid.n[0] as isize);
    let mut measured = Measured::default();
    for index in 0..batch.count {
        let slot = batch.slot(grid, index);
        let of = |axis: usize, row: Option<usize>| row.map_or(&[][..], |row| slot.of(v[axis], row));
        let x = slot.of(v[0], row);
        let low = [x, of(1, Some(row)), of(2, (grid.dims > 2).then_some(row))];
        let faces = RowFaces {
            low,
            end: end.map_or(T::ZERO, |first| x[first]),
            high: [of(1, next[0]), of(2, next[1])],
        };
        let [divergence, speed] = divergence(&faces, scales);
        measured.add(Measured { divergence, speed });
    }
    measured
}

/// Sets the divergence of a row to 0 outside the box, where the flow that passes exits ends; max |div v| and max |v| of the rest, of which
/// `found` are those of all.
pub fn inside<T: Real>(
    grid: &Grid,
    solids: Solids<'_>,
    row: usize,
    found: [f64; 2],
    divergence: &mut [T],
) -> [f64; 2] {
    if !grid.is_open() {
        return found;
    }
    solids.clear(grid.n[0], row, OUTSIDE, divergence);
    // Where the flow is not finite both say so.
    let largest = if found[1].is_finite() {
        rows::max_abs(divergence)
    } else {
        found[0]
    };
    [largest, found[1]]
}

/// v -= grad q and, unless p is empty, p -= q in a row. `fields` are that row of the components of v and of p, `span` the slots in them,
/// and `block` is how q is stored.
pub fn subtract_gradient_in_row<T: Real>(
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
