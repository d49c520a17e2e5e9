//! Elementwise loops over rows of equal length, and shifts along x within the rows of a block.

use crate::real::Real;
use crate::simd::multiversion;
use core::ops::Range;

multiversion! {
    /// `out += x`.
    pub fn add[T: Real](out: &mut [T], x: &[T]) {
        for (o, &x) in out.iter_mut().zip(x) {
            *o += x;
        }
    }
}

multiversion! {
    /// `out *= x`.
    pub fn multiply[T: Real](out: &mut [T], x: &[T]) {
        for (o, &x) in out.iter_mut().zip(x) {
            *o = *o * x;
        }
    }
}

multiversion! {
    /// `out -= x`.
    pub fn sub[T: Real](out: &mut [T], x: &[T]) {
        for (o, &x) in out.iter_mut().zip(x) {
            *o -= x;
        }
    }
}

multiversion! {
    /// `out += s x`.
    pub fn add_scaled[T: Real](out: &mut [T], s: T, x: &[T]) {
        for (o, &x) in out.iter_mut().zip(x) {
            *o += s * x;
        }
    }
}

multiversion! {
    /// `out = s0 x0 + s1 x1 + s2 x2 + s3 x3`, from the left.
    pub fn sum_of_four[T: Real](out: &mut [T], s: [T; 4], x0: &[T], x1: &[T], x2: &[T], x3: &[T]) {
        for ((((o, &x0), &x1), &x2), &x3) in out.iter_mut().zip(x0).zip(x1).zip(x2).zip(x3) {
            *o = s[0] * x0 + s[1] * x1 + s[2] * x2 + s[3] * x3;
        }
    }
}

multiversion! {
    /// `out = s x`.
    pub fn scale[T: Real](out: &mut [T], s: T, x: &[T]) {
        for (o, &x) in out.iter_mut().zip(x) {
            *o = s * x;
        }
    }
}

multiversion! {
    /// `out += s (x - y)`.
    pub fn add_difference[T: Real](out: &mut [T], s: T, x: &[T], y: &[T]) {
        for ((o, &x), &y) in out.iter_mut().zip(x).zip(y) {
            *o += s * (x - y);
        }
    }
}

/// Lanes of the reductions: fixed, so that every instruction set adds in the same order.
pub const LANES: usize = 16;

multiversion! {
    /// max |x|, or NaN when any number is not finite (a plain maximum would swallow it).
    pub fn max_abs[T: Real](x: &[T]) -> f64 {
        let mut largest = [T::ZERO; LANES];
        let mut poison = [T::ZERO; LANES];
        let chunks = x.chunks_exact(LANES);
        for (l, &x) in chunks.remainder().iter().enumerate() {
            largest[l] = x.abs().max(largest[l]);
            poison[l] += x * T::ZERO;
        }
        for chunk in chunks {
            for l in 0..LANES {
                largest[l] = chunk[l].abs().max(largest[l]);
                poison[l] += chunk[l] * T::ZERO;
            }
        }
        largest_lane(largest, poison)
    }
}

/// The largest of the lanes, or NaN unless the sum of `poison`, numbers times 0, is finite.
#[inline(always)]
pub fn largest_lane<T: Real>(mut largest: [T; LANES], mut poison: [T; LANES]) -> f64 {
    let mut half = LANES;
    while half > 1 {
        half /= 2;
        for l in 0..half {
            largest[l] = largest[l + half].max(largest[l]);
            poison[l] += poison[l + half];
        }
    }
    if poison[0].is_finite() {
        largest[0].to_f64()
    } else {
        f64::NAN
    }
}

multiversion! {
    /// The sum of squares.
    pub fn sum_squares[T: Real](x: &[T]) -> f64 {
        let mut sums = [0.0; LANES];
        let chunks = x.chunks_exact(LANES);
        for (l, &x) in chunks.remainder().iter().enumerate() {
            sums[l] += x.to_f64() * x.to_f64();
        }
        for chunk in chunks {
            for l in 0..LANES {
                sums[l] += chunk[l].to_f64() * chunk[l].to_f64();
            }
        }
        sums.iter().sum()
    }
}

