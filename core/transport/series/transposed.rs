//! The kernel of the adjoint: L^T z, and the gradient by the velocity, at rows of a run.

use super::super::kernel::{Along, Layout, Read, around};
use crate::field::rows::{part, part_mut};
use crate::real::Real;
use crate::simd::{self, vectorised};

/// What the kernel reads.
pub struct Input<'a, T> {
    /// z_k, y_{k-1} and the velocities.
    pub read: Read<'a, T>,
    /// See [`super::weights`].
    pub weights: [T; 3],
    /// tau / (k h) of the grid's axes.
    pub scales: &'a [T],
}

vectorised! {
    /// Rows of `out = mu + (tau / k) L^T z`, or `out += (tau / k) L^T z` where `mu` is empty, without walls: a cell is R of its low face, L of
    /// its high face, and the next one upstream of the faces beyond. And of `gradient += (tau / k) rho_f(y) (z[R] - z[L]) / h` at the cells'
    /// low faces; where v is exactly 0, rho_f is the mean of both sides'.
    pub fn transposed[T, V](out: &mut [T], mu: &[T], gradient: &mut [&mut [T]; 3], layout: Layout, input: &Input<'_, T>) {
        let Layout { n, apart, before } = layout;
        let [gx, gy, gz] = gradient;
        for (row, out) in out.chunks_exact_mut(apart.max(1)).enumerate() {
            let out = part_mut(out, before..before + n);
            let span = row * n..(row + 1) * n;
            let mu = part(mu, span.clone());
            let gz = part_mut(gz, span.clone());
            let mut gradient = [part_mut(gx, span.clone()), part_mut(gy, span), gz];
            let i = transposed_from::<T, V>(0, row, out, mu, &mut gradient, input);
            transposed_from::<T, T>(i, row, out, mu, &mut gradient, input);
        }
    }
}

/// The share of cell c, among a b c d e, in the changes that flow through the faces around it: those before, below, above and after.
#[inline(always)]
fn outflow<T: Real, V: simd::Vector<Elem = T>>(
    [a, b, c, d, e]: [V; 5],
    faces: [V; 4],
    [near, upstream, next]: [V; 3],
    zero: V,
) -> V {
    let [before, low, high, after] = faces;
    let at_low = low * low.select(near, upstream) * (c - b);
    let at_high = high * high.select(upstream, near) * (d - c);
    let beyond = after.max(zero) * (e - d) + before.min(zero) * (b - a);
    at_low + at_high - next * beyond
}

/// rho_f at a face with the cells a b | c d around it, through which `v` flows.
#[inline(always)]
fn at_face<T: Real, V: simd::Vector<Elem = T>>(
    [a, b, c, d]: [V; 4],
    v: V,
    [near, upstream, next]: [V; 3],
) -> V {
    let upward = near * c + upstream * b - next * a;
    let downward = near * b + upstream * c - next * d;
    v.select(
        upward,
        (-v).select(downward, V::splat(T::HALF) * (upward + downward)),
    )
}

/// What an axis brings cells at `i`, `s` times [`outflow`], and the gradient at their low faces. `c` and `y_c` are z and y there.
#[inline(always)]
fn add<T: Real, V: simd::Vector<Elem = T>>(
    along: &Along<'_, T>,
    i: usize,
    (c, y_c): (V, V),
    gradient: &mut [T],
    s: V,
    w: [V; 3],
    zero: V,
) -> V {
    let (z, through) = (around(&along.z, i, c), along.through(i));
    let [a, b, d, _] = along.y;
    let y = [V::at(a, i), V::at(b, i), y_c, V::at(d, i)];
    let rho_f = at_face(y, through[1], w);
    (V::at(gradient, i) + s * rho_f * (c - z[1])).put(gradient, i);
    s * outflow(z, through, w, zero)
}

/// The kernel of [`transposed`] from cell `i` as far as whole vectors go; returns the first cell that is left.
#[inline(always)]
fn transposed_from<T: Real, V: simd::Vector<Elem = T>>(
    mut i: usize,
    row: usize,
    out: &mut [T],
    mu: &[T],
    [gx, gy, gz]: &mut [&mut [T]; 3],
    input: &Input<'_, T>,
) -> usize {
    let n = out.len();
    let last = input.scales.len() - 1;
    let alone = mu.is_empty();
    let mu = if alone { mu } else { &mu[..n] };
    let (gx, gy) = (&mut gx[..n], &mut gy[..n]);
    let gz = if last > 1 { &mut gz[..n] } else { &mut [][..] };
    let read = &input.read;
    let (cells, rho) = (read.z.own(row, n + 4), read.y.own(row, n + 4));
    let x = Along::x(row, n, read);
    let y = Along::across(1, row, n, read);
    let z = Along::across(last, row, n, read);
    let zero = V::splat(T::ZERO);
    let [w0, w1, w2] = input.weights;
    let w = [V::splat(w0), V::splat(w1), V::splat(w2)];
    let (scale_x, scale_y) = (V::splat(input.scales[0]), V::splat(input.scales[1]));
    let scale_z = V::splat(input.scales[last]);
    while i + V::LANES <= n {
        let here = (V::at(cells, i + 2), V::at(rho, i + 2));
        let mut sum = if alone { V::at(out, i) } else { V::at(mu, i) };
        sum = sum + add(&x, i, here, gx, scale_x, w, zero);
        sum = sum + add(&y, i, here, gy, scale_y, w, zero);
        if last > 1 {
            sum = sum + add(&z, i, here, gz, scale_z, w, zero);
        }
        sum.put(out, i);
        i += V::LANES;
    }
    i
}
