//! Batches of slots that are projected together, and what is done to each row of them.

use crate::exec::Exec;
use crate::field::{Block, Vector, rows, sums};
use crate::grid::solids::{OUTSIDE, Solids};
use crate::grid::{Grid, Side};
use crate::operators::divergence::{RowCells, RowFaces, add_gradients, divergence};
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

    /// All of its slots.
    pub fn block(self, grid: &Grid) -> Block<'_> {
        Block {
            grid,
            slots: self.slots,
            first: self.first,
            count: self.count,
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

    /// Where those of a row are.
    pub fn of_row(row: usize) -> Range<usize> {
        row * Self::SUMS..(row + 1) * Self::SUMS
    }

    /// The largest of both.
    fn add(&mut self, [divergence, speed]: [f64; 2]) {
        self.divergence = rows::largest([self.divergence, divergence]);
        self.speed = rows::largest([self.speed, speed]);
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

/// div v at a row in some slots, to `outs`, one slice a slot, unless there is none; max |div v| and max |v|. `of` gives the faces of an axis and a row in
/// these slots; `scratch` holds a row of one slot.
pub fn divergence_in_row<'v, T: Real>(
    (grid, solids): (&Grid, Solids<'_>),
    row: usize,
    of: impl Fn(usize, usize) -> &'v [T],
    outs: &mut [&mut [T]],
    scratch: &mut [T],
) -> Measured {
    let scales = grid.h.map(|h| T::from_f64(1.0 / h));
    let above = |axis: usize| match grid.neighbour(row, axis, Side::High) {
        Some(above) => of(axis, above),
        None => &[],
    };
    let deep = grid.dims > 2;
    let faces = RowFaces {
        nx: grid.n[0],
        low: [of(0, row), of(1, row), if deep { of(2, row) } else { &[] }],
        end: grid.axis(0).cell(grid.n[0] as isize),
        high: [above(1), if deep { above(2) } else { &[] }],
    };
    let mut measured = Measured::default();
    if !grid.is_open() {
        measured.add(divergence(&faces, scales, outs));
        return measured;
    }
    let scratch = rows::part_mut(scratch, 0..grid.n[0]);
    for slot in 0..faces.slots() {
        let out = match outs.get_mut(slot) {
            Some(out) => &mut **out,
            None => &mut *scratch,
        };
        let found = divergence(&faces.slot(slot), scales, &mut [&mut *out]);
        measured.add(inside((grid, solids), row, found, out));
    }
    measured
}

/// Sets the divergence of a row to 0 outside the box, where the flow that passes exits ends; max |div v| and max |v| of the rest, of which
/// `found` are those of all.
fn inside<T: Real>(
    (grid, solids): (&Grid, Solids<'_>),
    row: usize,
    found: [f64; 2],
    divergence: &mut [T],
) -> [f64; 2] {
    solids.clear(grid.n[0], row, OUTSIDE, divergence);
    // Where the flow is not finite both say so.
    let largest = if found[1].is_finite() {
        rows::max_abs(divergence)
    } else {
        found[0]
    };
    [largest, found[1]]
}

/// v -= grad q and, unless p is empty, p -= q in a row of one slot, of which `fields` are the components of v and p; q is a field of cells.
pub fn subtract_gradient_in_row<T: Real>(grid: &Grid, row: usize, q: &[T], fields: [&mut [T]; 4]) {
    let nx = grid.n[0];
    let of = |row: usize| rows::part(q, row * nx..(row + 1) * nx);
    let low = |axis: usize| match grid.neighbour(row, axis, Side::Low) {
        Some(low) => of(low),
        None => &[],
    };
    let own = of(row);
    let cells = RowCells {
        own,
        before: own
            .get(grid.axis(0).cell(-1).unwrap_or(0))
            .copied()
            .unwrap_or(T::ZERO),
        low: [low(1), if grid.dims > 2 { low(2) } else { &[] }],
    };
    let [x, y, z, p] = fields;
    let scales = grid.h.map(|h| -T::ONE * T::from_f64(1.0 / h));
    add_gradients(&cells, scales, [x, y, z]);
    if !p.is_empty() {
        rows::sub(p, own);
    }
}

/// The components of v before those of p.
pub fn velocity<'v, T>(fields: &'v [&mut [T]; 4]) -> Vector<'v, T> {
    [&*fields[0], &*fields[1], &*fields[2]]
}
