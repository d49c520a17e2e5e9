//! Cells that nothing flows through, and cells outside open sides: which they are, and what they close.
//!
//! A face is closed where a solid cell is on either side: the velocity there is 0, as on a wall. A plaquette does nothing where one of its
//! faces is closed (free slip), as on a wall. All of it is one table of bits a cell, so that an operator asks once.
//!
//! A cell outside the box has no density, as a solid one, and no pressure. Faces between two of them, or between one and a solid cell, are
//! closed; the face between one and the fluid is an exit: the flow passes freely, smoke leaves by it, and none comes in.

use super::part::settle;
use super::{Axis, D2, D3, Grid, Side, Space};
use crate::exec::Ranks;
use crate::real::Real;
use core::ops::Range;

/// The cell is solid, or outside the box.
pub const SOLID: u16 = 1;
/// The cell is outside the box.
pub const OUTSIDE: u16 = 128;

/// The low face of the cell along `axis` is closed.
#[inline(always)]
#[must_use]
pub const fn closed(axis: usize) -> u16 {
    2 << axis
}

/// The plaquette at the low corner of the cell, of the axis pair with this number, does nothing.
#[inline(always)]
#[must_use]
pub const fn dead(pair: usize) -> u16 {
    16 << pair
}

/// The low face of the cell along `axis` is an exit.
#[inline(always)]
#[must_use]
pub const fn exit(axis: usize) -> u16 {
    256 << axis
}

/// What the flow meets in a box.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Surfaces {
    /// Whether there may be obstacles, or all solid cells are outside.
    pub obstacles: bool,
    /// Whether the flow sticks to them and to walls, by its viscosity, or slips along them.
    pub stick: bool,
}

/// The solid cells of a grid; there may be none.
#[derive(Clone, Copy, Debug, Default)]
pub struct Solids<'a> {
    /// Whether there may be any, or cells outside: then workspaces have room for what they ask for.
    there: bool,
    surfaces: Surfaces,
    /// Bits of each cell, row after row; empty while workspaces are only measured.
    bits: &'a [u16],
}

impl<'a> Solids<'a> {
    /// The table of a grid, which [`fill`] or [`coarsen`] made.
    #[must_use]
    pub fn new(bits: &'a [u16], surfaces: Surfaces) -> Self {
        Self {
            there: true,
            surfaces,
            bits,
        }
    }

    /// No solid cells in a box with walls, to which the flow sticks or not.
    #[must_use]
    pub fn none(stick: bool) -> Self {
        Self {
            surfaces: Surfaces {
                obstacles: false,
                stick,
            },
            ..Self::default()
        }
    }

    /// Whether the flow sticks to walls and obstacles.
    #[inline(always)]
    #[must_use]
    pub fn stick(&self) -> bool {
        self.surfaces.stick
    }

    /// Whether there may be obstacles in the box.
    #[inline(always)]
    #[must_use]
    pub fn obstacles(&self) -> bool {
        self.surfaces.obstacles
    }

    /// Whether there may be any, or cells outside.
    #[inline(always)]
    #[must_use]
    pub fn there(&self) -> bool {
        self.there
    }

