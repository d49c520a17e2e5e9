//! From a field of cells to its coefficients in the eigenvectors of every axis, and back.
//!
//! Axes but the first are transformed in panels of columns, the first in groups of rows; both are products of small matrices
//! that stay in the nearest cache. See [`spectrum`](crate::grid::spectrum) for the eigenvectors.

use crate::grid::Grid;
use crate::grid::spectrum::{COLUMNS, Modes, PARITIES, Parity, Spectrum, TOGETHER};
use crate::real::Real;
use crate::simd::{Vector, multiversion, vectorised};
use core::ops::Range;

/// Columns of a panel.
const PANEL: usize = 2 * COLUMNS;

/// Numbers of scratch.
#[must_use]
pub fn scratch_len(grid: &Grid) -> usize {
    let longest = grid
        .n
        .iter()
        .skip(1)
        .take(grid.dims - 1)
        .fold(0, |longest, &n| n.max(longest));
    (2 * longest * PANEL).max(TOGETHER * (grid.n[0] + padded(grid.n[0])))
}

/// Columns of both parities along the first axis.
fn padded(n: usize) -> usize {
    PARITIES
        .iter()
        .map(|parity| parity.count(n).next_multiple_of(COLUMNS))
        .sum()
}

/// Replaces the coefficients of `field`, of one slot, by what `symbol` makes of them: it is given a row of coefficients, which
/// of those along the first axis (even ones first), their values, and room for as many new ones.
pub fn multiply<T: Real>(
    grid: &Grid,
    spectrum: &Spectrum<'_, T>,
    field: &mut [T],
    scratch: &mut [T],
    symbol: impl Fn(usize, Range<usize>, &[T], &mut [T]),
) {
    for axis in (1..grid.dims).rev() {
        along_columns(
            grid,
            axis,
            &spectrum.axes[axis],
            Direction::Analysis,
            field,
            scratch,
        );
    }
    along_rows(grid.n[0], &spectrum.axes[0], field, scratch, symbol);
    for axis in 1..grid.dims {
        along_columns(
            grid,
            axis,
            &spectrum.axes[axis],
            Direction::Synthesis,
            field,
            scratch,
        );
    }
}

/// Which way a transform goes.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Direction {
    /// From numbers to coefficients.
    Analysis,
    /// Back.
    Synthesis,
}

/// Transforms `field` along an axis but the first, in place.
fn along_columns<T: Real>(
    grid: &Grid,
    axis: usize,
    eigenvectors: &Modes<'_, T>,
    direction: Direction,
    field: &mut [T],
    scratch: &mut [T],
) {
    let n = grid.n[axis];
    let width: usize = grid.n[..axis].iter().product();
    let (from, to) = scratch.split_at_mut(n * PANEL);
    let to = &mut to[..n * PANEL];
    for field in field.chunks_exact_mut(n * width) {
        for start in (0..width).step_by(PANEL) {
            let count = PANEL.min(width - start);
            let columns = count.next_multiple_of(COLUMNS);
            let (from, to) = (&mut from[..n * columns], &mut to[..n * columns]);
            let row = |i: usize| i * width + start..i * width + start + count;
            if direction == Direction::Analysis {
                for i in 0..n / 2 {
                    let (even, odd) = from.split_at_mut(Parity::Even.count(n) * columns);
                    fold(
                        &field[row(i)],
                        &field[row(n - 1 - i)],
                        &mut even[i * columns..][..count],
                        &mut odd[i * columns..][..count],
                    );
                }
                if n % 2 == 1 {
                    from[n / 2 * columns..][..count].copy_from_slice(&field[row(n / 2)]);
                }
            } else {
                (0..n).for_each(|i| from[i * columns..][..count].copy_from_slice(&field[row(i)]));
            }
            let mut before = 0;
            for parity in PARITIES {
                let part = parity.count(n);
                let matrix = if direction == Direction::Analysis {
                    eigenvectors.analysis(parity)
                } else {
                    eigenvectors.synthesis(parity)
                };
                let range = before * columns..(before + part) * columns;
                product(matrix, part, &from[range.clone()], columns, &mut to[range]);
                before += part;
            }
            if direction == Direction::Analysis {
                (0..n).for_each(|i| field[row(i)].copy_from_slice(&to[i * columns..][..count]));
            } else {
                let (even, odd) = to.split_at(Parity::Even.count(n) * columns);
                for i in 0..n / 2 {
                    let (low, high) = field.split_at_mut((n - 1 - i) * width);
                    fold(
                        &even[i * columns..][..count],
                        &odd[i * columns..][..count],
                        &mut low[row(i)],
                        &mut high[start..start + count],
                    );
                }
                if n % 2 == 1 {
                    field[row(n / 2)].copy_from_slice(&even[n / 2 * columns..][..count]);
                }
            }
        }
    }
}

