//! Poisson's problem among solid cells: conjugate gradients, preconditioned by the box's own solve (mathematics section 8).
//!
//! A = -div grad with closed faces left out is symmetric and positive but for constants, one for each part of the fluid. The box without its
//! solids has nearly the same long waves: M = F S F, with S its inverse and F leaving solid cells out, is symmetric too.

use super::eigen;
use crate::field::rows;
use crate::grid::solids::{Solids, closed};
use crate::grid::spectrum::Spectrum;
use crate::grid::{Grid, Side};
use crate::real::Real;

/// Steps at most: a disc takes some 12, a maze more.
const STEPS: usize = 60;

/// Fields of a slot beside its potential.
pub const FIELDS: usize = 3;

/// `field`, a right-hand side at the cells of one slot, becomes q with div grad q = right-hand side through open faces, until no residual is
/// above `goal`. `work` holds [`FIELDS`] fields.
pub fn solve<T: Real>(
    (grid, spectrum, solids): (&Grid, &Spectrum<'_, T>, Solids<'_>),
    goal: f64,
    field: &mut [T],
    work: &mut [T],
    scratch: &mut [T],
) {
    let cells = grid.cells();
    let (residual, rest) = work.split_at_mut(cells);
    let (direction, image) = rest.split_at_mut(cells);
    let image = &mut image[..cells];
    // A q = -right-hand side, from q = 0.
    rows::scale(residual, -T::ONE, field);
    field.fill(T::ZERO);
    let precondition = |residual: &[T], out: &mut [T], scratch: &mut [T]| {
        out.copy_from_slice(residual);
        eigen::solve(grid, spectrum, out, scratch);
        rows::scale_in_place(out, -T::ONE);
        solids.clear_cells(grid.n[0], out);
    };
    precondition(residual, direction, scratch);
    let mut slope = rows::dot(residual, direction);
    for _ in 0..STEPS {
        if !(slope > 0.0) || !(rows::max_abs(residual) > goal) {
            return;
        }
        apply(grid, solids, direction, image);
        let length = T::from_f64(slope / rows::dot(direction, image));
        rows::add_scaled(field, length, direction);
        rows::add_scaled(residual, -length, image);
        precondition(residual, image, scratch);
        let next = rows::dot(residual, image);
        rows::combine(direction, T::from_f64(next / slope), image);
        slope = next;
    }
}

/// `out = -div grad x` through open faces.
fn apply<T: Real>(grid: &Grid, solids: Solids<'_>, x: &[T], out: &mut [T]) {
    let n = grid.n[0];
    out.fill(T::ZERO);
    for row in 0..grid.rows() {
        let here = &x[row * n..(row + 1) * n];
        let table = solids.row(n, row);
        let weight = |axis: usize| T::from_f64(1.0 / (grid.h[axis] * grid.h[axis]));
        for axis in 1..grid.dims {
            let Some(low) = grid.neighbour(row, axis, Side::Low) else {
                continue;
            };
            for i in 0..n {
                let flux = flux(
                    table[i] & closed(axis) == 0,
                    weight(axis),
                    here[i],
                    x[low * n + i],
                );
                out[row * n + i] += flux;
                out[low * n + i] -= flux;
            }
        }
        let out = &mut out[row * n..(row + 1) * n];
        for i in 0..n {
            if let Some(low) = grid.axis(0).cell(i as isize - 1) {
                let flux = flux(table[i] & closed(0) == 0, weight(0), here[i], here[low]);
                out[i] += flux;
                out[low] -= flux;
            }
        }
    }
}

/// What a face between two cells brings the higher one.
#[inline(always)]
fn flux<T: Real>(open: bool, weight: T, high: T, low: T) -> T {
    if open { weight * (high - low) } else { T::ZERO }
}