    /// The bits of a row of `n` cells.
    #[inline(always)]
    #[must_use]
    pub fn row(&self, n: usize, row: usize) -> &'a [u16] {
        self.bits.get(row * n..(row + 1) * n).unwrap_or(&[])
    }

    /// The faces of cell `at` that solid cells close, in the order of [`Grid::closed_faces`].
    #[inline(always)]
    #[must_use]
    pub fn closed_faces(&self, grid: &Grid, at: [usize; 3]) -> usize {
        if !self.there {
            return 0;
        }
        (0..2 * grid.dims).fold(0, |faces, face| {
            let (axis, high) = (face / 2, face % 2 == 1);
            let of = if high {
                grid.beside(at, axis, Side::High)
            } else {
                Some(at)
            };
            let is_closed = of.is_some_and(|of| self.of_cell(grid, of) & closed(axis) != 0);
            faces | usize::from(is_closed) << face
        })
    }

    /// Whether the plaquette at an edge of cell `at` does nothing: that of an axis pair with its number, on these sides along both.
    #[inline(always)]
    #[must_use]
    pub fn is_dead(
        &self,
        grid: &Grid,
        at: [usize; 3],
        (pair, axes): (usize, [usize; 2]),
        sides: [usize; 2],
    ) -> bool {
        if !self.there {
            return false;
        }
        let mut of = Some(at);
        for (axis, _) in axes.into_iter().zip(sides).filter(|(_, side)| *side == 1) {
            of = of.and_then(|of| grid.beside(of, axis, Side::High));
        }
        of.is_some_and(|of| self.of_cell(grid, of) & dead(pair) != 0)
    }

    /// The bits of a cell.
    #[inline(always)]
    pub(crate) fn of_cell(&self, grid: &Grid, at: [usize; 3]) -> u16 {
        self.bits.get(grid.index(at)).copied().unwrap_or(0)
    }

    /// Sets a field of cells, of rows of `n`, to 0 in solid ones.
    pub fn clear_cells<T: Real>(&self, n: usize, field: &mut [T]) {
        if self.there {
            let rows = field.chunks_exact_mut(n).enumerate();
            rows.for_each(|(row, values)| self.clear(n, row, SOLID, values));
        }
    }

    /// Sets `values` of a row to 0 where a cell has any of the `bits`; there may be several slots of that row, one after the other.
    #[inline]
    pub fn clear<T: Real>(&self, n: usize, row: usize, bits: u16, values: &mut [T]) {
        let table = self.row(n, row);
        for slot in values.chunks_exact_mut(n) {
            for (value, &has) in slot.iter_mut().zip(table) {
                if has & bits != 0 {
                    *value = T::ZERO;
                }
            }
        }
    }
}

/// Fills the table of `grid` from [`SOLID`] of each cell inside; of a box that ranks share, of each of the rank's own.
pub fn fill(ranks: &dyn Ranks, grid: &Grid, bits: &mut [u16]) {
    set_outside(grid, bits);
    close((ranks, [grid; 2]), bits, |bits, cell, low, _| {
        let (both, either) = (bits[cell] & bits[low], bits[cell] | bits[low]);
        // Outside cells are solid too: two solid cells, or one inside.
        both & SOLID != 0 || either & (SOLID | OUTSIDE) == SOLID
    });
}

/// Marks the cells outside the box.
fn set_outside(grid: &Grid, bits: &mut [u16]) {
    if !grid.is_open() {
        return;
    }
    for (cell, bits) in bits.iter_mut().enumerate() {
        if grid.is_outside(grid.cell_at(cell / grid.n[0], cell % grid.n[0])) {
            *bits = SOLID | OUTSIDE;
        }
    }
}

/// The cells of an axis of the finer grid that cell `at` of the coarser one reaches into: one and the same for a cell outside.
fn children_along(fine: Axis, coarse: Axis, at: usize) -> Range<usize> {
    let (inside, from) = (coarse.inside(), fine.inside());
    if at < inside.start {
        0..1
    } else if at >= inside.end {
        from.end..from.end + 1
    } else {
        let (cells, place) = (inside.len().max(1), (at - inside.start) * from.len());
        from.start + place / cells..from.start + (place + from.len()).div_ceil(cells)
    }
}

/// The low faces of an axis of the finer grid around that of cell `at` of the coarser one: one where the two are at the same place.
fn faces_along(fine: Axis, coarse: Axis, at: usize) -> [usize; 2] {
    let (inside, from) = (coarse.inside(), fine.inside());
    let (cells, place) = (inside.len().max(1), at.saturating_sub(inside.start) * from.len());
    let around = [place / cells, place.div_ceil(cells)];
    around.map(|face| match fine.is_ring() {
        true => face % from.len().max(1),
        false => from.start + face,
    })
}

