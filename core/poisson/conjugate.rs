//! Poisson's problem among solid cells: conjugate gradients, preconditioned by the box's own solve (mathematics section 8).
//!
//! A = -div grad with closed faces left out is symmetric and positive but for constants, one for each part of the fluid. The box without its
//! solids has nearly the same long waves: M = F S F, with S its inverse and F leaving solid cells out, is symmetric too.

use super::eigen;
use crate::field::rows::{self, part, part_mut};
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
        if grid.is_open() {
            // What passes exits ends outside, where there is no equation.
            solids.clear_cells(grid.n[0], image);
        }
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
    for row in 0..grid.rows() {
        let here = part(x, row * n..(row + 1) * n);
        let own = solids.row(n, row);
        let out = part_mut(out, row * n..(row + 1) * n);
        out.fill(T::ZERO);
        for (axis, h) in grid.h.iter().enumerate().take(grid.dims) {
            let (weight, closed) = (T::from_f64(1.0 / (h * h)), closed(axis));
            if axis == 0 {
                along_row(out, here, own, weight, grid.axis(0).is_ring());
                continue;
            }
            // Through the low faces of this row, and through those of the row above.
            if let Some(low) = grid.neighbour(row, axis, Side::Low) {
                let faces = here.iter().zip(part(x, low * n..(low + 1) * n)).zip(own);
                for (out, ((&here, &low), bits)) in out.iter_mut().zip(faces) {
                    *out += flux(bits & closed == 0, weight, here, low);
                }
            }
            if let Some(high) = grid.neighbour(row, axis, Side::High) {
                let faces = here
                    .iter()
                    .zip(part(x, high * n..(high + 1) * n))
                    .zip(solids.row(n, high));
                for (out, ((&here, &high), bits)) in out.iter_mut().zip(faces) {
                    *out += flux(bits & closed == 0, weight, here, high);
                }
            }
        }
    }
}

/// What the faces along a row bring its cells.
fn along_row<T: Real>(out: &mut [T], here: &[T], solids: &[u16], weight: T, ring: bool) {
    let open = |bits: &u16| bits & closed(0) == 0;
    let pairs = here.windows(2).zip(solids.get(1..).unwrap_or(&[]));
    for (cell, (pair, bits)) in pairs.enumerate() {
        if let ([low, high], Some([of_low, of_high])) = (pair, out.get_mut(cell..cell + 2)) {
            let flux = flux(open(bits), weight, *high, *low);
            *of_low -= flux;
            *of_high += flux;
        }
    }
    if let (true, [first, .., last], Some(bits)) = (ring, here, solids.first()) {
        let flux = flux(open(bits), weight, *first, *last);
        if let [of_first, .., of_last] = out {
            *of_first += flux;
            *of_last -= flux;
        }
    }
}

/// What a face between two cells brings the first.
#[inline(always)]
fn flux<T: Real>(open: bool, weight: T, here: T, other: T) -> T {
    if open { weight * (here - other) } else { T::ZERO }
}
