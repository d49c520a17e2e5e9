//! What lies beyond a cell: walls, where nothing flows, rings, where an axis closes on itself, and open sides, with a layer of cells outside.
//!
//! This is the only file that knows how an axis ends. Everything else asks: for the cell, face or row at an index that may
//! be outside ([`Axis`]), for what is beside a row or a cell ([`Grid::neighbour`], [`Grid::beside`]), for the faces of a cell
//! that are closed ([`Grid::closed_faces`]). Whole rows of values are brought beside others by the kernels that build on
//! these answers: [`stencil`](super::stencil) and [`halo`](super::halo) for transport, [`taps`](super::taps) between
//! grids, and [`beside`](crate::field::beside) for all operators of two points.
//!
//! Three rules say what an operator finds behind a wall:
//!
//! | quantity | behind a wall | condition |
//! |---|---|---|
//! | velocity at faces | 0 on the wall | nothing flows through |
//! | potential, density read by two points | the cell itself ([`Beyond::Own`]) | no gradient across |
//! | density read further upstream | the last cell before the wall ([`Axis::nearest`]) | constant continuation |
//!
//! Behind the layer of cells outside an open side stands a wall. What is closed, open or dead there, the table of
//! [`solids`](super::solids) says, as among solid cells.

use super::{Boundary, Grid, Side};
use core::ops::Range;

/// One axis of a grid: its cells and how it ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Axis {
    cells: usize,
    ends: Boundary,
}

/// What stands for the value of the cell behind a wall, or of the face on it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Beyond {
    /// 0: a velocity.
    Zero,
    /// The value on this side: a potential, whose gradient on the wall is 0.
    Own,
}

impl Axis {
    /// An axis of `cells` cells.
    #[inline(always)]
    #[must_use]
    pub const fn new(cells: usize, ends: Boundary) -> Self {
        Self { cells, ends }
    }

    /// Its cells.
    #[inline(always)]
    #[must_use]
    pub const fn cells(self) -> usize {
        self.cells
    }

    /// How it ends.
    #[must_use]
    pub const fn ends(self) -> Boundary {
        self.ends
    }

    /// Its faces, the walls counted: face n of a ring is its face 0.
    #[inline(always)]
    #[must_use]
    pub const fn faces(self) -> usize {
        if self.is_ring() {
            self.cells
        } else {
            self.cells + 1
        }
    }

    /// The cells inside the box.
    #[inline(always)]
    #[must_use]
    pub const fn inside(self) -> Range<usize> {
        self.ends.opens(Side::Low) as usize..self.cells - self.ends.opens(Side::High) as usize
    }

    /// Whether the first cell and the last are neighbours.
    #[inline(always)]
    #[must_use]
    pub const fn is_ring(self) -> bool {
        matches!(self.ends, Boundary::Periodic)
    }

    /// The cell at index `i`, or `None` behind a wall.
    #[inline(always)]
    #[must_use]
    pub fn cell(self, i: isize) -> Option<usize> {
        match usize::try_from(i) {
            Ok(inside) if inside < self.cells => Some(inside),
            _ if self.is_ring() => Some(self.wrapped(i)),
            _ => None,
        }
    }

    /// The face at index `i`, or `None` on a wall and behind it: nothing flows there.
    #[inline(always)]
    #[must_use]
    pub fn open_face(self, i: isize) -> Option<usize> {
        self.cell(i).filter(|&face| face > 0 || self.is_ring())
    }

    /// The cell at index `i`; behind a wall the last one before it.
    #[inline(always)]
    #[must_use]
    pub fn nearest(self, i: isize) -> usize {
        self.cell(i).unwrap_or(if i < 0 { 0 } else { self.cells - 1 })
    }

    /// The cell at index `i`; behind a wall or an open side its mirror image, about that and as often as it takes (half-sample symmetry).
    #[inline(always)]
    #[must_use]
    pub fn mirrored(self, i: isize) -> usize {
        if self.is_ring() {
            return self.wrapped(i);
        }
        let Range { start, end } = self.inside();
        let n = (end - start) as isize;
        let i = (i - start as isize).rem_euclid(2 * n);
        start + (if i >= n { 2 * n - 1 - i } else { i }) as usize
    }

    /// The faces that stand for face `i`, counted from the first inside the box, each with its factor: behind a wall the mirror image, through
    /// which it flows the other way; behind an open side what lies as far from the face there, on the other side of it in value too. None on a
    /// wall, where nothing flows.
    #[must_use]
    pub fn continued_face(self, i: isize) -> heapless::Vec<(usize, f64), 2> {
        if self.is_ring() {
            return heapless::Vec::from_iter([(self.wrapped(i), 1.0)]);
        }
        let Range { start, end } = self.inside();
        let n = (end - start) as isize;
        let face = |i: isize| start + i as usize;
        let (side, at, mirrored) = match i {
            i if i <= 0 => (Side::Low, 0, -i),
            i if i >= n => (Side::High, n, 2 * n - i),
            i => return heapless::Vec::from_iter([(face(i), 1.0)]),
        };
        let mirrored = mirrored.clamp(0, n);
        match (self.ends.opens(side), mirrored == at) {
            (false, true) => heapless::Vec::new(),
            (false, false) => heapless::Vec::from_iter([(face(mirrored), -1.0)]),
            (true, true) => heapless::Vec::from_iter([(face(at), 1.0)]),
            (true, false) => heapless::Vec::from_iter([(face(at), 2.0), (face(mirrored), -1.0)]),
        }
    }

