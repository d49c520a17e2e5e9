//! Poisson's problem among solid cells: conjugate gradients, preconditioned by the box's own solve (mathematics section 8).
//!
//! A = -div grad with closed faces left out is symmetric and positive but for constants, one for each part of the fluid. The box without its
//! solids has nearly the same long waves: M = F S F, with S its inverse and F leaving solid cells out, is symmetric too.
//!
//! With an importance W at the cells A = -div W^-2 grad, W at a face the mean of its two cells.

use super::eigen;
use crate::exec::Exec;
use crate::field::rows::{self, part, part_mut};
use crate::field::sums;
use crate::field::turned::Turned;
use crate::grid::solids::{Solids, closed};
use crate::grid::spectrum::Spectrum;
use crate::grid::{Grid, Side};
use crate::real::Real;

/// Steps at most: a disc takes some 12, a maze more.
const STEPS: usize = 60;
/// The same with an importance from 0.1 to 1, with which a disc takes some 100.
const WEIGHTED_STEPS: usize = 600;

/// Fields of a slot beside its potential.
pub const FIELDS: usize = 3;

/// `field`, a right-hand side at the cells of one slot, becomes q with div grad q = right-hand side through open faces, until no residual is
/// above `goal`. `work` holds [`FIELDS`] fields. With an `importance`, a field of cells, div W^-2 grad q is solved for. The box's own solves, which
/// take most of it, are on the threads of `exec`; where ranks share the box they turn it in `turned`.
pub fn solve<T: Real>(
    exec: &dyn Exec,
    (grid, spectrum, solids): (&Grid, &Spectrum<'_, T>, Solids<'_>),
    goal: f64,
    importance: Option<&[T]>,
    field: &mut [T],
    work: &mut [T],
    turned: &mut Turned<'_, T>,
    scratch: &mut [T],
) {
    let cells = grid.cells();
    let (residual, rest) = work.split_at_mut(cells);
    let (direction, image) = rest.split_at_mut(cells);
    let image = &mut image[..cells];
    // A q = -right-hand side, from q = 0.
    rows::scale(residual, -T::ONE, field);
    field.fill(T::ZERO);
    let mut precondition = |residual: &[T], out: &mut [T]| {
        out.copy_from_slice(residual);
        if grid.is_part() {
            eigen::solve_turned(exec, (grid, spectrum), out, turned, scratch);
        } else {
            eigen::solve(exec, (grid, spectrum), out, scratch);
        }
        rows::scale_in_place(out, -T::ONE);
        solids.clear_cells(grid.n[0], out);
    };
    precondition(residual, direction);
    let mut slope = dot(exec, grid, residual, direction);
    let steps = importance.map_or(STEPS, |_| WEIGHTED_STEPS);
    for _ in 0..steps {
        if !(slope > 0.0) || !(largest(exec, grid, residual) > goal) {
            return;
        }
        match importance {
            Some(importance) => apply(grid, solids, direction, importance, ease, image),
            None => apply(grid, solids, direction, direction, |_, _| T::ONE, image),
        }
        if grid.is_open() {
            // What passes exits ends outside, where there is no equation.
            solids.clear_cells(grid.n[0], image);
        }
        let length = T::from_f64(slope / dot(exec, grid, direction, image));
        rows::add_scaled(field, length, direction);
        rows::add_scaled(residual, -length, image);
        precondition(residual, image);
        let next = dot(exec, grid, residual, image);
        rows::combine(direction, T::from_f64(next / slope), image);
        slope = next;
    }
}

/// The sum of products, row by row.
fn dot<T: Real>(exec: &dyn Exec, grid: &Grid, x: &[T], y: &[T]) -> f64 {
    let n = grid.n[0];
    let mut sum = [0.0];
    sums::over_rows(exec.ranks(), grid, &mut sum, |row, _| {
        rows::dot(part(x, row * n..(row + 1) * n), part(y, row * n..(row + 1) * n))
    });
    sum[0]
}

