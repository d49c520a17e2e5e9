//! Axes that are too long for matrices: their coefficients in the eigenvectors by a [Fourier transform](super::fourier), [`COLUMNS`] columns or
//! rows at a time. Two of them, a and b, are one complex column a + i b (the tables' formulas are in [`Fourier`]).

use super::fourier::{COMPLEX, transform};
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

/// Cells of a row that are copied at a time, a line of the caches or two.
const TILE: usize = 16;

/// From the values of an axis but the first to its coefficients, in place, of at most [`COLUMNS`] columns.
pub fn analyse_columns<T: Real>(fourier: &Fourier<'_, T>, mut slab: Panel<'_, T>, scratch: &mut [T]) {
    let (from, to) = halves(fourier, scratch);
    let count = slab.count();
    from.fill(T::ZERO);
    for i in 0..slab.rows() {
        line_mut(from, fourier.sorted(i))[..count].copy_from_slice(slab.row(i));
    }
    let (found, coefficients) = transform(fourier.roots, from, to);
    separate(fourier, found, coefficients);
    for i in 0..slab.rows() {
        slab.row_mut(i).copy_from_slice(&line(coefficients, i)[..count]);
    }
}

/// The inverse of [`analyse_columns`].
pub fn synthesise_columns<T: Real>(fourier: &Fourier<'_, T>, mut slab: Panel<'_, T>, scratch: &mut [T]) {
    let (from, to) = halves(fourier, scratch);
    let count = slab.count();
    from.fill(T::ZERO);
    for i in 0..slab.rows() {
        line_mut(from, i)[..count].copy_from_slice(slab.row(i));
    }
    unite(fourier, from, to);
    let (found, _) = transform(fourier.roots, to, from);
    for i in 0..slab.rows() {
        let (imaginary, real) = line(found, fourier.sorted(i)).split_at(COMPLEX);
        let values = real.iter().chain(imaginary);
        let row = slab.row_mut(i).iter_mut();
        row.zip(values).for_each(|(out, &value)| *out = value);
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
    from.fill(T::ZERO);
    rows_to_lines(n, rows, from, |i| fourier.sorted(i));
    let (found, coefficients) = transform(fourier.roots, from, to);
    separate(fourier, found, coefficients);
    lines_to_rows(n, coefficients, &mut found[..rows.len()], |i| i, |row| row);
    let pairs = found.chunks_exact(n).zip(coefficients.chunks_exact_mut(n));
    for (row, (old, new)) in pairs.enumerate().take(rows.len() / n) {
        symbol(row, 0..n, old, new);
    }
    found.fill(T::ZERO);
    rows_to_lines(n, &coefficients[..rows.len()], found, |i| i);
    unite(fourier, found, coefficients);
    let (values, _) = transform(fourier.roots, coefficients, found);
    let swapped = |row: usize| (row + COMPLEX) % COLUMNS;
    lines_to_rows(n, values, rows, |i| fourier.sorted(i), swapped);
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

/// Cell i of each row to line `place(i)`.
fn rows_to_lines<T: Real>(n: usize, rows: &[T], lines: &mut [T], place: impl Fn(usize) -> usize) {
    for start in (0..n).step_by(TILE) {
        for (column, row) in rows.chunks_exact(n).enumerate() {
            for (i, &value) in (start..).zip(row[start..].iter().take(TILE)) {
                lines[place(i) * COLUMNS + column] = value;
            }
        }
    }
}

/// Column `column(row)` of line `place(i)` to cell i of each row.
fn lines_to_rows<T: Real>(
    n: usize,
    lines: &[T],
    rows: &mut [T],
    place: impl Fn(usize) -> usize,
    column: impl Fn(usize) -> usize,
) {
    for start in (0..n).step_by(TILE) {
        for (row, values) in rows.chunks_exact_mut(n).enumerate() {
            for (i, value) in (start..).zip(values[start..].iter_mut().take(TILE)) {
                *value = lines[place(i) * COLUMNS + column(row)];
            }
        }
    }
}

/// The coefficients of both columns from their common Fourier transform.
fn separate<T: Real>(fourier: &Fourier<'_, T>, found: &[T], coefficients: &mut [T]) {
    let n = fourier.cells();
    for k in fourier.pairs() {
        let ([low, high], [cosine, sine]) = (fourier.places(k), fourier.turn(k));
        let (at, opposite) = (line(found, k), line(found, n - k));
        part(at, opposite, cosine, sine, line_mut(coefficients, low));
        part(at, opposite, sine, -cosine, line_mut(coefficients, high));
    }
    let scale = T::from_f64(1.0 / libm::sqrt(n as f64));
    for (k, place) in fourier.alone() {
        for (out, &value) in line_mut(coefficients, place).iter_mut().zip(line(found, k)) {
            *out = scale * value;
        }
    }
}

/// What the inverse Fourier transform takes, with real and imaginary parts exchanged, by which it becomes a transform like the other.
fn unite<T: Real>(fourier: &Fourier<'_, T>, coefficients: &[T], wanted: &mut [T]) {
    let n = fourier.cells();
    for k in fourier.pairs() {
        let (places, [cosine, sine]) = (fourier.places(k), fourier.turn(k));
        let [low, high] = places.map(|place| line(coefficients, place));
        join(low, high, cosine, sine, line_mut(wanted, k));
        join(high, low, sine, cosine, line_mut(wanted, n - k));
    }
    let scale = T::from_f64(1.0 / libm::sqrt(n as f64));
    for (k, place) in fourier.alone() {
        let (real, imaginary) = line(coefficients, place).split_at(COMPLEX);
        let values = imaginary.iter().chain(real);
        for (out, &value) in line_mut(wanted, k).iter_mut().zip(values) {
            *out = scale * value;
        }
    }
}

vectorised! {
    /// With Z_k = p + i q and Z_(n-k) = r + i s: c (p + r) + d (q - s) for column a, c (q + s) - d (p - r) for b.
    fn part[T, V](at: &[T], opposite: &[T], c: T, d: T, out: &mut [T]) {
        let [c, d] = [V::splat(c), V::splat(d)];
        for lane in (0..COMPLEX).step_by(<V as Vector>::LANES) {
            let [p, q, r, s] = [V::at(at, lane), V::at(at, COMPLEX + lane), V::at(opposite, lane), V::at(opposite, COMPLEX + lane)];
            (c * (p + r) + d * (q - s)).put(out, lane);
            (c * (q + s) - d * (p - r)).put(out, COMPLEX + lane);
        }
    }
}

vectorised! {
    /// With the coefficients A, A' of column a and B, B' of b: the real part c A + d A' - (d B - c B') of Z_k, and its imaginary part
    /// d A - c A' + (c B + d B') before it.
    fn join[T, V](low: &[T], high: &[T], c: T, d: T, out: &mut [T]) {
        let [c, d] = [V::splat(c), V::splat(d)];
        for lane in (0..COMPLEX).step_by(<V as Vector>::LANES) {
            let [a, b] = [V::at(low, lane), V::at(low, COMPLEX + lane)];
            let [aa, bb] = [V::at(high, lane), V::at(high, COMPLEX + lane)];
            (d * a - c * aa + (c * b + d * bb)).put(out, lane);
            (c * a + d * aa - (d * b - c * bb)).put(out, COMPLEX + lane);
        }
    }
}
