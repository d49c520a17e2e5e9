//! The Taylor series of exp(tau L(v)) and its adjoint, term by term.

use super::MAX_TERMS;
use super::flux::{AllCells, Around, Cells, Faces, HALO, SCRATCH_ROWS, cells, faces};
use crate::exec::{Exec, RowBuffers, for_rows};
use crate::field::{Vector, VectorMut, rows};
use crate::grid::Grid;
use crate::real::Real;
use crate::simd::{self, vectorised};

/// Numbers of a term below this part of the cut are set to 0. Far from the smoke they would otherwise fade into denormal
/// numbers, on which processors are a hundred times slower.
const NEGLIGIBLE: f64 = 1e-12;

/// One sub-step.
pub struct Series<'a, T> {
    /// The grid.
    pub grid: &'a Grid,
    /// Velocity at faces.
    pub velocity: Vector<'a, T>,
    /// See [`super::flux::weights`].
    pub weights: [T; 3],
    /// Length of the sub-step.
    pub tau: f64,
    /// Terms are summed until max |term| is below this.
    pub cut: f64,
}

/// `total` += all terms after the first, which `terms` holds at 0; term k is left at `k stride`. Returns the last k. `sums` holds
/// two numbers a row.
pub fn sum<T: Real>(exec: &dyn Exec, series: &Series<'_, T>, terms: &mut [T], stride: usize, total: &mut [T], scratch: &mut [T], sums: &mut [f64]) -> usize {
    let grid = series.grid;
    let (n, len) = (grid.n[0], grid.cells());
    let (mut largest, mut previous) = sums[..2 * grid.rows()].split_at_mut(grid.rows());
    previous.fill(1.0);
    let negligible = T::from_f64(series.cut * NEGLIGIBLE);
    for k in 1..MAX_TERMS {
        let (before, after) = terms.split_at_mut(k * stride);
        let (from, to) = (&before[(k - 1) * stride..][..len], &mut after[..len]);
        let scales = grid.h.map(|h| T::from_f64(series.tau / k as f64 / h));
        for_rows(exec, grid.rows(), 0..grid.rows(), RowBuffers { fields: [to, &mut *total], sums: &mut *largest, scratch: &mut *scratch }, |task| {
            let [to, total] = task.fields;
            let around = Around::new(grid, task.row);
            if !around.any(|row| previous[row] != 0.0) {
                to.fill(T::ZERO);
                task.sums[0] = 0.0;
                return;
            }
            let Halos { cells: halo, faces: faces_halo, zeros, .. } = Halos::new(n, task.scratch);
            let from = cells(grid, &around, from, halo);
            let faces = faces(grid, &around, series.velocity, faces_halo, zeros);
            task.sums[0] = term(to, total, &from, &faces, series.weights, &scales[..grid.dims], negligible);
        });
        if !(rows::largest(largest.iter().copied()) >= series.cut) {
            return k;
        }
        core::mem::swap(&mut largest, &mut previous);
    }
    MAX_TERMS - 1
}

/// Rows of scratch of one task.
struct Halos<'a, T> {
    cells: &'a mut [T],
    second: &'a mut [T],
    faces: &'a mut [T],
    zeros: &'a [T],
}

impl<'a, T: Real> Halos<'a, T> {
    fn new(n: usize, scratch: &'a mut [T]) -> Self {
        debug_assert!(scratch.len() >= SCRATCH_ROWS * (n + HALO));
        let (cells, rest) = scratch.split_at_mut(n + HALO);
        let (second, rest) = rest.split_at_mut(n + HALO);
        let (faces, zeros) = rest.split_at_mut(n + HALO);
        let zeros = &mut zeros[..n];
        zeros.fill(T::ZERO);
        Self { cells, second, faces, zeros }
    }
}

/// Applies `$kernel` to whole vectors of `0..$n` and to the rest one by one.
macro_rules! along_row {
    ($n:expr, $v:ident, $t:ident, $kernel:ident($($arg:expr),*)) => {{
        let mut i = 0;
        while i + <$v as simd::Vector>::LANES <= $n {
            $kernel::<$t, $v>(i, $($arg),*);
            i += <$v as simd::Vector>::LANES;
        }
        while i < $n {
            $kernel::<$t, $t>(i, $($arg),*);
            i += 1;
        }
    }};
}

