//! Cholesky's factor of a banded matrix, row by row.
//!
//! Row k of a factor with half bandwidth b holds L_k,k-b .. L_kk in b + 1 numbers; those before the first column are 0.

use super::hessian::Hessian;
use crate::real::Real;

/// A pivot below this part of the diagonal, times the rounding of the precision, is rounding: the diagonal stands in for it.
const LEAST: f64 = 4.0;
/// Numbers that sums are made of side by side.
const LANES: usize = 8;

/// A factor that is made.
#[derive(Clone, Copy)]
pub struct Factor<'a, T> {
    pub values: &'a [T],
    pub band: usize,
}

/// Makes the factor of what `rows` writes: the lower half of a symmetric matrix of `size` rows, row by row, into numbers that are 0.
pub fn factorise<T: Real>(values: &mut [T], size: usize, band: usize, rows: impl Fn(usize, &mut [T])) {
    let width = band + 1;
    for k in 0..size {
        let (above, own) = values.split_at_mut((k * width).min(values.len()));
        let Some(own) = own.get_mut(..width) else { return };
        own.fill(T::ZERO);
        rows(k, own);
        let first = k.saturating_sub(band);
        let diagonal = own.last().map_or(0.0, |value| value.to_f64());
        for j in first..k {
            // Both rows begin at the later of their first columns.
            let begin = first.max(j.saturating_sub(band));
            let other = above.get(j * width..(j + 1) * width).unwrap_or(&[]);
            let at = j + band - k;
            let (done, rest) = own.split_at_mut(at);
            let same = &done[(begin + band - k).min(at)..];
            let theirs = other.get(begin + band - j..band).unwrap_or(&[]);
            let pivot = other.last().map_or(1.0, |value| value.to_f64());
            if let Some(value) = rest.first_mut() {
                *value = T::from_f64((value.to_f64() - dot(same, theirs)) / pivot);
            }
        }
        let (done, last) = own.split_at_mut(band);
        let pivot = diagonal - dot(done, done);
        // A NaN stays one.
        let pivot = if pivot <= LEAST * T::EPSILON * diagonal {
            diagonal
        } else {
            pivot
        };
        if let Some(last) = last.first_mut() {
            *last = T::from_f64(libm::sqrt(pivot));
        }
    }
}

/// Writes row k of a Hessian's lower half.
pub fn row_of<T: Real>(hessian: &Hessian<'_, T>, band: usize, k: usize, row: &mut [T]) {
    let dims = hessian.dims;
    let (number, component) = (k / dims, k % dims);
    for (column, block) in hessian.row(number).filter(|(column, _)| *column <= number) {
        let from = block.get(component * dims..).unwrap_or(&[]);
        for (c, value) in from.iter().enumerate().take(dims) {
            let j = column * dims + c;
            if j <= k
                && let Some(to) = row.get_mut(j + band - k)
            {
                *to = *value;
            }
        }
    }
}

impl<T: Real> Factor<'_, T> {
    /// Solves L L^T X = B in place, `N` columns side by side in each of the rows of `x`; rows of B before `first` are 0.
    pub fn solve<const N: usize>(&self, x: &mut [T], first: usize) {
        let width = self.band + 1;
        let rows = x.len() / N;
        for k in first..rows {
            let row = self.values.get(k * width..(k + 1) * width).unwrap_or(&[]);
            let begin = k.saturating_sub(self.band).max(first);
            let (done, rest) = x.split_at_mut(k * N);
            let done = done.get(begin * N..).unwrap_or(&[]);
            let factors = row.get(begin + self.band - k..self.band).unwrap_or(&[]);
            let sums = combine::<T, N>(factors, done);
            let pivot = row.last().map_or(1.0, |value| value.to_f64());
            for (value, sum) in rest.iter_mut().zip(sums) {
                *value = T::from_f64((value.to_f64() - sum) / pivot);
            }
        }
        for k in (0..rows).rev() {
            let row = self.values.get(k * width..(k + 1) * width).unwrap_or(&[]);
            let begin = k.saturating_sub(self.band);
            let (before, own) = x.split_at_mut(k * N);
            let pivot = row.last().map_or(1.0, |value| value.to_f64());
            let mut solved = [T::ZERO; N];
            for (value, solved) in own.iter_mut().zip(&mut solved) {
                *value = T::from_f64(value.to_f64() / pivot);
                *solved = *value;
            }
            let factors = row.get(begin + self.band - k..self.band).unwrap_or(&[]);
            let before = before.get_mut(begin * N..).unwrap_or(&mut []);
            for (values, &factor) in before.chunks_exact_mut(N).zip(factors) {
                for (value, &solved) in values.iter_mut().zip(&solved) {
                    *value -= factor * solved;
                }
            }
        }
    }
}

/// The sum of factors times rows of `N` numbers.
#[inline(always)]
fn combine<T: Real, const N: usize>(factors: &[T], rows: &[T]) -> [f64; N] {
    let mut sums = [[0.0; N]; 4];
    let (four, rest) = factors.as_chunks::<4>();
    let (all, last) = rows.split_at(4 * N * four.len());
    for (factors, rows) in four.iter().zip(all.chunks_exact(4 * N)) {
        for ((sum, factor), row) in sums.iter_mut().zip(factors).zip(rows.chunks_exact(N)) {
            for (sum, value) in sum.iter_mut().zip(row) {
                *sum += factor.to_f64() * value.to_f64();
            }
        }
    }
    let mut out = [0.0; N];
    for (k, out) in out.iter_mut().enumerate() {
        *out = (sums[0][k] + sums[1][k]) + (sums[2][k] + sums[3][k]);
    }
    for (factor, row) in rest.iter().zip(last.chunks_exact(N)) {
        for (out, value) in out.iter_mut().zip(row) {
            *out += factor.to_f64() * value.to_f64();
        }
    }
    out
}

/// <a, b>.
#[inline(always)]
fn dot<T: Real>(a: &[T], b: &[T]) -> f64 {
    let mut sums = [0.0; LANES];
    let ((many, rest), (others, last)) = (a.as_chunks::<LANES>(), b.as_chunks::<LANES>());
    for (a, b) in many.iter().zip(others) {
        for ((sum, a), b) in sums.iter_mut().zip(a).zip(b) {
            *sum += a.to_f64() * b.to_f64();
        }
    }
    let rest: f64 = rest.iter().zip(last).map(|(a, b)| a.to_f64() * b.to_f64()).sum();
    sums.iter().sum::<f64>() + rest
}
