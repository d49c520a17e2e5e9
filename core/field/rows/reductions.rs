//! Sums and maxima of a row. All add lane by lane, so that no instruction set changes a bit.

use crate::real::Real;
use crate::simd::multiversion;

/// The lanes of all reductions: a fixed number, so that every instruction set adds in the same order.
pub const LANES: usize = 16;

multiversion! {
    /// max |x|, or NaN when any value is not finite (a plain maximum would swallow it).
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

/// The largest of the lanes, or NaN unless the sum of `poison`, which is 0 times all values, is finite.
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
    /// Adds products to lanes, product `i` to lane `i` modulo [`LANES`].
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

multiversion! {
    /// max |x - s y|, or NaN when any value is not finite.
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
    /// max |x - y - z|, or NaN when any value is not finite.
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
