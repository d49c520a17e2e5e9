//! The even and odd parts of fields about the middle of an axis.

use crate::real::Real;
use crate::simd::{Vector, multiversion, vectorised};

multiversion! {
    /// Both halves of a row, the second backwards, summed and subtracted.
    pub fn fold_row[T: Real](row: &[T], even: &mut [T], odd: &mut [T]) {
        let (low, high) = row.split_at(row.len() - row.len() / 2);
        for (((even, odd), &low), &high) in even.iter_mut().zip(odd.iter_mut()).zip(low).zip(high.iter().rev()) {
            (*even, *odd) = (low + high, low - high);
        }
        if let (Some(middle), Some(&row)) = (even.get_mut(odd.len()), low.get(odd.len())) {
            *middle = row;
        }
    }
}

multiversion! {
    /// A row from its even and odd parts.
    pub fn unfold_row[T: Real](even: &[T], odd: &[T], row: &mut [T]) {
        let half = row.len() / 2;
        let (low, high) = row.split_at_mut(row.len() - half);
        for (((low, high), &even), &odd) in low.iter_mut().zip(high.iter_mut().rev()).zip(even).zip(odd) {
            (*low, *high) = (even + odd, even - odd);
        }
        if let (Some(row), Some(&middle)) = (low.get_mut(half), even.get(half)) {
            *row = middle;
        }
    }
}

vectorised! {
    /// `sum = low + high`, `difference = low - high`.
    pub fn fold[T, V](low: &[T], high: &[T], sum: &mut [T], difference: &mut [T]) {
        let n = low.len();
        let (high, sum, difference) = (&high[..n], &mut sum[..n], &mut difference[..n]);
        let whole = n - n % <V as Vector>::LANES;
        for i in (0..whole).step_by(<V as Vector>::LANES) {
            let (l, h): (V, V) = (V::load(&low[i..]), V::load(&high[i..]));
            (l + h).store(&mut sum[i..]);
            (l - h).store(&mut difference[i..]);
        }
        for i in whole..n {
            (sum[i], difference[i]) = (low[i] + high[i], low[i] - high[i]);
        }
    }
}