multiversion! {
    /// The sum of (x - y)^2.
    pub fn sum_square_gaps[T: Real](x: &[T], y: &[T]) -> f64 {
        let mut sums = [0.0; LANES];
        let (xs, ys) = (x.chunks_exact(LANES), y.chunks_exact(LANES));
        for (l, (&x, &y)) in xs.remainder().iter().zip(ys.remainder()).enumerate() {
            sums[l] += (x - y).to_f64() * (x - y).to_f64();
        }
        for (x, y) in xs.zip(ys) {
            for l in 0..LANES {
                sums[l] += (x[l] - y[l]).to_f64() * (x[l] - y[l]).to_f64();
            }
        }
        sums.iter().sum()
    }
}

/// The sum of products.
pub fn dot<T: Real>(x: &[T], y: &[T]) -> f64 {
    let mut lanes = [0.0; LANES];
    add_products(&mut lanes, x, y);
    lanes.iter().sum()
}

multiversion! {
    /// Adds products to lanes, number `i` to lane `i` modulo [`LANES`].
    pub fn add_products[T: Real](lanes: &mut [f64; LANES], x: &[T], y: &[T]) {
        let mut sums = *lanes;
        let (xs, ys) = (x.chunks_exact(LANES), y.chunks_exact(LANES));
        let rest = xs.remainder().iter().zip(ys.remainder());
        for (x, y) in xs.zip(ys) {
            for l in 0..LANES {
                sums[l] += x[l].to_f64() * y[l].to_f64();
            }
        }
        for (sum, (&x, &y)) in sums.iter_mut().zip(rest) {
            *sum += x.to_f64() * y.to_f64();
        }
        *lanes = sums;
    }
}

/// Numbers of a row that many fields are gone through together for, one field after the other: enough for each to be read as a stream,
/// and few enough to stay in the first cache. A multiple of [`LANES`].
pub const PIECE: usize = 512;

/// The pieces of a row of `len` numbers.
pub fn pieces(len: usize) -> impl Iterator<Item = Range<usize>> {
    (0..len)
        .step_by(PIECE)
        .map(move |start| start..(start + PIECE).min(len))
}

multiversion! {
    /// The sum.
    pub fn sum[T: Real](x: &[T]) -> f64 {
        let mut sums = [0.0; LANES];
        let chunks = x.chunks_exact(LANES);
        for (l, &x) in chunks.remainder().iter().enumerate() {
            sums[l] += x.to_f64();
        }
        for chunk in chunks {
            for l in 0..LANES {
                sums[l] += chunk[l].to_f64();
            }
        }
        sums.iter().sum()
    }
}

/// The largest of some maxima, NaN when any is.
pub fn largest(maxima: impl IntoIterator<Item = f64>) -> f64 {
    maxima.into_iter().fold(0.0, |all, x| {
        if all.is_nan() || x.is_nan() {
            f64::NAN
        } else {
            all.max(x)
        }
    })
}

/// `out[x] = row[x - 1]` in every row of `nx` numbers; the first is the last one on a periodic axis and 0 at a wall.
pub fn shift_low<T: Real>(out: &mut [T], row: &[T], nx: usize, periodic: bool) {
    let len = row.len();
    out[1..len].copy_from_slice(&row[..len - 1]);
    for start in (0..len).step_by(nx) {
        out[start] = if periodic { row[start + nx - 1] } else { T::ZERO };
    }
}

