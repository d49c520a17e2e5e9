//! The rows that a flux through faces reads around a row of cells along y and z.

use super::{Grid, Side};

/// A row and those at distance 1 and 2 from it.
#[derive(Clone, Copy, Debug)]
pub struct Stencil {
    /// The row.
    pub row: usize,
    /// How many rows from this one on have their stencils at the same distances.
    pub alike: usize,
    /// Along y and z the rows of cells at offsets -2, -1, 1, 2; behind a wall stands the last row before it.
    pub cells: [[usize; 4]; 2],
    /// Along y and z the rows of low faces at offsets -1, 0, 1, 2; behind a wall stand those on the low wall, where v is 0.
    pub faces: [[usize; 4]; 2],
    /// Along y and z, whether there is a wall on the low and on the high side.
    walls: [[bool; 2]; 2],
}

impl Stencil {
    /// The stencil of `row`.
    #[inline(always)]
    #[must_use]
    pub fn new(grid: &Grid, row: usize) -> Self {
        let at = grid.row_at(row);
        let inside = |axis: usize| axis >= grid.dims || (2..grid.n[axis] - 2).contains(&at[axis - 1]);
        if !(inside(1) && inside(2)) {
            return Self::near_end(grid, row, at);
        }
        let strides = if grid.dims > 2 { [1, grid.n[1]] } else { [1, 0] };
        Self {
            row,
            alike: grid.n[1] - 2 - at[0],
            cells: strides.map(|stride| [row - 2 * stride, row - stride, row + stride, row + 2 * stride]),
            faces: strides.map(|stride| [row - stride, row, row + stride, row + 2 * stride]),
            walls: [[false; 2]; 2],
        }
    }

    /// The stencil of `row` at (y, z), which may reach beyond an end of the box.
    #[cold]
    fn near_end(grid: &Grid, row: usize, at: [usize; 2]) -> Self {
        let mut stencil = Self {
            row,
            alike: 1,
            cells: [[row; 4]; 2],
            faces: [[row; 4]; 2],
            walls: [[true; 2]; 2],
        };
        for axis in 1..grid.dims {
            let here = at[axis - 1];
            let stride = if axis == 1 { 1 } else { grid.n[1] };
            let row_of = |i: usize| row - here * stride + i * stride;
            let line = grid.axis(axis);
            let beside = |offset: isize| line.cell(here as isize + offset);
            let nearest = |offset: isize| row_of(line.nearest(here as isize + offset));
            let face = |offset: isize| row_of(beside(offset).unwrap_or(0));
            stencil.cells[axis - 1] = [-2, -1, 1, 2].map(nearest);
            stencil.faces[axis - 1] = [-1, 0, 1, 2].map(face);
            stencil.walls[axis - 1] = [-1, 1].map(|offset| beside(offset).is_none());
        }
        stencil
    }

    /// Whether there is a wall on a side along y or z.
    #[inline]
    #[must_use]
    pub fn at_wall(&self, axis: usize, side: Side) -> bool {
        self.walls[axis - 1][usize::from(side == Side::High)]
    }
}