vectorised! {
    /// One row of `to = s L from`, what is negligible set to 0, and `total += to`; max |to|, NaN when any number is not finite.
    fn term[T, V](to: &mut [T], total: &mut [T], from: &AllCells<'_, T>, faces: &[Faces<'_, T>; 3], w: [T; 3], scales: &[T], negligible: T) -> f64 {
        let mut extremes = [V::splat(T::ZERO); 2];
        let mut rest = [T::ZERO; 2];
        let n = to.len();
        let whole = n - n % <V as simd::Vector>::LANES;
        for i in (0..whole).step_by(<V as simd::Vector>::LANES) {
            term_at::<T, V>(i, to, total, from, faces, w, scales, negligible, &mut extremes);
        }
        for i in whole..n {
            term_at::<T, T>(i, to, total, from, faces, w, scales, negligible, &mut rest);
        }
        let mut lanes = [[T::ZERO; 16]; 2];
        extremes[0].store(&mut lanes[0]);
        extremes[1].store(&mut lanes[1]);
        let largest = lanes[0].iter().fold(rest[0], |all, &x| x.max(all));
        let poison = lanes[1].iter().fold(rest[1], |all, &x| all + x);
        if poison.is_finite() { largest.to_f64() } else { f64::NAN }
    }
}

/// The numbers at `i` of the five rows along an axis.
#[inline(always)]
fn five_at<T: Real, V: simd::Vector<Elem = T>>(i: usize, rows: &Cells<'_, T>) -> (V, V, V, V, V) {
    (V::load(&rows[0][i..]), V::load(&rows[1][i..]), V::load(&rows[2][i..]), V::load(&rows[3][i..]), V::load(&rows[4][i..]))
}

#[inline(always)]
fn term_at<T: Real, V: simd::Vector<Elem = T>>(
    i: usize,
    to: &mut [T],
    total: &mut [T],
    from: &AllCells<'_, T>,
    faces: &[Faces<'_, T>; 3],
    w: [T; 3],
    scales: &[T],
    negligible: T,
    extremes: &mut [V; 2],
) {
    let zero = V::splat(T::ZERO);
    let (near, upstream, next) = (V::splat(w[0]), V::splat(w[1]), V::splat(w[2]));
    let mut sum = zero;
    for (axis, &scale) in scales.iter().enumerate() {
        let (a, b, c, d, e) = five_at(i, &from[axis]);
        let (low, high) = (V::load(&faces[axis][1][i..]), V::load(&faces[axis][2][i..]));
        let below = low * (near * low.select(c, b) + upstream * low.select(b, c) - next * low.select(a, d));
        let above = high * (near * high.select(d, c) + upstream * high.select(c, d) - next * high.select(b, e));
        sum = sum + V::splat(scale) * (below - above);
    }
    let size = sum.max(-sum);
    extremes[0] = size.max(extremes[0]);
    extremes[1] = extremes[1] + sum * zero;
    let sum = (V::splat(negligible) - size).select(zero, sum);
    sum.store(&mut to[i..]);
    (V::load(&total[i..]) + sum).store(&mut total[i..]);
}

/// What the backward sweep of a sub-step changes.
pub struct Backward<'a, T> {
    /// mu, before and after.
    pub mu: &'a mut [T],
    /// Two fields of cells.
    pub work: [&'a mut [T]; 2],
    /// The velocity gradient, added to.
    pub gradient: VectorMut<'a, T>,
}

/// The adjoint of [`sum`] with `last` terms: `mu` <- z_0 where z_last = mu, z_{k-1} = mu + (tau / k) L^T z_k, and
/// `gradient` += (tau / k) rho_f(y_{k-1}) (z_k[R] - z_k[L]) / h at every face.
pub fn adjoint<T: Real>(exec: &dyn Exec, series: &Series<'_, T>, terms: &[T], stride: usize, last: usize, backward: Backward<'_, T>, scratch: &mut [T]) {
    let grid = series.grid;
    let (n, len) = (grid.n[0], grid.cells());
    let Backward { mu, work: [mut z, mut next], mut gradient } = backward;
    z.copy_from_slice(mu);
    for k in (1..=last).rev() {
        let scales = grid.h.map(|h| T::from_f64(series.tau / k as f64 / h));
        let (y, z_now, mu_now) = (&terms[(k - 1) * stride..][..len], &*z, &*mu);
        let [g0, g1, g2] = gradient.each_mut().map(|g| &mut **g);
        for_rows(exec, grid.rows(), 0..grid.rows(), RowBuffers { fields: [&mut *next, g0, g1, g2], sums: &mut [], scratch: &mut *scratch }, |task| {
            let ([next, g0, g1, g2], row) = (task.fields, task.row);
            let halos = Halos::new(n, task.scratch);
            let around = Around::new(grid, row);
            let faces = faces(grid, &around, series.velocity, halos.faces, halos.zeros);
            let z = cells(grid, &around, z_now, halos.cells);
            let y = cells(grid, &around, y, halos.second);
            next.copy_from_slice(&mu_now[row * n..(row + 1) * n]);
            transposed(next, &z, &faces, series.weights, &scales[..grid.dims]);
            fold_at_walls(grid, &around, next, &z, &faces, series.weights[2], scales);
            for (axis, gradient) in [g0, g1, g2].into_iter().enumerate().take(grid.dims) {
                face_gradient(gradient, &y[axis], &z[axis], faces[axis][1], series.weights, scales[axis]);
            }
        });
        core::mem::swap(&mut z, &mut next);
    }
    mu.copy_from_slice(z);
}

vectorised! {
    /// One row of `out += s L^T z`, walls left out: a cell is R of its low face, L of its high face, and the next one
    /// upstream of the faces beyond.
    fn transposed[T, V](out: &mut [T], z: &AllCells<'_, T>, faces: &[Faces<'_, T>; 3], w: [T; 3], scales: &[T]) {
        along_row!(out.len(), V, T, transposed_at(out, z, faces, w, scales));
    }
}

