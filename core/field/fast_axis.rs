//! Axes with a fast transform: their coefficients in the eigenvectors by a [Fourier transform](super::fourier), [`COLUMNS`] columns or
//! rows at a time. Two of them, a and b, are one complex column a + i b (the tables' formulas are in [`Fourier`]).

use super::fourier::{COMPLEX, transform};
use super::lines::{lines_to_rows, place, rows_to_lines};
use crate::exec::Panel;
use crate::grid::fourier::Fourier;
use crate::grid::spectrum::COLUMNS;
use crate::real::Real;
use crate::simd::{Vector, vectorised};
use core::ops::Range;

/// The scratch of a transform along an axis of `n` cells, in elements.
#[must_use]
pub const fn scratch_len(n: usize) -> usize {
    2 * n * COLUMNS
}

/// From the values of an axis but the first to its coefficients, in place, of at most [`COLUMNS`] columns.
pub fn analyse_columns<T: Real>(fourier: &Fourier<'_, T>, mut slab: Panel<'_, T>, scratch: &mut [T]) {
    let (from, to) = halves(fourier, scratch);
    let count = slab.count();
    columns_to_lines(&slab, from, Some(fourier));
    let (found, coefficients) = transform(fourier.roots, from, to);
    if count == COLUMNS {
        return separate(fourier, found, &mut slab);
    }
    separate(fourier, found, &mut Panel::whole(coefficients, COLUMNS));
    for i in 0..slab.rows() {
        slab.row_mut(i).copy_from_slice(&line(coefficients, i)[..count]);
    }
}

/// The inverse of [`analyse_columns`].
pub fn synthesise_columns<T: Real>(fourier: &Fourier<'_, T>, mut slab: Panel<'_, T>, scratch: &mut [T]) {
    let (from, to) = halves(fourier, scratch);
    let count = slab.count();
    if count == COLUMNS {
        unite(fourier, &slab, to);
    } else {
        columns_to_lines(&slab, from, None);
        unite(fourier, &Panel::whole(from, COLUMNS), to);
    }
    let (found, _) = transform(fourier.roots, to, from);
    for i in 0..slab.rows() {
        let (imaginary, real) = line(found, fourier.sorted(i)).split_at(COMPLEX);
        let row = slab.row_mut(i);
        let (low, high) = row.split_at_mut(count.min(COMPLEX));
        copy_line::<T, COMPLEX>(real, low);
        copy_line::<T, COMPLEX>(imaginary, high);
    }
}

/// Transforms along the first axis, of at most [`COLUMNS`] rows, lets `symbol` change the coefficients, and transforms back.
pub fn along_rows<T: Real>(
    fourier: &Fourier<'_, T>,
    rows: &mut [T],
    scratch: &mut [T],
    symbol: impl Fn(usize, Range<usize>, &[T], &mut [T]),
) {
    let n = fourier.cells();
    let (from, to) = halves(fourier, scratch);
    rows_to_lines(n, rows, from, Some(fourier));
    let (found, coefficients) = transform(fourier.roots, from, to);
    separate(fourier, found, &mut Panel::whole(coefficients, COLUMNS));
    lines_to_rows(n, coefficients, &mut found[..rows.len()], None, 0);
    let pairs = found.chunks_exact(n).zip(coefficients.chunks_exact_mut(n));
    for (row, (old, new)) in pairs.enumerate().take(rows.len() / n) {
        symbol(row, 0..n, old, new);
    }
    rows_to_lines(n, &coefficients[..rows.len()], found, None);
    unite(fourier, &Panel::whole(found, COLUMNS), coefficients);
    let (values, _) = transform(fourier.roots, coefficients, found);
    lines_to_rows(n, values, rows, Some(fourier), COMPLEX);
}

/// The two panels of scratch.
fn halves<'s, T: Real>(fourier: &Fourier<'_, T>, scratch: &'s mut [T]) -> (&'s mut [T], &'s mut [T]) {
    let len = fourier.cells() * COLUMNS;
    let (from, to) = scratch.split_at_mut(len);
    (from, &mut to[..len])
}

/// Line `i` of a panel.
fn line<T>(panel: &[T], i: usize) -> &[T] {
    &panel[i * COLUMNS..][..COLUMNS]
}

/// Line `i` of a panel, to write.
fn line_mut<T>(panel: &mut [T], i: usize) -> &mut [T] {
    &mut panel[i * COLUMNS..][..COLUMNS]
}

