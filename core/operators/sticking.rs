//! What walls and obstacles do to a viscous flow that sticks to them: no slip, by the half-cell formula.
//!
//! The sum over plaquettes in nu C^T C leaves out those on walls and at closed faces, so that a flow slips along them. Where it sticks, the
//! velocity at the surface is 0. Beyond a wall, and between two solid cells, a face has no neighbour, and the surface is half a cell away, so
//! that the missing value is -v; at an edge that sticks out into the flow the neighbour lies on the surface itself, where the velocity is 0. With
//! minus the Laplacian along b of a component of the velocity, (v - v_below + v - v_above) / h_b^2, a face gets
//!
//! ```text
//! nu v sum over its neighbours along other axes b that are closed of c / h_b^2,
//!     c = 2 beyond a wall and between solid cells, c = 1 on a surface, c = 0 outside open sides
//! ```
//!
//! It is diagonal, symmetric and never negative. Between two walls the parabola of Poiseuille comes out exactly but for h^2 / 8 of its second
//! derivative.

use super::plaquette::{Adjoint, Advection, Bend, Derivative, Drag};
use crate::field::{Block, Vector};
use crate::grid::solids::{OUTSIDE, SOLID, Solids, closed};
use crate::grid::{Grid, Side};
use crate::real::Real;

/// What a rule of the plaquettes does at surfaces to which the flow sticks.
pub trait AtSurfaces<T>: Copy {
    /// The nu by which it sticks: 0 where it does not.
    fn sticking(self) -> T;
}

impl<T: Real> AtSurfaces<T> for Advection<T> {
    fn sticking(self) -> T {
        self.0
    }
}

impl<T: Real> AtSurfaces<T> for Derivative<T> {
    fn sticking(self) -> T {
        self.0
    }
}

impl<T: Real> AtSurfaces<T> for Adjoint<T> {
    fn sticking(self) -> T {
        self.0
    }
}

// The curls of forces stick to nothing.
impl<T: Real> AtSurfaces<T> for Drag<T> {
    fn sticking(self) -> T {
        T::ZERO
    }
}

impl<T: Real> AtSurfaces<T> for Bend {
    fn sticking(self) -> T {
        T::ZERO
    }
}

/// Adds what the faces of a row of a block get: of the second field, or of v where there is none.
pub fn add<T: Real, R: AtSurfaces<T>>(
    (block, row, solids): (&Block<'_>, usize, Solids<'_>),
    rule: R,
    v: Vector<'_, T>,
    second: Vector<'_, T>,
    out: &mut [&mut [T]; 3],
) {
    let (grid, n, nu) = (block.grid, block.grid.n[0], rule.sticking());
    if !solids.stick() || nu == T::ZERO {
        return;
    }
    let field = if second.iter().all(|field| field.is_empty()) {
        v
    } else {
        second
    };
    for (axis, out) in out.iter_mut().enumerate().take(grid.dims) {
        let values = block.of(field[axis], row);
        for x in 0..n {
            let stiffness = stiffness(grid, solids, axis, grid.cell_at(row, x));
            if stiffness > 0.0 {
                let factor = nu * T::from_f64(stiffness);
                let slots = out.iter_mut().zip(values).skip(x).step_by(n);
                slots.for_each(|(out, &value)| *out += factor * value);
            }
        }
    }
}

/// The sum of c / h^2 at the low face of cell `at` along `axis`: 0 where that is closed.
fn stiffness(grid: &Grid, solids: Solids<'_>, axis: usize, at: [usize; 3]) -> f64 {
    if grid.beside(at, axis, Side::Low).is_none() || solids.of_cell(grid, at) & closed(axis) != 0 {
        return 0.0;
    }
    let across = (0..grid.dims).filter(|&across| across != axis);
    let sides = across.flat_map(|across| [Side::Low, Side::High].map(|side| (across, side)));
    let closeness = sides.map(|(across, side)| {
        let other = grid.beside(at, across, side);
        let c = other.map_or(2, |other| missing(grid, solids, axis, other));
        f64::from(c) / (grid.h[across] * grid.h[across])
    });
    closeness.sum()
}

/// c of the low face of cell `at` along `axis`.
fn missing(grid: &Grid, solids: Solids<'_>, axis: usize, at: [usize; 3]) -> u8 {
    let bits = solids.of_cell(grid, at);
    let below = grid.beside(at, axis, Side::Low);
    let below = below.map_or(SOLID, |below| solids.of_cell(grid, below));
    match (bits & closed(axis) != 0, (bits | below) & OUTSIDE != 0) {
        (false, _) | (_, true) => 0,
        _ if bits & below & SOLID != 0 => 2,
        _ => 1,
    }
}