/// max |x| of all ranks.
fn largest<T: Real>(exec: &dyn Exec, grid: &Grid, x: &[T]) -> f64 {
    let n = grid.n[0];
    sums::most(exec, grid, x.chunks_exact(n.max(1)).map(|row| rows::max_abs(row)))
}

/// W^-2 at the face between two cells of an importance W, which has the mean of both there.
#[inline(always)]
pub fn ease<T: Real>(low: T, high: T) -> T {
    let mean = T::from_f64(0.5) * (low + high);
    T::ONE / (mean * mean)
}

/// A row of a potential, with a field of cells beside it.
#[derive(Clone, Copy)]
struct Row<'a, T> {
    x: &'a [T],
    cells: &'a [T],
}

impl<'a, T: Real> Row<'a, T> {
    fn of(x: &'a [T], cells: &'a [T], n: usize, row: usize) -> Self {
        let range = row * n..(row + 1) * n;
        Self {
            x: part(x, range.clone()),
            cells: part(cells, range),
        }
    }

    /// Both values of each cell.
    fn values(self) -> impl Iterator<Item = [T; 2]> + 'a {
        self.x.iter().zip(self.cells).map(|(&x, &cell)| [x, cell])
    }
}

/// `out = -div e grad x` through open faces; `ease` tells e of a face by the values of its two cells in `cells`.
fn apply<T: Real>(
    grid: &Grid,
    solids: Solids<'_>,
    x: &[T],
    cells: &[T],
    ease: impl Fn(T, T) -> T + Copy,
    out: &mut [T],
) {
    let n = grid.n[0];
    for row in 0..grid.rows() {
        let here = Row::of(x, cells, n, row);
        let out = part_mut(out, row * n..(row + 1) * n);
        out.fill(T::ZERO);
        for (axis, h) in grid.h.iter().enumerate().take(grid.dims) {
            let (weight, closed) = (T::from_f64(1.0 / (h * h)), closed(axis));
            if axis == 0 {
                let own = solids.row(n, row);
                along_row(out, here, own, weight, ease, grid.axis(0).is_ring());
                continue;
            }
            // Through the low faces of this row, and through those of the row above.
            for side in [Side::Low, Side::High] {
                let Some(other) = grid.neighbour(row, axis, side) else {
                    continue;
                };
                let bits = solids.row(n, if side == Side::Low { row } else { other });
                let there = Row::of(x, cells, n, other);
                let faces = here.values().zip(there.values()).zip(bits);
                for (out, ((here, there), bits)) in out.iter_mut().zip(faces) {
                    *out += flux(bits & closed == 0, weight, ease, here, there);
                }
            }
        }
    }
}

/// What the faces along a row bring its cells.
fn along_row<T: Real>(
    out: &mut [T],
    here: Row<'_, T>,
    solids: &[u16],
    weight: T,
    ease: impl Fn(T, T) -> T + Copy,
    ring: bool,
) {
    let open = |bits: &u16| bits & closed(0) == 0;
    let pairs = here.values().zip(here.values().skip(1));
    for (cell, ((low, high), bits)) in pairs.zip(solids.get(1..).unwrap_or(&[])).enumerate() {
        if let Some([of_low, of_high]) = out.get_mut(cell..cell + 2) {
            let flux = flux(open(bits), weight, ease, high, low);
            *of_low -= flux;
            *of_high += flux;
        }
    }
    if let (true, Some(first), Some(last), Some(bits)) =
        (ring, here.values().next(), here.values().last(), solids.first())
    {
        let flux = flux(open(bits), weight, ease, first, last);
        if let [of_first, .., of_last] = out {
            *of_first += flux;
            *of_last -= flux;
        }
    }
}

/// What a face between two cells brings the first.
#[inline(always)]
fn flux<T: Real>(open: bool, weight: T, ease: impl Fn(T, T) -> T, here: [T; 2], other: [T; 2]) -> T {
    if open {
        weight * ease(here[1], other[1]) * (here[0] - other[0])
    } else {
        T::ZERO
    }
}