/// Copies what of `from` has a place in `to`; whole lines of N numbers without a call.
#[inline(always)]
fn copy_line<T: Copy, const N: usize>(from: &[T], to: &mut [T]) {
    match (from.first_chunk::<N>(), to.first_chunk_mut::<N>()) {
        (Some(from), Some(to)) => *to = *from,
        _ => to.iter_mut().zip(from).for_each(|(to, &from)| *to = from),
    }
}

/// Cell i of each column to line i, or where the tables sort it; what has no column is 0.
fn columns_to_lines<T: Real>(slab: &Panel<'_, T>, lines: &mut [T], sorted: Option<&Fourier<'_, T>>) {
    let count = slab.count();
    if count < COLUMNS {
        lines.fill(T::ZERO);
    }
    for i in 0..slab.rows() {
        copy_line::<T, COLUMNS>(slab.row(i), &mut lines[place(sorted, i)..][..count]);
    }
}

vectorised! {
    /// The coefficients of both columns from their common Fourier transform.
    fn separate[T, V](fourier: &Fourier<'_, T>, found: &[T], coefficients: &mut Panel<'_, T>) {
        let n = fourier.cells();
        for k in fourier.pairs() {
            let ([low, high], [cosine, sine]) = (fourier.places(k), fourier.turn(k));
            let (at, opposite) = (line(found, k), line(found, n - k));
            part::<T, V>(at, opposite, [cosine, sine], coefficients.row_mut(low));
            part::<T, V>(at, opposite, [sine, -cosine], coefficients.row_mut(high));
        }
        let scale = T::from_f64(1.0 / libm::sqrt(n as f64));
        for (k, place) in fourier.alone() {
            for (out, &value) in coefficients.row_mut(place).iter_mut().zip(line(found, k)) {
                *out = scale * value;
            }
        }
    }
}

vectorised! {
    /// What the inverse Fourier transform takes, with real and imaginary parts exchanged, by which it becomes a transform like the other.
    fn unite[T, V](fourier: &Fourier<'_, T>, coefficients: &Panel<'_, T>, wanted: &mut [T]) {
        let n = fourier.cells();
        for k in fourier.pairs() {
            let (places, [cosine, sine]) = (fourier.places(k), fourier.turn(k));
            let [low, high] = [coefficients.row(places[0]), coefficients.row(places[1])];
            join::<T, V>(low, high, [cosine, sine], line_mut(wanted, k));
            join::<T, V>(high, low, [sine, cosine], line_mut(wanted, n - k));
        }
        let scale = T::from_f64(1.0 / libm::sqrt(n as f64));
        for (k, place) in fourier.alone() {
            let (real, imaginary) = coefficients.row(place).split_at(COMPLEX);
            let values = imaginary.iter().chain(real);
            for (out, &value) in line_mut(wanted, k).iter_mut().zip(values) {
                *out = scale * value;
            }
        }
    }
}

/// With Z_k = p + i q and Z_(n-k) = r + i s: c (p + r) + d (q - s) for column a, c (q + s) - d (p - r) for b.
#[inline(always)]
fn part<T: Real, V: Vector<Elem = T>>(at: &[T], opposite: &[T], [c, d]: [T; 2], out: &mut [T]) {
    let [c, d] = [V::splat(c), V::splat(d)];
    for lane in (0..COMPLEX).step_by(V::LANES) {
        let [p, q] = [V::at(at, lane), V::at(at, COMPLEX + lane)];
        let [r, s] = [V::at(opposite, lane), V::at(opposite, COMPLEX + lane)];
        (c * (p + r) + d * (q - s)).put(out, lane);
        (c * (q + s) - d * (p - r)).put(out, COMPLEX + lane);
    }
}

/// With the coefficients A, A' of column a and B, B' of b: the real part c A + d A' - (d B - c B') of Z_k, and its imaginary part
/// d A - c A' + (c B + d B') before it.
#[inline(always)]
fn join<T: Real, V: Vector<Elem = T>>(low: &[T], high: &[T], [c, d]: [T; 2], out: &mut [T]) {
    let [c, d] = [V::splat(c), V::splat(d)];
    for lane in (0..COMPLEX).step_by(V::LANES) {
        let [a, b] = [V::at(low, lane), V::at(low, COMPLEX + lane)];
        let [aa, bb] = [V::at(high, lane), V::at(high, COMPLEX + lane)];
        (d * a - c * aa + (c * b + d * bb)).put(out, lane);
        (c * a + d * aa - (d * b - c * bb)).put(out, COMPLEX + lane);
    }
}
