//! Runs of rows that are computed together, and rows around which there is no smoke, which are passed over, as are the ends of long rows.

use super::rows::Cells;
use crate::grid::Grid;
use crate::grid::stencil::Stencil;
use crate::real::Real;
use crate::simd::vectorised;
use core::ops::Range;

/// Cuts `rows` into runs of rows whose stencils are alike and of which all are empty or none is, and calls `visit` with the
/// stencil of a run's first row, the length of the run and whether it is empty. `empty` is asked about the row that lies some rows
/// behind the one of a stencil. Runs have one row each if `single`.
pub fn each_run(
    grid: &Grid,
    rows: Range<usize>,
    single: bool,
    empty: impl Fn(&Stencil, usize) -> bool,
    mut visit: impl FnMut(&Stencil, usize, bool),
) {
    let mut row = rows.start;
    while row < rows.end {
        let stencil = Stencil::new(grid, row);
        let most = if single {
            1
        } else {
            stencil.alike.min(rows.end - row)
        };
        let first = empty(&stencil, 0);
        let mut count = 1;
        while count < most && empty(&stencil, count) == first {
            count += 1;
        }
        visit(&stencil, count, first);
        row += count;
    }
}

/// Rows of more cells than this are looked at in parts of so many.
const PART: usize = 256;

/// Whether rows are too long to be computed as a whole where there is smoke anywhere near them.
pub fn long_rows(grid: &Grid) -> bool {
    grid.n[0] > PART
}

/// A field of cells that may be 0 in many rows.
#[derive(Clone, Copy, Debug)]
pub struct Sparse<'a, T> {
    /// The field.
    pub cells: Cells<'a, T>,
    /// A size of each of its rows, where they are known.
    pub sizes: Option<&'a [T]>,
}

impl<T: Real> Sparse<'_, T> {
    /// Whether the field is 0 in the row that lies `behind` rows behind the stencil's and in those around that, so that there is
    /// no flux: by what `is_zero` says of the rows' sizes, or else by looking.
    #[inline]
    pub fn is_empty(
        &self,
        grid: &Grid,
        stencil: &Stencil,
        behind: usize,
        is_zero: impl Fn(T) -> bool,
    ) -> bool {
        let around = 4 * (grid.dims - 1);
        if let Some(sizes) = self.sizes {
            let is_zero = |&row: &usize| sizes.get(row + behind).is_some_and(|&size| is_zero(size));
            return is_zero(&stencil.row) && stencil.cells.as_flattened().iter().take(around).all(is_zero);
        }
        let n = grid.n[0];
        let (values, stride, before) = self.cells.layout(n);
        let begin = |row: usize| (row + behind) * stride + before;
        let [y, z] = stencil.cells.map(|rows| rows.map(begin));
        all_zero(values, &[begin(stencil.row)], n)
            && all_zero(values, &y, n)
            && (grid.dims == 2 || all_zero(values, &z, n))
    }

    /// The cells of the stencil's row to which there may be a flux: all of them if it is not [`long`](long_rows), else those from the first to
    /// the last part in which the field is not 0 in this row or in one around it, and two more on either side.
    pub fn extent(&self, grid: &Grid, stencil: &Stencil) -> Range<usize> {
        let n = grid.n[0];
        if !long_rows(grid) {
            return 0..n;
        }
        let (values, stride, before) = self.cells.layout(n);
        let begin = |row: usize| row * stride + before;
        let [y, z] = stencil.cells.map(|rows| rows.map(begin));
        let smoky = |&start: &usize| {
            let len = PART.min(n - start);
            let zero = |begins: [usize; 4]| all_zero(values, &begins.map(|begin| begin + start), len);
            !(all_zero(values, &[begin(stencil.row) + start], len) && zero(y) && (grid.dims == 2 || zero(z)))
        };
        let mut parts = (0..n).step_by(PART).filter(smoky);
        let Some(first) = parts.next() else { return 0..0 };
        let last = parts.last().unwrap_or(first);
        let (start, end) = (first.saturating_sub(2), (last + PART + 2).min(n));
        // Around a ring the ends are neighbours.
        if grid.axis(0).is_ring() && (start < 2 || end + 2 > n) {
            return 0..n;
        }
        start..end
    }
}

vectorised! {
    /// Whether the rows of `n` values that begin at `begins` exist and are 0.
    fn all_zero[T, V](values: &[T], begins: &[usize], n: usize) -> bool {
        let (mut sum, mut rest, mut lanes) = (V::splat(T::ZERO), T::ZERO, [T::ZERO; 16]);
        for &begin in begins {
            let Some(row) = values.get(begin..begin + n) else { return false };
            let vectors = row.chunks_exact(V::LANES);
            for x in vectors.remainder() {
                rest += x.abs();
            }
            for x in vectors {
                let x = V::load(x);
                sum = sum + x.max(-x);
            }
        }
        sum.store(&mut lanes);
        for x in lanes {
            rest += x;
        }
        rest == T::ZERO
    }
}
