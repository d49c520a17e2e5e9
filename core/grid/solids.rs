//! Cells that nothing flows through, and cells outside open sides: which they are, and what they close.
//!
//! A face is closed where a solid cell is on either side: the velocity there is 0, as on a wall. A plaquette does nothing where one of its
//! faces is closed (free slip), as on a wall. All of it is one table of bits a cell, so that an operator asks once.
//!
//! A cell outside the box has no density, as a solid one, and no pressure. Faces between two of them, or between one and a solid cell, are
//! closed; the face between one and the fluid is an exit: the flow passes freely, smoke leaves by it, and none comes in.

use super::{Axis, D2, D3, Grid, Side, Space};
use crate::real::Real;

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

/// The solid cells of a grid; there may be none.
#[derive(Clone, Copy, Debug, Default)]
pub struct Solids<'a> {
    /// Whether there may be any, or cells outside: then workspaces have room for what they ask for.
    there: bool,
    /// Whether there may be obstacles, or all that is here is outside.
    obstacles: bool,
    /// Bits of each cell, row after row; empty while workspaces are only measured.
    bits: &'a [u16],
}

impl<'a> Solids<'a> {
    /// The table of a grid, which [`fill`] or [`coarsen`] made, and whether there may be obstacles.
    #[must_use]
    pub fn new(bits: &'a [u16], obstacles: bool) -> Self {
        Self {
            there: true,
            obstacles,
            bits,
        }
    }

    /// Whether there may be obstacles in the box.
    #[inline(always)]
    #[must_use]
    pub fn obstacles(&self) -> bool {
        self.obstacles
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

/// Fills the table of `grid` from [`SOLID`] of each cell inside.
pub fn fill(grid: &Grid, bits: &mut [u16]) {
    set_outside(grid, bits);
    close(grid, bits, |bits, cell, low, _| {
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

/// The cells of an axis of the finer grid that cell `at` of the coarser one is made of: one and the same for a cell outside.
fn children_along(fine: Axis, coarse: Axis, at: usize) -> [usize; 2] {
    let (inside, from) = (coarse.inside(), fine.inside());
    if at < inside.start {
        [0, 0]
    } else if at >= inside.end {
        [from.end, from.end]
    } else {
        let first = from.start + (at - inside.start) * from.len() / inside.len();
        [first, first + usize::from(from.len() > inside.len())]
    }
}

/// Fills the table of `coarse` from that of `fine`, which halves exactly to it: a cell is solid where all its children are, and a face
/// closed where all its fine faces are.
pub fn coarsen(fine: &Grid, table: &[u16], coarse: &Grid, bits: &mut [u16]) {
    let along = |axis: usize, at: usize| children_along(fine.axis(axis), coarse.axis(axis), at);
    let children = |at: [usize; 3]| {
        let offsets = (0..1 << coarse.dims).map(|child: usize| [child & 1, child >> 1 & 1, child >> 2 & 1]);
        offsets.map(move |offset| -> [usize; 3] { core::array::from_fn(|a| along(a, at[a])[offset[a]]) })
    };
    for row in 0..coarse.rows() {
        for x in 0..coarse.n[0] {
            let at = coarse.cell_at(row, x);
            let solid = children(at).all(|child| table[fine.index(child)] & SOLID != 0);
            bits[coarse.index(at)] = if solid { SOLID } else { 0 };
        }
    }
    set_outside(coarse, bits);
    close(coarse, bits, |_, cell, _, axis| {
        let at = coarse.cell_at(cell / coarse.n[0], cell % coarse.n[0]);
        let first = along(axis, at[axis])[0];
        let mut faces = children(at).filter(|child| child[axis] == first);
        faces.all(|face| table[fine.index(face)] & closed(axis) != 0)
    });
}

/// Sets the bits of faces by what `is_closed` says of a cell, the cell below it and the axis between, then those of plaquettes.
fn close(grid: &Grid, bits: &mut [u16], is_closed: impl Fn(&[u16], usize, usize, usize) -> bool) {
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
}