#[inline(always)]
fn transposed_at<T: Real, V: simd::Vector<Elem = T>>(i: usize, out: &mut [T], z: &AllCells<'_, T>, faces: &[Faces<'_, T>; 3], w: [T; 3], scales: &[T]) {
    let zero = V::splat(T::ZERO);
    let (near, upstream, next) = (V::splat(w[0]), V::splat(w[1]), V::splat(w[2]));
    let mut sum = V::load(&out[i..]);
    for (axis, &scale) in scales.iter().enumerate() {
        let (a, b, c, d, e) = five_at::<T, V>(i, &z[axis]);
        let (before, low) = (V::load(&faces[axis][0][i..]), V::load(&faces[axis][1][i..]));
        let (high, after) = (V::load(&faces[axis][2][i..]), V::load(&faces[axis][3][i..]));
        let at_low = low * low.select(near, upstream) * (c - b);
        let at_high = high * high.select(upstream, near) * (d - c);
        let beyond = after.max(zero) * (e - d) + before.min(zero) * (b - a);
        sum = sum + V::splat(scale) * (at_low + at_high - next * beyond);
    }
    sum.store(&mut out[i..]);
}

/// At a wall the last cell stands in for the missing one next upstream, and so takes its share too.
fn fold_at_walls<T: Real>(grid: &Grid, around: &Around<'_>, out: &mut [T], z: &AllCells<'_, T>, faces: &[Faces<'_, T>; 3], w: T, scales: [T; 3]) {
    for axis in (0..grid.dims).filter(|&axis| !grid.periodic[axis]) {
        let n = out.len();
        let all = if axis == 0 { [0..1, n - 1..n] } else { [0..n, 0..n] };
        let here = |side: isize| axis == 0 || around.beside(axis, side).is_none();
        let ([_, b, c, d, _], [_, low, high, _]) = (z[axis], faces[axis]);
        if here(-1) {
            for i in all[0].clone() {
                out[i] -= scales[axis] * w * high[i].max(T::ZERO) * (d[i] - c[i]);
            }
        }
        if here(1) {
            for i in all[1].clone() {
                out[i] -= scales[axis] * w * low[i].min(T::ZERO) * (c[i] - b[i]);
            }
        }
    }
}

vectorised! {
    /// `out += s rho_f(y) (z[R] - z[L])` at the low faces of a row; where v is exactly 0, rho_f is the mean of both sides'.
    fn face_gradient[T, V](out: &mut [T], y: &Cells<'_, T>, z: &Cells<'_, T>, v: &[T], w: [T; 3], s: T) {
        along_row!(out.len(), V, T, face_gradient_at(out, y, z, v, w, s));
    }
}

#[inline(always)]
fn face_gradient_at<T: Real, V: simd::Vector<Elem = T>>(i: usize, out: &mut [T], y: &Cells<'_, T>, z: &Cells<'_, T>, v: &[T], w: [T; 3], s: T) {
    let (near, upstream, next) = (V::splat(w[0]), V::splat(w[1]), V::splat(w[2]));
    let (a, b, c, d, _) = five_at(i, y);
    let upward = near * c + upstream * b - next * a;
    let downward = near * b + upstream * c - next * d;
    let (v, half) = (V::load(&v[i..]), V::splat(T::HALF));
    let rho = v.select(upward, (-v).select(downward, half * (upward + downward)));
    let difference = V::load(&z[2][i..]) - V::load(&z[1][i..]);
    (V::load(&out[i..]) + V::splat(s) * rho * difference).store(&mut out[i..]);
}
