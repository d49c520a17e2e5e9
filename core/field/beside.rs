//! Rows of values beside a row of a block: the kernels by which operators of two points read across faces.

use super::{Block, rows};
use crate::grid::Side;
use crate::grid::geometry::Beyond;
use crate::real::Real;

impl Block<'_> {
    /// The values on one side of every value of `row` along `axis`. Along x they are copied to `scratch`, as long as a row of
    /// the block. `None` where a wall lies between `row` and all of them: then `beyond` stands for each.
    #[inline]
    pub fn beside<'a, T: Real>(
        &self,
        (axis, side): (usize, Side),
        beyond: Beyond,
        field: &'a [T],
        row: usize,
        scratch: &'a mut [T],
    ) -> Option<&'a [T]> {
        if axis > 0 {
            return self
                .grid
                .neighbour(row, axis, side)
                .map(|beside| self.of(field, beside));
        }
        self.shift(side, beyond, self.of(field, row), scratch);
        Some(scratch)
    }

    /// `out[x]` = the value on one side of `row[x]` along x in every slot of a row of the block; behind a wall what `beyond` says.
    pub fn shift<T: Real>(&self, side: Side, beyond: Beyond, row: &[T], out: &mut [T]) {
        let len = row.len();
        let nx = self.grid.n[0];
        let (end, outside) = match side {
            Side::Low => {
                out[1..len].copy_from_slice(&row[..len - 1]);
                (0, -1)
            }
            Side::High => {
                out[..len - 1].copy_from_slice(&row[1..]);
                (nx - 1, nx as isize)
            }
        };
        let source = match beyond {
            Beyond::Own => self.grid.axis(0).cell(outside).or(Some(end)),
            Beyond::Zero => self.grid.axis(0).cell(outside),
        };
        for start in (0..len).step_by(nx) {
            out[start + end] = source.map_or(T::ZERO, |source| row[start + source]);
        }
    }

    /// Sets to 0 what `values`, at the low faces of a row of the block along `axis`, holds on walls.
    pub fn clear_closed<T: Real>(&self, axis: usize, row: usize, values: &mut [T]) {
        if axis > 0 {
            if self.grid.wall_below(row, axis) {
                values.fill(T::ZERO);
            }
        } else if self.grid.axis(0).open_face(0).is_none() {
            rows::clear_first(values, self.grid.n[0]);
        }
    }
}
