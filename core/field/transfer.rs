//! Moving fields between two grids of a hierarchy, row by row.

use super::{Block, rows};
use crate::grid::Grid;
use crate::grid::tables::Tables;
use crate::grid::taps::{TAPS, Transfer};
use crate::real::Real;

/// Where the values of a field stand.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// At cell centres.
    Cell,
    /// At the faces normal to an axis.
    Face(usize),
}

/// A scalar field, or one component of a vector field, and where its values stand.
#[derive(Clone, Copy, Debug)]
pub struct Placed<'a, T> {
    /// Where.
    pub place: Place,
    /// The field.
    pub values: &'a [T],
}

/// The transfer along an axis: `face` for faces along their own axis, else `cell`.
#[must_use]
pub fn along(place: Place, axis: usize, cell: Transfer, face: Transfer) -> Transfer {
    if place == Place::Face(axis) { face } else { cell }
}

/// What [`Move::add_row`] moves: a field of `source` to rows of `target`.
#[derive(Clone, Copy)]
pub struct Move<'a, T> {
    /// The weights between the two grids.
    pub tables: &'a Tables<'a, T>,
    /// The grid that is read.
    pub source: &'a Grid,
    /// The grid that is written.
    pub target: &'a Grid,
    /// Transfer of cell values.
    pub cell: Transfer,
    /// Transfer of faces along their own axis.
    pub face: Transfer,
}

impl<T: Real> Move<'_, T> {
    /// `out += s` times what `field` is in `row` of the target, in the slots of a block: `block` is one of the target or of the source,
    /// `out` the block's part of the row, and `sum` is scratch for a row of the source's block.
    pub fn add_row(
        &self,
        field: Placed<'_, T>,
        block: &Block<'_>,
        row: usize,
        s: T,
        out: &mut [T],
        sum: &mut [T],
    ) {
        let Placed { place, values } = field;
        let block = Block {
            grid: self.source,
            ..*block
        };
        let sum = &mut sum[..block.len()];
        let mut sources: heapless::Vec<(&[T], T), { TAPS * TAPS }> = heapless::Vec::new();
        self.each_source_row(place, row, |from, weight| {
            let pushed = sources.push((block.of(values, from), s * weight));
            debug_assert!(pushed.is_ok());
        });
        let rest = match &sources[..] {
            [(x0, s0), (x1, s1), (x2, s2), (x3, s3), rest @ ..] => {
                rows::sum_of_four(sum, [*s0, *s1, *s2, *s3], x0, x1, x2, x3);
                rest
            }
            few => {
                sum.fill(T::ZERO);
                few
            }
        };
        rest.iter().for_each(|&(x, s)| rows::add_scaled(sum, s, x));
        let along_x = along(place, 0, self.cell, self.face);
        self.tables
            .add_along_x(along_x, sum, self.source.n[0], out, self.target.n[0]);
    }

    /// Calls `visit` with every source row of `row` of the target and its weight.
    pub fn each_source_row(&self, place: Place, row: usize, mut visit: impl FnMut(usize, T)) {
        let [y, z] = self.target.row_at(row);
        let in_y = along(place, 1, self.cell, self.face);
        if self.source.dims == 2 {
            self.tables
                .taps(1, in_y, y)
                .for_each(|(y, weight)| visit(self.source.row(y, 0), weight));
            return;
        }
        for (from_z, weight_z) in self.tables.taps(2, along(place, 2, self.cell, self.face), z) {
            for (from_y, weight_y) in self.tables.taps(1, in_y, y) {
                visit(self.source.row(from_y, from_z), weight_y * weight_z);
            }
        }
    }
}
