//! Poisson's problem by eigenvectors: a transform along every axis, a division by the eigenvalues, and back, slot by slot.
//!
//! Axes but the first are transformed in panels of columns, the first in groups of rows; both are products of small matrices
//! that stay in the nearest cache. See [`spectrum`](crate::grid::spectrum) for the eigenvectors.

use super::{Batch, divergence_in_row, subtract_gradient_in_row};
use crate::exec::{Exec, RowBuffers, for_rows};
use crate::field::{Block, VectorMut, rows, view};
use crate::grid::Grid;
use crate::grid::spectrum::{Axis, COLUMNS, PARITIES, Parity, Spectrum, TOGETHER};
use crate::observe::{Event, Observer};
use crate::plan::Pool;
use crate::real::Real;
use crate::simd::{Vector, vectorised};
use core::ops::ControlFlow;

/// Columns of a panel.
const PANEL: usize = 2 * COLUMNS;

/// Numbers of scratch of a thread.
#[must_use]
pub fn scratch_per_thread(grid: &Grid) -> usize {
    let longest = grid.n.iter().skip(1).take(grid.dims - 1).fold(0, |longest, &n| n.max(longest));
    (2 * longest * PANEL).max(grid.n[0]).max(TOGETHER * 2 * (grid.n[0] + 1 + padded(grid.n[0])))
}

/// Columns of both parities along the first axis.
fn padded(n: usize) -> usize {
    PARITIES.iter().map(|parity| parity.count(n).next_multiple_of(COLUMNS)).sum()
}

/// The workspace: potentials slot by slot, each with the cells of a slot side by side.
#[derive(Debug)]
pub struct Spectral<'a, T> {
    grid: &'a Grid,
    spectrum: Spectrum<'a, T>,
    q: &'a mut [T],
    scratch: &'a mut [T],
}

impl<'a, T: Real> Spectral<'a, T> {
    /// Takes its numbers.
    pub fn carve(grid: &'a Grid, spectrum: Spectrum<'a, T>, batch: usize, scratch: usize, pool: &mut Pool<'a, T>) -> Self {
        Self { grid, spectrum, q: pool.take(grid.cells() * batch), scratch: pool.take(scratch) }
    }

    /// The right-hand side div v, and max |div v| and max |v|.
    pub fn divergence(&mut self, exec: &dyn Exec, batch: Batch, v: &VectorMut<'_, T>, sums: &mut [f64]) -> (f64, f64) {
        let (grid, v) = (self.grid, view(v));
        let sums = &mut sums[..2 * batch.count];
        let q = &mut self.q[..grid.cells() * batch.count];
        for_rows(exec, batch.count, 0..batch.count, RowBuffers { fields: [q], sums: &mut *sums, scratch: &mut *self.scratch }, |task| {
            let [q] = task.fields;
            let block = batch.slot(grid, task.row);
            let mut maxima = [0.0; 2];
            for (row, q) in q.chunks_exact_mut(grid.n[0]).enumerate() {
                maxima = divergence_in_row(&block, row, v, q, task.scratch, maxima);
            }
            task.sums.copy_from_slice(&maxima);
        });
        let of = |which: usize| rows::largest(sums.iter().skip(which).step_by(2).copied());
        (of(0), of(1))
    }

    /// q with div grad q = the right-hand side.
    pub fn solve(&mut self, exec: &dyn Exec, observer: &mut dyn Observer, batch: Batch) -> ControlFlow<()> {
        let (grid, spectrum) = (self.grid, &self.spectrum);
        let q = &mut self.q[..grid.cells() * batch.count];
        for_rows(exec, batch.count, 0..batch.count, RowBuffers { fields: [q], sums: &mut [], scratch: &mut *self.scratch }, |task| {
            let [q] = task.fields;
            solve(grid, spectrum, q, task.scratch);
        });
        observer.on(Event::Work)
    }

    /// v -= grad q, and p -= q.
    pub fn subtract_gradient(&mut self, exec: &dyn Exec, batch: Batch, v: &mut VectorMut<'_, T>, potential: Option<&mut [T]>) {
        let (grid, q) = (self.grid, &*self.q);
        let [v0, v1, v2] = v.each_mut().map(|component| &mut **component);
        let fields = [v0, v1, v2, potential.unwrap_or_default()];
        for_rows(exec, grid.rows(), 0..grid.rows(), RowBuffers { fields, sums: &mut [], scratch: &mut *self.scratch }, |task| {
            let mut fields = task.fields;
            let alone = Block { grid, slots: 1, first: 0, count: 1 };
            for (index, q) in q.chunks_exact(grid.cells()).take(batch.count).enumerate() {
                subtract_gradient_in_row(&alone, task.row, q, batch.slot(grid, index).span_in_row(), &mut fields, task.scratch);
            }
        });
    }
}

/// `field`, a right-hand side at the cells of one slot, becomes the q of mean 0 with div grad q = right-hand side less its mean.
pub fn solve<T: Real>(grid: &Grid, spectrum: &Spectrum<'_, T>, field: &mut [T], scratch: &mut [T]) {
    for axis in (1..grid.dims).rev() {
        along_columns(grid, axis, &spectrum.axes[axis], Direction::Analysis, field, scratch);
    }
    along_rows(grid, spectrum, field, scratch);
    for axis in 1..grid.dims {
        along_columns(grid, axis, &spectrum.axes[axis], Direction::Synthesis, field, scratch);
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
fn along_columns<T: Real>(grid: &Grid, axis: usize, eigenvectors: &Axis<'_, T>, direction: Direction, field: &mut [T], scratch: &mut [T]) {
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
                    fold(&field[row(i)], &field[row(n - 1 - i)], &mut even[i * columns..][..count], &mut odd[i * columns..][..count]);
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
                let matrix = if direction == Direction::Analysis { eigenvectors.analysis(parity) } else { eigenvectors.synthesis(parity) };
                let range = before * columns..(before + part) * columns;
                multiply(matrix, part, &from[range.clone()], columns, &mut to[range]);
                before += part;
            }
            if direction == Direction::Analysis {
                (0..n).for_each(|i| field[row(i)].copy_from_slice(&to[i * columns..][..count]));
            } else {
                let (even, odd) = to.split_at(Parity::Even.count(n) * columns);
                for i in 0..n / 2 {
                    let (low, high) = field.split_at_mut((n - 1 - i) * width);
                    fold(&even[i * columns..][..count], &odd[i * columns..][..count], &mut low[row(i)], &mut high[start..start + count]);
                }
                if n % 2 == 1 {
                    field[row(n / 2)].copy_from_slice(&even[n / 2 * columns..][..count]);
                }
            }
        }
    }
}

