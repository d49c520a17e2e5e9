//! What walls and obstacles do to a viscous flow that sticks to them: no slip, by the half-cell formula.
//!
//! The sum over plaquettes in nu C^T C leaves out those on walls and at closed faces, so that a flow slips along them. Where it sticks, the
//! velocity at the surface is 0. Where both cells of a face are closed towards a side, as at a wall, the surface is half a cell away, so that the value
//! that is missing there is -v; at an edge that sticks out into the flow the neighbour lies on the surface itself, where the velocity is 0. With
//! minus the Laplacian along b of a component of the velocity, (v - v_below + v - v_above) / h_b^2, a face gets
//!
//! ```text
//! nu v sum over its neighbours along other axes b that are missing of c / h_b^2,
//!     c = 2 where the surface is half a cell away, c = 1 on an edge, c = 0 outside open sides
//! ```
//!
//! It is diagonal, symmetric and never negative. Between two walls the parabola of Poiseuille comes out exactly but for h^2 / 8 of its second
//! derivative.

use super::plaquette::Rule;
use crate::field::{Block, Vector};
use crate::grid::solids::{OUTSIDE, Solids, closed};
use crate::grid::{Grid, Side};
use crate::real::Real;

/// Adds what the faces of a row of a block get: of the second field, or of v where there is none.
pub fn add<T: Real, R: Rule<T>>(
    (block, row, solids): (&Block<'_>, usize, Solids<'_>),
    rule: R,
    v: Vector<'_, T>,
    second: Vector<'_, T>,
    out: &mut [&mut [T]; 3],
) {
    let (grid, nu) = (block.grid, rule.sticking());
    if !solids.stick() || nu == T::ZERO {
        return;
    }
    let field = if second.iter().all(|field| field.is_empty()) {
        v
    } else {
        second
    };
    for (axis, out) in out.iter_mut().enumerate().take(grid.dims) {
        if axis > 0 && grid.wall_below(row, axis) {
            continue;
        }
        let values = block.of(field[axis], row);
        let sides = grid.h.iter().enumerate().take(grid.dims);
        for (across, h) in sides.filter(|&(across, _)| across != axis) {
            let each = nu * T::from_f64(1.0 / (h * h));
            for side in [Side::Low, Side::High] {
                of_side((grid, row, solids), (axis, across, side), |x, c| {
                    let factor = each * T::from_f64(f64::from(c));
                    let slots = out.iter_mut().zip(values).skip(x).step_by(grid.n[0]);
                    slots.for_each(|(out, &value)| *out += factor * value);
                });
            }
        }
    }
}

/// Calls `work` with each open low face along `axis` in a row whose neighbour on a side along another axis is closed, and its c.
fn of_side(
    (grid, row, solids): (&Grid, usize, Solids<'_>),
    (axis, across, side): (usize, usize, Side),
    mut work: impl FnMut(usize, u8),
) {
    let n = grid.n[0];
    let own = solids.row(n, row);
    let is_open = |x: usize| {
        let is_wall = axis == 0 && grid.beside([x, 0, 0], 0, Side::Low).is_none();
        !is_wall && own.get(x).is_none_or(|bits| bits & closed(axis) == 0)
    };
    let mut of = |x: usize, c: u8| {
        if c > 0 && is_open(x) {
            work(x, c);
        }
    };
    let beside = match across {
        0 => Some(row),
        _ => grid.neighbour(row, across, side),
    };
    let Some(beside) = beside else {
        (0..n).for_each(|x| of(x, 2));
        return;
    };
    let table = solids.row(n, beside);
    if table.is_empty() && across > 0 {
        return;
    }
    let [_, y, z] = grid.cell_at(row, 0);
    for x in 0..n {
        let at = [x, y, z];
        let to = match across {
            0 => grid.beside(at, 0, side).map(|to| to[0]),
            _ => Some(x),
        };
        let c = to.map_or(2, |to| {
            let bits = [table.get(to), own.get(x)].map(|bits| bits.copied().unwrap_or(0));
            if (bits[0] | bits[1]) & (closed(axis) | closed(across)) == 0 {
                return 0;
            }
            missing(grid, solids, at, (axis, across, side))
        });
        of(x, c);
    }
}

/// c of the neighbour of the low face of cell `at` along `axis`, on a side along another axis behind which there are cells.
fn missing(
    grid: &Grid,
    solids: Solids<'_>,
    at: [usize; 3],
    (axis, across, side): (usize, usize, Side),
) -> u8 {
    let bits = |at: Option<[usize; 3]>| at.map_or(0, |at| solids.of_cell(grid, at));
    let below = grid.beside(at, axis, Side::Low);
    let to = |at: Option<[usize; 3]>| at.and_then(|at| grid.beside(at, across, side));
    // The faces of both cells towards that side.
    let towards = [Some(at), below].map(|at| match side {
        Side::Low => bits(at),
        Side::High => bits(to(at)),
    });
    let beside = [to(Some(at)), to(below)].map(bits);
    if towards.iter().all(|bits| bits & closed(across) != 0) {
        2
    } else if beside[0] & closed(axis) != 0 && (beside[0] | beside[1]) & OUTSIDE == 0 {
        1
    } else {
        0
    }
}