    /// The point `x`, counted in cells from the centre of cell 0, moved to the outermost centre where it lies between that
    /// and a wall, or behind the wall; and whether it was left where it was.
    #[inline]
    #[must_use]
    pub fn nearest_point(self, x: f64) -> (f64, bool) {
        let last = (self.cells - 1) as f64;
        if self.is_ring() || (x > 0.0 && x < last) {
            (x, true)
        } else {
            (x.clamp(0.0, last), false)
        }
    }

    #[inline]
    fn wrapped(self, i: isize) -> usize {
        i.rem_euclid(self.cells as isize) as usize
    }
}

impl Grid {
    /// Axis 0, 1 or 2.
    #[inline(always)]
    #[must_use]
    pub const fn axis(&self, axis: usize) -> Axis {
        Axis::new(self.n[axis], self.ends[axis])
    }

    /// Layers of cells outside the whole box beyond a side of an axis: 1 where that is open, else 0.
    #[inline]
    #[must_use]
    pub fn layers(&self, axis: usize, side: Side) -> usize {
        usize::from(self.whole_axis(axis).ends().opens(side))
    }

    /// Whether a side of the whole box is open.
    #[must_use]
    pub fn is_open(&self) -> bool {
        (0..self.dims).any(|axis| self.whole_axis(axis).ends().is_open())
    }

    /// The cells inside the box between walls where it has open sides.
    #[must_use]
    pub(crate) fn closed(&self) -> Self {
        let ends = self
            .ends
            .map(|end| if end.is_open() { Boundary::Wall } else { end });
        let n = self.inside().map(|inside| inside.len());
        Self { n, ends, ..*self }
    }

    /// The cells inside the box along each axis.
    #[must_use]
    pub fn inside(&self) -> [Range<usize>; 3] {
        core::array::from_fn(|axis| match self.part_along(axis) {
            Some(part) if !part.ring => self.range_here(axis, self.whole_axis(axis).inside()),
            _ => self.axis(axis).inside(),
        })
    }

    /// How many they are along each axis.
    #[must_use]
    pub fn counts_inside(&self) -> [usize; 3] {
        self.inside().map(|inside| inside.len())
    }

    /// Whether a cell is outside the box.
    #[must_use]
    pub fn is_outside(&self, at: [usize; 3]) -> bool {
        self.inside()
            .iter()
            .zip(at)
            .any(|(inside, at)| !inside.contains(&at))
    }

    /// The row beside `row` along y (axis 1) or z (axis 2), or `None` behind a wall.
    #[inline(always)]
    #[must_use]
    pub fn neighbour(&self, row: usize, axis: usize, side: Side) -> Option<usize> {
        let mut at = self.row_at(row);
        at[axis - 1] = self.axis(axis).cell(at[axis - 1] as isize + side.step())?;
        Some(self.row(at[0], at[1]))
    }

    /// The nine rows at offsets -1, 0, 1 along y and z, that at (y, z) in place 3 (z + 1) + y + 1, or `None` behind a wall;
    /// in 2D those at z = 0 alone.
    #[must_use]
    pub fn rows_around(&self, row: usize) -> [Option<usize>; 9] {
        let beside = |row: usize, axis: usize, offset: usize| match offset {
            0 => self.neighbour(row, axis, Side::Low),
            2 => self.neighbour(row, axis, Side::High),
            _ => Some(row),
        };
        core::array::from_fn(|place| {
            let in_y = beside(row, 1, place % 3)?;
            if self.dims == 3 || place / 3 == 1 {
                beside(in_y, 2, place / 3)
            } else {
                None
            }
        })
    }

    /// The cell beside cell `at`, or `None` behind a wall.
    #[inline(always)]
    #[must_use]
    pub fn beside(&self, at: [usize; 3], axis: usize, side: Side) -> Option<[usize; 3]> {
        let mut to = at;
        to[axis] = self.axis(axis).cell(at[axis] as isize + side.step())?;
        Some(to)
    }

    /// The faces of cell `at` that nothing flows through: bit 2 a of the low face along axis a, bit 2 a + 1 of the high one.
    #[inline(always)]
    #[must_use]
    pub fn closed_faces(&self, at: [usize; 3]) -> usize {
        (0..2 * self.dims).fold(0, |faces, face| {
            let side = [Side::Low, Side::High][face % 2];
            faces | usize::from(self.beside(at, face / 2, side).is_none()) << face
        })
    }

    /// Whether nothing flows through the low faces of `row` along y or z.
    #[inline]
    #[must_use]
    pub fn wall_below(&self, row: usize, axis: usize) -> bool {
        self.neighbour(row, axis, Side::Low).is_none()
    }
}

impl Side {
    /// The offset of the cell on this side.
    #[inline(always)]
    const fn step(self) -> isize {
        match self {
            Self::Low => -1,
            Self::High => 1,
        }
    }
}