/// Transforms along the first axis, divides by minus the eigenvalues, and transforms back: [`TOGETHER`] rows at a time.
fn along_rows<T: Real>(grid: &Grid, spectrum: &Spectrum<'_, T>, field: &mut [T], scratch: &mut [T]) {
    let (n, eigenvectors) = (grid.n[0], &spectrum.axes[0]);
    let (packed, products) = scratch.split_at_mut(TOGETHER * 2 * (n + 1));
    let products = &mut products[..TOGETHER * padded(n)];
    for (group, rows) in field.chunks_mut(TOGETHER * n).enumerate() {
        let count = rows.len() / n;
        let (mut first, mut column) = (0, 0);
        pack_folded(rows, n, packed);
        for parity in PARITIES {
            let part = parity.count(n);
            let columns = part.next_multiple_of(COLUMNS);
            let (packed, product) = (&mut packed[first..first + TOGETHER * part], &mut products[column..column + TOGETHER * columns]);
            multiply(packed, part, eigenvectors.analysis(parity), columns, product);
            let eigenvalues = &eigenvectors.eigenvalues[first / TOGETHER..][..part];
            for r in 0..TOGETHER {
                let across = eigenvalue_across(grid, spectrum, TOGETHER * group + r.min(count - 1));
                let product = &product[r * columns..][..part];
                for ((packed, &value), &along) in packed.iter_mut().skip(r).step_by(TOGETHER).zip(product).zip(eigenvalues) {
                    let eigenvalue = along + across;
                    *packed = if eigenvalue > T::ZERO { -(value / eigenvalue) } else { value * T::ZERO };
                }
            }
            multiply(packed, part, eigenvectors.synthesis(parity), columns, product);
            (first, column) = (first + TOGETHER * part, column + TOGETHER * columns);
        }
        unfold(products, n, rows);
    }
}

/// The eigenvalues of the axes but the first, for a row of coefficients.
fn eigenvalue_across<T: Real>(grid: &Grid, spectrum: &Spectrum<'_, T>, row: usize) -> T {
    let at = grid.row_at(row);
    (1..grid.dims).fold(T::ZERO, |sum, axis| sum + spectrum.axes[axis].eigenvalues[at[axis - 1]])
}

/// Both halves of up to [`TOGETHER`] rows, summed and subtracted, the rows side by side; rows that are not there stay as they are.
fn pack_folded<T: Real>(rows: &[T], n: usize, packed: &mut [T]) {
    let (even, odd) = packed.split_at_mut(TOGETHER * Parity::Even.count(n));
    for (r, row) in rows.chunks_exact(n).enumerate() {
        let (low, high) = row.split_at(n - n / 2);
        for (((even, odd), &low), &high) in
            even.iter_mut().skip(r).step_by(TOGETHER).zip(odd.iter_mut().skip(r).step_by(TOGETHER)).zip(low).zip(high.iter().rev())
        {
            (*even, *odd) = (low + high, low - high);
        }
        if n % 2 == 1 {
            even[TOGETHER * (n / 2) + r] = row[n / 2];
        }
    }
}

/// Rows from the products of their even and odd parts.
fn unfold<T: Real>(products: &[T], n: usize, rows: &mut [T]) {
    let columns = PARITIES.map(|parity| parity.count(n).next_multiple_of(COLUMNS));
    let (even, odd) = products.split_at(TOGETHER * columns[0]);
    for (r, row) in rows.chunks_exact_mut(n).enumerate() {
        let (even, odd) = (&even[r * columns[0]..][..n.div_ceil(2)], &odd[r * columns[1]..][..n / 2]);
        let (low, high) = row.split_at_mut(n - n / 2);
        for (((low, high), &even), &odd) in low.iter_mut().zip(high.iter_mut().rev()).zip(even).zip(odd) {
            (*low, *high) = (even + odd, even - odd);
        }
        if n % 2 == 1 {
            low[n / 2] = even[n / 2];
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
    /// `out = A B`, `depth` numbers a row of A, whose rows lie side by side in groups of [`TOGETHER`]; `columns` a row of B and
    /// of `out`, a multiple of [`COLUMNS`]. Rows that `out` has not are left out.
    fn multiply[T, V](a: &[T], depth: usize, b: &[T], columns: usize, out: &mut [T]) {
        let lanes = <V as Vector>::LANES;
        for (a, out) in a.chunks_exact(TOGETHER * depth).zip(out.chunks_mut(TOGETHER * columns)) {
            for start in (0..columns).step_by(2 * lanes) {
                let mut sums = [[V::splat(T::ZERO); 2]; TOGETHER];
                for (a, b) in a.chunks_exact(TOGETHER).zip(b.chunks_exact(columns)) {
                    let b: [V; 2] = [V::load(&b[start..]), V::load(&b[start + lanes..])];
                    for (sums, &a) in sums.iter_mut().zip(a) {
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
