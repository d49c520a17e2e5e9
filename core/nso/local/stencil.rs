//! Which values around a cell its equations read, and in which rows they are.

use super::edge::Edge;
use super::streams::Rows;
use crate::field::Vector as Field;
use crate::grid::{Grid, Space};
use crate::nso::colours::Cells;
use crate::real::Real;

/// Which values of a field the equations of a cell read, and which of the gathered vectors they become: for
/// each of the rows around the cell (see [`Around`]) the value at the cell, the one after it and the one
/// before it. Where one is read, so are those named before it.
pub(super) struct Reads([[Option<usize>; 3]; 9]);

impl Reads {
    const NOTHING: Self = Self([[None; 3]; 9]);

    /// The value at the cell.
    pub(super) fn cell() -> Self {
        let mut reads = Self::NOTHING;
        reads.add([0; 3], 0);
        reads
    }

    /// The value at the cell, then those beyond its faces.
    pub(super) fn cell_and_beside<S: Space>() -> Self {
        let mut reads = Self::cell();
        for f in 0..S::FACES {
            let mut beside = [0; 3];
            beside[f / 2] = [-1, 1][f % 2];
            reads.add(beside, 1 + f);
        }
        reads
    }

    /// The faces of the cell along `axis`.
    pub(super) fn own_faces(axis: usize) -> Self {
        let mut reads = Self::NOTHING;
        for side in 0..2 {
            let mut offset = [0; 3];
            offset[axis] = side;
            reads.add(offset, 2 * axis + side as usize);
        }
        reads
    }

    /// And the faces outside of the cell that meet them at edges.
    pub(super) fn with_outside_faces<S: Space>(mut self, axis: usize) -> Self {
        for e in 0..S::EDGES {
            let edge = Edge::new::<S>(e);
            if edge.a == axis {
                self.add(edge.outside_a(), S::FACES + 2 * e);
            }
            if edge.b == axis {
                self.add(edge.outside_b(), S::FACES + 2 * e + 1);
            }
        }
        self
    }

    fn add(&mut self, offset: [isize; 3], place: usize) {
        self.0[(offset[1] + 1 + 3 * (offset[2] + 1)) as usize][(offset[0].rem_euclid(3)) as usize] =
            Some(place);
    }
}

/// Some cells of a row, and the rows around it by their places in a field, `None` behind a wall.
pub(super) struct Around<'g> {
    grid: &'g Grid,
    cells: Cells,
    rows: [Option<usize>; 9],
}

impl<'g> Around<'g> {
    /// For fields that begin with row `first`.
    pub(super) fn new(grid: &'g Grid, first: usize, row: usize, cells: Cells) -> Self {
        let rows = grid.rows_around(row).map(|row| row?.checked_sub(first));
        Self { grid, cells, rows }
    }

    /// Adds what is read of a field of `slots` slots, `time` slots after the one that is gathered, into the
    /// vectors from `first` on.
    pub(super) fn read<
        's,
        T: Real,
        const ONE: usize,
        const TWO: usize,
        const THREE: usize,
        const WRAPPED: usize,
    >(
        &self,
        rows: &mut Rows<'s, T, ONE, TWO, THREE, WRAPPED>,
        field: &'s [T],
        slots: usize,
        time: usize,
        reads: &Reads,
        first: usize,
    ) {
        if field.is_empty() {
            return;
        }
        let nx = self.grid.n[0];
        let Cells { start: x, count } = self.cells;
        for (&row, &places) in self.rows.iter().zip(&reads.0) {
            debug_assert!(places.is_sorted_by_key(|place| place.is_none()));
            let (Some(row), [Some(own), after, before]) =
                (row, places.map(|place| place.map(|place| first + place)))
            else {
                continue;
            };
            let begin = (row * slots + time) * nx;
            rows.push(field, begin + x, own, [after, before]);
            let along_x = self.grid.axis(0);
            if let (Some(place), Some(cell)) = (before.filter(|_| x == 0), along_x.cell(-1)) {
                rows.push_wrapped(field, begin + cell, place, 0);
            }
            let last = count - 1;
            let at_end = x + 2 * last + 1 == nx;
            if let (Some(place), Some(cell)) = (after.filter(|_| at_end), along_x.cell(nx as isize)) {
                rows.push_wrapped(field, begin + cell, place, last);
            }
        }
    }

    /// Adds the cells' own faces, axis after axis.
    pub(super) fn own_faces<
        's,
        T: Real,
        const ONE: usize,
        const TWO: usize,
        const THREE: usize,
        const WRAPPED: usize,
    >(
        &self,
        rows: &mut Rows<'s, T, ONE, TWO, THREE, WRAPPED>,
        field: Field<'s, T>,
        slots: usize,
        time: usize,
        first: usize,
    ) {
        for (axis, component) in field.into_iter().enumerate().take(self.grid.dims) {
            self.read(rows, component, slots, time, &Reads::own_faces(axis), first);
        }
    }
}
