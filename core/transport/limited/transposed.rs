//! The kernel of the adjoint: L'(y)^T z, and the gradient by the velocity, at rows of a run.

use super::super::kernel::{Along, Layout, Read, around};
use super::super::rows::Rows;
use super::limiter::{Numbers, differences, opening};
use crate::field::VectorMut;
use crate::field::rows::part_mut;
use crate::real::Real;
use crate::simd::{self, vectorised};
use core::ops::Range;

/// What the kernel reads.
pub struct Input<'a, T> {
    /// The rows of the run.
    pub count: usize,
    /// The adjoint of the stage, what flowed, and the velocities.
    pub read: Read<'a, T>,
    /// Which faces are open, where there are solid cells.
    pub open: Option<Rows<'a, T>>,
    /// tau / h of the grid's axes.
    pub scales: &'a [T],
    /// What the next z takes of z + tau L'(y)^T z.
    pub share: T,
    /// What mu keeps, and what it takes: of z where there is a next z, else of z + tau L'(y)^T z.
    pub of_mu: [T; 2],
    /// Whether nothing flows here.
    pub still: bool,
    /// The cells to write.
    pub span: Range<usize>,
}

/// Rows of a run to write.
pub struct Output<'t, T> {
    /// The next z, with halos, or empty.
    pub next: &'t mut [T],
    /// mu, or empty.
    pub mu: &'t mut [T],
    /// The gradient, added to.
    pub gradient: VectorMut<'t, T>,
    /// Of the next z.
    pub layout: Layout,
}

vectorised! {
    /// The next z, mu and `gradient += share tau / h rho_f(y) (z[R] - z[L])` at the cells' low faces, in all rows of a run.
    pub fn transposed[T, V](output: &mut Output<'_, T>, input: &Input<'_, T>) {
        transposed_rows::<T, V, false>(output, input);
    }
}

vectorised! {
    /// As [`transposed`], among solid cells.
    pub fn transposed_among_solids[T, V](output: &mut Output<'_, T>, input: &Input<'_, T>) {
        transposed_rows::<T, V, true>(output, input);
    }
}

#[inline(always)]
fn transposed_rows<T: Real, V: simd::Vector<Elem = T>, const SOLIDS: bool>(
    output: &mut Output<'_, T>,
    input: &Input<'_, T>,
) {
    let Layout { n, apart, before } = output.layout;
    let [gx, gy, gz] = &mut output.gradient;
    for row in 0..input.count {
        let span = row * n..(row + 1) * n;
        let begin = row * apart + before;
        let mut rows = OfRow {
            next: part_mut(output.next, begin..begin + n),
            mu: part_mut(output.mu, span.clone()),
            gradient: [
                part_mut(gx, span.clone()),
                part_mut(gy, span.clone()),
                part_mut(gz, span),
            ],
        };
        let i = transposed_from::<T, V, SOLIDS>(input.span.start, n, row, &mut rows, input);
        transposed_from::<T, T, SOLIDS>(i, n, row, &mut rows, input);
    }
}

/// One row to write.
struct OfRow<'t, T> {
    next: &'t mut [T],
    mu: &'t mut [T],
    gradient: VectorMut<'t, T>,
}

/// What an axis brings cells at `i`, and the gradient at their low faces. `here` is z and y there; s = tau / h, and the gradient takes
/// share times that.
#[inline(always)]
fn add<T: Real, V: simd::Vector<Elem = T>, const SOLIDS: bool>(
    (along, open): (&Along<'_, T>, &[&[T]; 4]),
    i: usize,
    here: [V; 2],
    gradient: &mut [T],
    [s, of_gradient]: [V; 2],
    numbers: Numbers<V>,
) -> V {
    let (z, y) = (around(&along.z, i, here[0]), around(&along.y, i, here[1]));
    let through = along.through(i);
    let open = opening::<T, V, SOLIDS>(open, i, here[0]);
    let across = differences::<V, SOLIDS>(y, open);
    let rho_f = numbers.by_velocity([y[1], y[2]], [across[0], across[1], across[2]], through[1]);
    (V::at(gradient, i) + of_gradient * rho_f * (z[2] - z[1])).put(gradient, i);
    s * numbers.outflow::<SOLIDS>(across, z, through, open)
}

/// The kernel of [`transposed`] from cell `i` of a row of `n` as far as whole vectors go; returns the first cell that is left.
#[inline(always)]
fn transposed_from<T: Real, V: simd::Vector<Elem = T>, const SOLIDS: bool>(
    mut i: usize,
    n: usize,
    row: usize,
    rows: &mut OfRow<'_, T>,
    input: &Input<'_, T>,
) -> usize {
    let last = input.scales.len() - 1;
    let [gx, gy, gz] = &mut rows.gradient;
    let (gx, gy) = (&mut gx[..n], &mut gy[..n]);
    let gz = if last > 1 { &mut gz[..n] } else { &mut [][..] };
    let read = &input.read;
    let (cells, rho) = (read.z.own(row, n + 4), read.y.own(row, n + 4));
    let (x, y) = (Along::x(row, n, read), Along::across(1, row, n, read));
    let z = Along::across(last, row, n, read);
    let open = input.open.filter(|_| SOLIDS).unwrap_or(read.faces);
    let open_x = open.own(row, n + 3);
    let open_x = [&open_x[..n], &open_x[1..], &open_x[2..], &open_x[3..]];
    let (open_y, open_z) = (open.along(1, row, n), open.along(last, row, n));
    let numbers = Numbers::<V>::new();
    let share = V::splat(input.share);
    let (keep, take) = (V::splat(input.of_mu[0]), V::splat(input.of_mu[1]));
    let (x_scale, y_scale) = (V::splat(input.scales[0]), V::splat(input.scales[1]));
    let z_scale = V::splat(input.scales[last]);
    let (scale_x, scale_y) = ([x_scale, share * x_scale], [y_scale, share * y_scale]);
    let scale_z = [z_scale, share * z_scale];
    let end = input.span.end.min(n);
    while i + V::LANES <= end {
        let here = [V::at(cells, i + 2), V::at(rho, i + 2)];
        let mut sum = here[0];
        if !input.still {
            sum = sum + add::<T, V, SOLIDS>((&x, &open_x), i, here, gx, scale_x, numbers);
            sum = sum + add::<T, V, SOLIDS>((&y, &open_y), i, here, gy, scale_y, numbers);
            if last > 1 {
                sum = sum + add::<T, V, SOLIDS>((&z, &open_z), i, here, gz, scale_z, numbers);
            }
        }
        let taken = if rows.next.is_empty() { sum } else { here[0] };
        if !rows.next.is_empty() {
            (share * sum).put(rows.next, i);
        }
        if !rows.mu.is_empty() {
            (keep * V::at(rows.mu, i) + take * taken).put(rows.mu, i);
        }
        i += V::LANES;
    }
    i
}