/// Fills the table of `coarse` from that of `fine`: a cell is solid where all cells are that it reaches into, and a face closed where all fine
/// faces are that it is made of, those which restriction takes the mean of.
pub fn coarsen(ranks: &dyn Ranks, fine: &Grid, table: &[u16], coarse: &Grid, bits: &mut [u16]) {
    let children = |axis: usize, at: usize| match axis < coarse.dims {
        true => children_along(
            fine.whole_axis(axis),
            coarse.whole_axis(axis),
            coarse.in_whole(axis, at),
        ),
        false => 0..1,
    };
    // Of what only copies are made of not all is here: they become what their owner has.
    let has_all = |[x, y, z]: [usize; 3], has: u16| match [(0, x), (1, y), (2, z)]
        .map(|(axis, i)| fine.here(axis, i))
    {
        [Some(x), Some(y), Some(z)] => table[fine.index([x, y, z])] & has != 0,
        _ => true,
    };
    let all = |ranges: [Range<usize>; 3], has: u16| {
        let [x, y, z] = ranges;
        z.flat_map(|z| y.clone().map(move |y| (y, z)))
            .all(|(y, z)| x.clone().all(|x| has_all([x, y, z], has)))
    };
    for row in 0..coarse.rows() {
        for x in 0..coarse.n[0] {
            let at = coarse.cell_at(row, x);
            let solid = all(core::array::from_fn(|axis| children(axis, at[axis])), SOLID);
            bits[coarse.index(at)] = if solid { SOLID } else { 0 };
        }
    }
    set_outside(coarse, bits);
    close((ranks, [fine, coarse]), bits, |_, cell, _, axis| {
        let at = coarse.cell_at(cell / coarse.n[0], cell % coarse.n[0]);
        let place = coarse.in_whole(axis, at[axis]);
        let around = faces_along(fine.whole_axis(axis), coarse.whole_axis(axis), place);
        around.into_iter().all(|face| {
            let of = |other| {
                if other == axis {
                    face..face + 1
                } else {
                    children(other, at[other])
                }
            };
            all(core::array::from_fn(of), closed(axis))
        })
    });
}

/// Sets the bits of faces by what `is_closed` says of a cell, the cell below it and the axis between, then those of plaquettes. The second of the grids is
/// that of the table, which ranks bring up to date after each; the first is what it is made of.
fn close(
    (ranks, grids): (&dyn Ranks, [&Grid; 2]),
    bits: &mut [u16],
    is_closed: impl Fn(&[u16], usize, usize, usize) -> bool,
) {
    let grid = grids[1];
    settle(ranks, grids, None, bits);
    for cell in 0..grid.cells() {
        let at = grid.cell_at(cell / grid.n[0], cell % grid.n[0]);
        for axis in 0..grid.dims {
            if let Some(low) = grid.beside(at, axis, Side::Low) {
                let low = grid.index(low);
                if is_closed(bits, cell, low, axis) {
                    bits[cell] |= closed(axis);
                } else if (bits[cell] | bits[low]) & OUTSIDE != 0 {
                    bits[cell] |= exit(axis);
                }
            }
        }
    }
    settle(ranks, grids, None, bits);
    let pairs = if grid.dims == 2 { D2::PAIRS } else { D3::PAIRS };
    for cell in 0..grid.cells() {
        let at = grid.cell_at(cell / grid.n[0], cell % grid.n[0]);
        for (pair, &(a, b)) in pairs.iter().enumerate() {
            let below = |axis: usize, face: usize| {
                let low = grid.beside(at, axis, Side::Low);
                low.is_some_and(|low| bits[grid.index(low)] & closed(face) != 0)
            };
            let here = bits[cell] & (closed(a) | closed(b)) != 0;
            if here || below(b, a) || below(a, b) {
                bits[cell] |= dead(pair);
            }
        }
    }
    settle(ranks, grids, None, bits);
}