/// `out[x] = row[x + 1]` in every row of `nx` numbers; the last is the first one on a periodic axis and 0 at a wall.
pub fn shift_high<T: Real>(out: &mut [T], row: &[T], nx: usize, periodic: bool) {
    let len = row.len();
    out[..len - 1].copy_from_slice(&row[1..]);
    for start in (0..len).step_by(nx) {
        out[start + nx - 1] = if periodic { row[start] } else { T::ZERO };
    }
}

/// Sets the first number of every row of `nx` to 0: the wall face, or a plaquette on the wall.
pub fn clear_first<T: Real>(out: &mut [T], nx: usize) {
    for first in out.iter_mut().step_by(nx) {
        *first = T::ZERO;
    }
}

multiversion! {
    /// `out *= s`.
    pub fn scale_in_place[T: Real](out: &mut [T], s: T) {
        for o in out.iter_mut() {
            *o = *o * s;
        }
    }
}

multiversion! {
    /// `out = s out - x`.
    pub fn scale_and_sub[T: Real](out: &mut [T], s: T, x: &[T]) {
        for (o, &x) in out.iter_mut().zip(x) {
            *o = s * *o - x;
        }
    }
}

multiversion! {
    /// `out = x + s out`.
    pub fn combine[T: Real](out: &mut [T], s: T, x: &[T]) {
        for (o, &x) in out.iter_mut().zip(x) {
            *o = x + s * *o;
        }
    }
}

multiversion! {
    /// max |x - s y|, or NaN when any number is not finite.
    pub fn max_gap[T: Real](x: &[T], y: &[T], s: T) -> f64 {
        let mut largest = [T::ZERO; LANES];
        let mut poison = T::ZERO;
        for (x, y) in x.chunks(LANES).zip(y.chunks(LANES)) {
            for (l, (&x, &y)) in x.iter().zip(y).enumerate() {
                let gap = x - s * y;
                largest[l] = gap.abs().max(largest[l]);
                poison += gap * T::ZERO;
            }
        }
        let all = largest.iter().fold(T::ZERO, |all, &l| l.max(all));
        if poison.is_finite() { all.to_f64() } else { f64::NAN }
    }
}

multiversion! {
    /// sum (x + s y - a - b)^2.
    pub fn distance[T: Real](x: &[T], y: &[T], s: T, a: &[T], b: &[T]) -> f64 {
        let mut sums = [0.0; LANES];
        let n = x.len();
        let (y, a, b) = (&y[..n], &a[..n], &b[..n]);
        let whole = n / LANES * LANES;
        for start in (0..whole).step_by(LANES) {
            for l in 0..LANES {
                let i = start + l;
                let gap = (x[i] + s * y[i] - a[i] - b[i]).to_f64();
                sums[l] += gap * gap;
            }
        }
        for i in whole..n {
            let gap = (x[i] + s * y[i] - a[i] - b[i]).to_f64();
            sums[i - whole] += gap * gap;
        }
        sums.iter().sum()
    }
}

multiversion! {
    /// `out += s (x - y - out)`.
    pub fn relax[T: Real](out: &mut [T], s: T, x: &[T], y: &[T]) {
        for ((o, &x), &y) in out.iter_mut().zip(x).zip(y) {
            *o += s * (x - y - *o);
        }
    }
}

multiversion! {
    /// max |x - y - z|, or NaN when any number is not finite.
    pub fn max_distance[T: Real](x: &[T], y: &[T], z: &[T]) -> f64 {
        let mut largest = [T::ZERO; LANES];
        let mut poison = T::ZERO;
        for ((x, y), z) in x.chunks(LANES).zip(y.chunks(LANES)).zip(z.chunks(LANES)) {
            for (l, ((&x, &y), &z)) in x.iter().zip(y).zip(z).enumerate() {
                let gap = x - y - z;
                largest[l] = gap.abs().max(largest[l]);
                poison += gap * T::ZERO;
            }
        }
        let all = largest.iter().fold(T::ZERO, |all, &l| l.max(all));
        if poison.is_finite() { all.to_f64() } else { f64::NAN }
    }
}