/// Transforms along the first axis, lets `symbol` change the coefficients, and transforms back: [`TOGETHER`] rows at a time.
fn along_rows<T: Real>(
    n: usize,
    eigenvectors: &Modes<'_, T>,
    field: &mut [T],
    scratch: &mut [T],
    symbol: impl Fn(usize, Range<usize>, &[T], &mut [T]),
) {
    let (halves, products) = scratch.split_at_mut(TOGETHER * n);
    let products = &mut products[..TOGETHER * padded(n)];
    for (group, rows) in field.chunks_mut(TOGETHER * n).enumerate() {
        let count = rows.len() / n;
        let (even, odd) = halves.split_at_mut(TOGETHER * Parity::Even.count(n));
        for ((row, even), odd) in rows
            .chunks_exact(n)
            .zip(even.chunks_exact_mut(n.div_ceil(2)))
            .zip(odd.chunks_exact_mut(n / 2))
        {
            fold_row(row, even, odd);
        }
        let (mut first, mut column) = (0, 0);
        for parity in PARITIES {
            let part = parity.count(n);
            let columns = part.next_multiple_of(COLUMNS);
            let (halves, of_parity) = (
                &mut halves[TOGETHER * first..][..TOGETHER * part],
                &mut products[column..][..TOGETHER * columns],
            );
            product(halves, part, eigenvectors.analysis(parity), columns, of_parity);
            for (r, (coefficients, out)) in of_parity
                .chunks_exact(columns)
                .zip(halves.chunks_exact_mut(part))
                .enumerate()
                .take(count)
            {
                symbol(
                    TOGETHER * group + r,
                    first..first + part,
                    &coefficients[..part],
                    out,
                );
            }
            product(halves, part, eigenvectors.synthesis(parity), columns, of_parity);
            (first, column) = (first + part, column + TOGETHER * columns);
        }
        let columns = PARITIES.map(|parity| parity.count(n).next_multiple_of(COLUMNS));
        let (even, odd) = products.split_at(TOGETHER * columns[0]);
        for ((row, even), odd) in rows
            .chunks_exact_mut(n)
            .zip(even.chunks_exact(columns[0]))
            .zip(odd.chunks_exact(columns[1]))
        {
            unfold_row(even, odd, row);
        }
    }
}

multiversion! {
    /// Both halves of a row, the second backwards, summed and subtracted.
    fn fold_row[T: Real](row: &[T], even: &mut [T], odd: &mut [T]) {
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
    fn unfold_row[T: Real](even: &[T], odd: &[T], row: &mut [T]) {
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
    fn fold[T, V](low: &[T], high: &[T], sum: &mut [T], difference: &mut [T]) {
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

vectorised! {
    /// `out = A B`, `depth` numbers a row of A; `columns` a row of B and of `out`, a multiple of [`COLUMNS`]. A has a multiple of
    /// [`TOGETHER`] rows; those that `out` has not are left out.
    fn product[T, V](a: &[T], depth: usize, b: &[T], columns: usize, out: &mut [T]) {
        let lanes = <V as Vector>::LANES;
        if depth == 0 || columns == 0 {
            return;
        }
        let mut rows = a.chunks_exact(depth);
        for out in out.chunks_mut(TOGETHER * columns) {
            let (Some(a0), Some(a1), Some(a2), Some(a3)) = (rows.next(), rows.next(), rows.next(), rows.next()) else { return };
            for start in (0..columns).step_by(2 * lanes) {
                let mut sums = [[V::splat(T::ZERO); 2]; TOGETHER];
                for ((((b, &a0), &a1), &a2), &a3) in b.chunks_exact(columns).zip(a0).zip(a1).zip(a2).zip(a3) {
                    let b: [V; 2] = [V::load(&b[start..]), V::load(&b[start + lanes..])];
                    for (sums, a) in sums.iter_mut().zip([a0, a1, a2, a3]) {
                        let a = V::splat(a);
                        *sums = [sums[0] + a * b[0], sums[1] + a * b[1]];
                    }
                }
                for (sums, out) in sums.iter().zip(out.chunks_exact_mut(columns)) {
                    sums[0].store(&mut out[start..]);
                    sums[1].store(&mut out[start + lanes..]);
                }
            }
        }
    }
}
