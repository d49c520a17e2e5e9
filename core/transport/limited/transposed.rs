//! The kernel of the adjoint: L'(y)^T z, and the gradient by the velocity, at rows of a run.

use super::super::rows::Rows;
use super::limiter::Numbers;
use crate::field::VectorMut;
use crate::field::rows::part_mut;
use crate::real::Real;
use crate::simd::{self, vectorised};

/// What the kernel reads.
pub struct Input<'a, T> {
    /// Cells of a row, and the rows of the run.
    pub n: usize,
    pub count: usize,
    /// Where the cells begin in a row of the next z.
    pub before: usize,
    /// The adjoint of the stage, in the rows of a run and around them.
    pub z: Rows<'a, T>,
    /// What flowed.
    pub y: Rows<'a, T>,
    /// Velocities.
    pub faces: Rows<'a, T>,
    /// tau / h of the grid's axes.
    pub scales: &'a [T],
    /// What the next z takes of z + tau L'(y)^T z.
    pub share: T,
    /// What mu keeps, and what it takes: of z where there is a next z, else of z + tau L'(y)^T z.
    pub of_mu: [T; 2],
    /// Whether nothing flows here.
    pub still: bool,
}

/// Rows of a run to write.
pub struct Output<'t, T> {
    /// The next z, with halos, or empty.
    pub next: &'t mut [T],
    /// mu, or empty.
    pub mu: &'t mut [T],
    /// The gradient, added to.
    pub gradient: VectorMut<'t, T>,
    /// The distance between rows of the next z.
    pub apart: usize,
}

vectorised! {
    /// The next z, mu and `gradient += share tau / h rho_f(y) (z[R] - z[L])` at the cells' low faces, in all rows of a run.
    pub fn transposed[T, V](output: &mut Output<'_, T>, input: &Input<'_, T>) {
        let (n, before) = (input.n, input.before);
        let [gx, gy, gz] = &mut output.gradient;
        for row in 0..input.count {
            let span = row * n..(row + 1) * n;
            let begin = row * output.apart + before;
            let mut rows = OfRow {
                next: part_mut(output.next, begin..begin + n),
                mu: part_mut(output.mu, span.clone()),
                gradient: [part_mut(gx, span.clone()), part_mut(gy, span.clone()), part_mut(gz, span)],
            };
            let i = transposed_from::<T, V>(0, row, &mut rows, input);
            transposed_from::<T, T>(i, row, &mut rows, input);
        }
    }
}

/// One row to write.
struct OfRow<'t, T> {
    next: &'t mut [T],
    mu: &'t mut [T],
    gradient: VectorMut<'t, T>,
}

/// The rows along one axis: of z and y at offsets -2, -1, 1 and 2 of the cells, of faces at -1, 0, 1 and 2.
struct Along<'a, T> {
    z: [&'a [T]; 4],
    y: [&'a [T]; 4],
    faces: [&'a [T]; 4],
}

impl<'a, T: Real> Along<'a, T> {
    #[inline(always)]
    fn x(row: usize, n: usize, input: &Input<'a, T>) -> Self {
        let (z, y) = (input.z.own(row, n + 4), input.y.own(row, n + 4));
        let faces = input.faces.own(row, n + 3);
        Self {
            z: [&z[..n], &z[1..], &z[3..], &z[4..]],
            y: [&y[..n], &y[1..], &y[3..], &y[4..]],
            faces: [&faces[..n], &faces[1..], &faces[2..], &faces[3..]],
        }
    }

    #[inline(always)]
    fn across(axis: usize, row: usize, n: usize, input: &Input<'a, T>) -> Self {
        Self {
            z: input.z.along(axis, row, n),
            y: input.y.along(axis, row, n),
            faces: input.faces.along(axis, row, n),
        }
    }

    /// What the axis brings cells at `i`, and the gradient at their low faces. `here` is z and y there; s = tau / h, and the gradient
    /// takes share times that.
    #[inline(always)]
    fn add<V: simd::Vector<Elem = T>>(
        &self,
        i: usize,
        here: [V; 2],
        gradient: &mut [T],
        [s, of_gradient]: [V; 2],
        numbers: Numbers<V>,
    ) -> V {
        let (z, y) = (around(&self.z, i, here[0]), around(&self.y, i, here[1]));
        let [before, low, high, after] = &self.faces;
        let faces = [V::at(before, i), V::at(low, i), V::at(high, i), V::at(after, i)];
        let rho_f = numbers.by_velocity([y[0], y[1], y[2], y[3]], faces[1]);
        (V::at(gradient, i) + of_gradient * rho_f * (z[2] - z[1])).put(gradient, i);
        s * numbers.outflow(y, z, faces)
    }
}

/// Values at offsets -2 .. 2 of cells at `i`, `c` being those in the middle. No closure: it would not be compiled for the vectors.
#[inline(always)]
fn around<T: Real, V: simd::Vector<Elem = T>>(rows: &[&[T]; 4], i: usize, c: V) -> [V; 5] {
    [
        V::at(rows[0], i),
        V::at(rows[1], i),
        c,
        V::at(rows[2], i),
        V::at(rows[3], i),
    ]
}

/// The kernel of [`transposed`] from cell `i` as far as whole vectors go; returns the first cell that is left.
#[inline(always)]
fn transposed_from<T: Real, V: simd::Vector<Elem = T>>(
    mut i: usize,
    row: usize,
    rows: &mut OfRow<'_, T>,
    input: &Input<'_, T>,
) -> usize {
    let (n, last) = (input.n, input.scales.len() - 1);
    let [gx, gy, gz] = &mut rows.gradient;
    let (gx, gy) = (&mut gx[..n], &mut gy[..n]);
    let gz = if last > 1 { &mut gz[..n] } else { &mut [][..] };
    let (cells, rho) = (input.z.own(row, n + 4), input.y.own(row, n + 4));
    let (x, y) = (Along::x(row, n, input), Along::across(1, row, n, input));
    let z = Along::across(last, row, n, input);
    let numbers = Numbers::<V>::new();
    let share = V::splat(input.share);
    let (keep, take) = (V::splat(input.of_mu[0]), V::splat(input.of_mu[1]));
    let (x_scale, y_scale) = (V::splat(input.scales[0]), V::splat(input.scales[1]));
    let z_scale = V::splat(input.scales[last]);
    let (scale_x, scale_y) = ([x_scale, share * x_scale], [y_scale, share * y_scale]);
    let scale_z = [z_scale, share * z_scale];
    while i + V::LANES <= n {
        let here = [V::at(cells, i + 2), V::at(rho, i + 2)];
        let mut sum = here[0];
        if !input.still {
            sum = sum + x.add(i, here, gx, scale_x, numbers);
            sum = sum + y.add(i, here, gy, scale_y, numbers);
            if last > 1 {
                sum = sum + z.add(i, here, gz, scale_z, numbers);
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
