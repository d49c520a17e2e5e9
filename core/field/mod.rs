//! Views of fields: vector fields by component, blocks of a trajectory, and elementwise loops over rows.

pub mod beside;
pub mod borders;
mod fast_axis;
mod folds;
mod fourier;
pub mod lines;
pub mod means;
pub mod rows;
pub mod slot;
pub mod sums;
pub mod trajectory;
pub mod transfer;
pub mod transform;
pub mod turned;

use crate::grid::Grid;
use crate::real::Real;
use core::ops::Range;

/// The components of a vector field; the third is empty in 2D.
pub type Vector<'a, T> = [&'a [T]; 3];
/// A vector field to write.
pub type VectorMut<'a, T> = [&'a mut [T]; 3];

/// A vector field to read.
pub fn view<'a, T>(v: &'a VectorMut<'_, T>) -> Vector<'a, T> {
    [&*v[0], &*v[1], &*v[2]]
}

/// A shorter borrow of a vector field to write.
pub fn reborrow<'a, T>(v: &'a mut VectorMut<'_, T>) -> VectorMut<'a, T> {
    v.each_mut().map(|component| &mut **component)
}

/// Some slots of every row of a trajectory. A task works on one block of a row at a time, which fits the nearest cache.
#[derive(Clone, Copy, Debug)]
pub struct Block<'g> {
    /// The grid.
    pub grid: &'g Grid,
    /// Slots of the trajectory.
    pub slots: usize,
    /// First slot of the block.
    pub first: usize,
    /// Slots of the block.
    pub count: usize,
}

/// The values of a block that suit the nearest cache.
const BLOCK_TARGET: usize = 512;

impl<'g> Block<'g> {
    /// The slots of a block on a grid with `nx` cells a row: at most a quarter of all, so that scratch stays small beside a field.
    #[must_use]
    pub fn slots_per_block(nx: usize, slots: usize) -> usize {
        (BLOCK_TARGET / nx).clamp(1, slots.div_ceil(4).max(1))
    }

    /// The length of a row of the largest block.
    #[must_use]
    pub fn largest(nx: usize, slots: usize) -> usize {
        Self::slots_per_block(nx, slots) * nx
    }

    /// The blocks that cover all slots.
    pub fn all(grid: &'g Grid, slots: usize) -> impl Iterator<Item = Self> {
        let step = Self::slots_per_block(grid.n[0], slots);
        (0..slots).step_by(step).map(move |first| Self {
            grid,
            slots,
            first,
            count: step.min(slots - first),
        })
    }

    /// The length of a row of the block.
    #[must_use]
    pub fn len(&self) -> usize {
        self.count * self.grid.n[0]
    }

    /// Whether the block has no slot.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// Where the block lies in `row` of the field.
    #[must_use]
    pub fn span(&self, row: usize) -> Range<usize> {
        let start = (row * self.slots + self.first) * self.grid.n[0];
        start..start + self.len()
    }

    /// Where the block lies in the chunk of a single row.
    #[must_use]
    pub fn span_in_row(&self) -> Range<usize> {
        let start = self.first * self.grid.n[0];
        start..start + self.len()
    }

    /// The block's part of `row`.
    #[must_use]
    pub fn of<'a, T>(&self, field: &'a [T], row: usize) -> &'a [T] {
        &field[self.span(row)]
    }
}

/// `out -= v` one slot earlier; before the first stands the given `v0`, 0 where that is empty.
pub fn subtract_previous<T: Real>(block: &Block<'_>, row: usize, v: &[T], v0: &[T], out: &mut [T]) {
    let nx = block.grid.n[0];
    let span = block.span(row);
    if block.first == 0 {
        if !v0.is_empty() {
            rows::sub(&mut out[..nx], &v0[row * nx..(row + 1) * nx]);
        }
        rows::sub(&mut out[nx..], &v[span.start..span.end - nx]);
    } else {
        rows::sub(out, &v[span.start - nx..span.end - nx]);
    }
}

/// `out -= w` one slot later; after the last stands 0.
pub fn subtract_next<T: Real>(block: &Block<'_>, row: usize, w: &[T], out: &mut [T]) {
    let nx = block.grid.n[0];
    let span = block.span(row);
    let last = block.first + block.count == block.slots;
    let end = if last { span.end } else { span.end + nx };
    let len = end - span.start - nx;
    rows::sub(&mut out[..len], &w[span.start + nx..end]);
}
