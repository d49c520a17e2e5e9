//! Rows with a halo: two values before and two behind the values along x, so that a flux reads across the ends of a row as it
//! does inside.
//!
//! ```text
//! cells   x-2 x-1 | x0 x1 .. xn-1 | xn xn+1        faces   - f-1 | f0 f1 .. fn-1 | fn fn+1
//! ```

use super::{Axis, Grid};
use crate::real::Real;

/// Values around a row.
pub const HALO: usize = 4;
/// Values before a row.
pub const BEFORE: usize = HALO / 2;
/// The distance between rows is a multiple of this many values, so that all begin at the same place of a vector.
const ALIGNED: usize = 16;
/// Where a field begins in its buffer, so that the first cell of a row begins a vector.
pub const OFFSET: usize = ALIGNED - BEFORE;

/// The distance between the beginnings of rows of `n` values.
#[inline(always)]
#[must_use]
pub const fn stride(n: usize) -> usize {
    (n + HALO).next_multiple_of(ALIGNED)
}

/// The length of a field of cells whose rows have halos.
#[must_use]
pub fn field_len(grid: &Grid) -> usize {
    grid.rows() * stride(grid.n[0])
}

/// The `n` values of a row without their halo.
#[inline(always)]
pub fn inner<T>(row: &mut [T], n: usize) -> &mut [T] {
    &mut row[BEFORE..][..n]
}

impl Axis {
    /// Writes the halo of a row of cells along this axis: behind a wall stands the last cell before it.
    #[inline(always)]
    pub fn surround_cells<T: Real>(self, row: &mut [T]) {
        let n = self.cells();
        if let Some([far_below, below, inner @ .., above, far_above]) = row.get_mut(..n + HALO) {
            let cell = |around: usize, at_wall: usize| {
                inner
                    .get(if self.is_ring() { around } else { at_wall })
                    .copied()
                    .unwrap_or(T::ZERO)
            };
            (*far_below, *below) = (cell(n - 2, 0), cell(n - 1, 0));
            (*above, *far_above) = (cell(0, n - 1), cell(1, n - 1));
        }
    }

    /// Writes the halo of a row of low faces along this axis: 0 on the high wall and behind walls.
    #[inline(always)]
    pub fn surround_faces<T: Real>(self, row: &mut [T]) {
        let n = self.cells();
        let wrap = |x: T| if self.is_ring() { x } else { T::ZERO };
        (row[1], row[n + 2], row[n + 3]) = (wrap(row[n + 1]), wrap(row[2]), wrap(row[3]));
    }
}
