//! From a field of cells to its coefficients in the eigenvectors of every axis, and back ([`spectrum`](crate::grid::spectrum)).
//!
//! Axes but the first are transformed in panels of columns, the first in groups of rows. Both are products of small matrices that
//! stay in the nearest cache, or fast transforms (`fast_axis.rs`).

use super::fast_axis;
use super::folds::{fold, fold_row, unfold_row};
use crate::exec::{self, Exec, Serial, for_panels};
use crate::grid::Grid;
use crate::grid::spectrum::{COLUMNS, Modes, PARITIES, Parity, Spectrum, TOGETHER, is_fast};
use crate::real::Real;
use crate::simd::{Vector, vectorised};
use core::ops::Range;

/// The columns of a panel, at most.
const PANEL: usize = 2 * COLUMNS;

/// The scratch of one transform on `grid`, in elements.
#[must_use]
pub fn scratch_len(grid: &Grid) -> usize {
    let grid = grid.whole();
    let of_axis = |axis: usize| match (grid.n[axis], axis) {
        (n, _) if is_fast(grid.axis(axis)) => fast_axis::scratch_len(n),
        (n, 0) => (TOGETHER * (n + padded(n))).max(n * COLUMNS),
        (n, _) => 2 * n * PANEL,
    };
    (0..grid.dims).map(of_axis).max().unwrap_or(0)
}

/// The columns of both parities along a first axis of `n` cells.
fn padded(n: usize) -> usize {
    PARITIES
        .iter()
        .map(|parity| parity.count(n).next_multiple_of(COLUMNS))
        .sum()
}

/// The row of the box that each row of a part of a field is.
pub type RowOf<'a> = &'a (dyn Fn(usize) -> usize + Sync + 'a);

/// Transforms `field`, a field of cells, along every axis but the first, calls `rows` with it, and transforms back, in place. `rows` is called with the
/// threads that it may use, the row of the box that each row of a part of the field is, that part, and scratch. Every thread has [`scratch_len`] elements of
/// `scratch`.
pub fn across<T: Real>(
    exec: &dyn Exec,
    (grid, spectrum): (&Grid, &Spectrum<'_, T>),
    field: &mut [T],
    scratch: &mut [T],
    rows: impl Fn(&dyn Exec, RowOf<'_>, &mut [T], &mut [T]) + Sync,
) {
    let axes = &spectrum.axes;
    let width = |axis: usize| grid.n.iter().take(axis).product::<usize>();
    let columns = |exec: &dyn Exec, axis: usize, direction: Direction, field: &mut [T], scratch: &mut [T]| {
        along_columns(exec, (&axes[axis], width(axis)), direction, field, scratch);
    };
    let within = |exec: &dyn Exec, first: usize, field: &mut [T], scratch: &mut [T]| {
        for axis in (1..grid.dims - 1).rev() {
            columns(exec, axis, Direction::Analysis, field, scratch);
        }
        rows(exec, &|row| first + row, field, scratch);
        for axis in 1..grid.dims - 1 {
            columns(exec, axis, Direction::Synthesis, field, scratch);
        }
    };
    let last = grid.dims - 1;
    columns(exec, last, Direction::Analysis, field, scratch);
    // Some planes stay in the second cache for all that is done to them, where that leaves enough to share.
    let (len, together) = (
        field.len(),
        width(2) * whole_groups(axes[0].fourier.is_some(), grid.n[1]),
    );
    if last == 2 && len >= SHARED * exec.threads() * together {
        for_panels(exec, field, [1, len, together], scratch, |mut planes, scratch| {
            within(&Serial, planes.first() / grid.n[0], planes.row_mut(0), scratch);
        });
    } else {
        within(exec, 0, field, scratch);
    }
    columns(exec, last, Direction::Synthesis, field, scratch);
}

/// What [`across`] does to rows to multiply coefficients by the symbol of an operator: `symbol` is called with a row of the box, a range of the coefficients
/// along the first axis (even ones first), their values, and a slice for the new values.
pub fn multiplied<T: Real>(
    spectrum: &Spectrum<'_, T>,
    symbol: impl Fn(usize, Range<usize>, &[T], &mut [T]) + Sync,
) -> impl Fn(&dyn Exec, RowOf<'_>, &mut [T], &mut [T]) + Sync {
    move |exec, of, rows, scratch| {
        along_rows(exec, &spectrum.axes[0], rows, scratch, |row, span, old, new| {
            symbol(of(row), span, old, new);
        });
    }
}

/// Parts for each thread, at least, where what is done is cut into parts of planes.
const SHARED: usize = 4;

/// The fewest rows (or planes) of so many columns (or rows) each that hold whole groups of those that a fast transform takes together.
pub(super) fn whole_groups(is_fast: bool, each: usize) -> usize {
    if !is_fast {
        return 1;
    }
    (1..COLUMNS)
        .find(|count| (count * each).is_multiple_of(COLUMNS))
        .unwrap_or(COLUMNS)
}

/// Which way a transform goes.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Direction {
    /// From values to coefficients.
    Analysis,
    /// From coefficients to values.
    Synthesis,
}

/// Transforms `field` along an axis but the first, in place: slab after slab of so many rows of `width` values as the axis has cells.
pub(super) fn along_columns<T: Real>(
    exec: &dyn Exec,
    (modes, width): (&Modes<'_, T>, usize),
    direction: Direction,
    field: &mut [T],
    scratch: &mut [T],
) {
    let n = modes.cells();
    if let Some(fourier) = &modes.fourier {
        return for_panels(
            exec,
            field,
            [n, width, COLUMNS],
            scratch,
            |columns, scratch| match direction {
                Direction::Analysis => fast_axis::analyse_columns(fourier, columns, scratch),
                Direction::Synthesis => fast_axis::synthesise_columns(fourier, columns, scratch),
            },
        );
    }
    let folds = modes.folds;
    for_panels(exec, field, [n, width, PANEL], scratch, |mut columns, scratch| {
        let panel = Panel {
            n,
            count: columns.count(),
        };
        let (from, to) = scratch.split_at_mut(n * PANEL);
        let (from, to) = (&mut from[..panel.len()], &mut to[..panel.len()]);
        panel.read(&columns, direction, folds, from);
        panel.transform(modes, direction, from, to);
        panel.write(to, direction, folds, &mut columns);
    });
}

/// Some columns of a slab of `n` rows.
#[derive(Clone, Copy)]
struct Panel {
    n: usize,
    count: usize,
}

impl Panel {
    /// The columns that scratch holds: whole vectors.
    fn columns(self) -> usize {
        self.count.next_multiple_of(COLUMNS)
    }

    /// The length of the panel in scratch.
    fn len(self) -> usize {
        self.n * self.columns()
    }

    /// Where row `i` lies in scratch.
    fn in_scratch(self, i: usize) -> Range<usize> {
        let start = i * self.columns();
        start..start + self.count
    }

    /// Copies the columns: values to be analysed as the sums and differences of both halves of the axis, coefficients as they are.
    fn read<T: Real>(self, slab: &exec::Panel<'_, T>, direction: Direction, folds: bool, to: &mut [T]) {
        let n = self.n;
        if direction == Direction::Synthesis || !folds {
            return (0..n).for_each(|i| to[self.in_scratch(i)].copy_from_slice(slab.row(i)));
        }
        for i in 0..n / 2 {
            let (even, odd) = to.split_at_mut(Parity::Even.count(n) * self.columns());
            fold(
                slab.row(i),
                slab.row(n - 1 - i),
                &mut even[self.in_scratch(i)],
                &mut odd[self.in_scratch(i)],
            );
        }
        if n % 2 == 1 {
            to[self.in_scratch(n / 2)].copy_from_slice(slab.row(n / 2));
        }
    }

    /// Multiplies by the matrices of both parities.
    fn transform<T: Real>(self, modes: &Modes<'_, T>, direction: Direction, from: &[T], to: &mut [T]) {
        let columns = self.columns();
        let mut before = 0;
        for parity in PARITIES {
            let part = modes.count(parity);
            let matrix = match direction {
                Direction::Analysis => modes.analysis(parity),
                Direction::Synthesis => modes.synthesis(parity),
            };
            let range = before * columns..(before + part) * columns;
            product(matrix, part, &from[range.clone()], columns, &mut to[range]);
            before += part;
        }
    }

    /// The inverse of [`Self::read`].
    fn write<T: Real>(self, from: &[T], direction: Direction, folds: bool, slab: &mut exec::Panel<'_, T>) {
        let n = self.n;
        if direction == Direction::Analysis || !folds {
            return (0..n).for_each(|i| slab.row_mut(i).copy_from_slice(&from[self.in_scratch(i)]));
        }
        let (even, odd) = from.split_at(Parity::Even.count(n) * self.columns());
        for i in 0..n / 2 {
            let [low, high] = slab.pair(i, n - 1 - i);
            fold(&even[self.in_scratch(i)], &odd[self.in_scratch(i)], low, high);
        }
        if n % 2 == 1 {
            slab.row_mut(n / 2).copy_from_slice(&even[self.in_scratch(n / 2)]);
        }
    }
}

/// Transforms along the first axis, lets `symbol` change the coefficients, and transforms back, row by row of `field`.
fn along_rows<T: Real>(
    exec: &dyn Exec,
    modes: &Modes<'_, T>,
    field: &mut [T],
    scratch: &mut [T],
    symbol: impl Fn(usize, Range<usize>, &[T], &mut [T]) + Sync,
) {
    let (n, len) = (modes.cells(), field.len());
    let together = if modes.fourier.is_some() {
        COLUMNS
    } else {
        TOGETHER
    };
    for_panels(
        exec,
        field,
        [1, len, together * n],
        scratch,
        |mut group, scratch| {
            let first = group.first() / n;
            let symbol = |row: usize, span: Range<usize>, old: &[T], new: &mut [T]| {
                symbol(first + row, span, old, new)
            };
            let rows = group.row_mut(0);
            match &modes.fourier {
                Some(fourier) => fast_axis::along_rows(fourier, rows, scratch, symbol),
                None => along_short_rows(modes, rows, scratch, symbol),
            }
        },
    );
}

/// [`along_rows`] by matrices, of at most [`TOGETHER`] rows.
fn along_short_rows<T: Real>(
    modes: &Modes<'_, T>,
    rows: &mut [T],
    scratch: &mut [T],
    symbol: impl Fn(usize, Range<usize>, &[T], &mut [T]),
) {
    let n = modes.cells();
    let (halves, products) = scratch.split_at_mut(TOGETHER * n);
    let products = &mut products[..TOGETHER * padded(n)];
    let count = rows.len() / n;
    let (even, odd) = halves.split_at_mut(TOGETHER * modes.count(Parity::Even));
    if modes.folds {
        let parts = even
            .chunks_exact_mut(n.div_ceil(2))
            .zip(odd.chunks_exact_mut(n / 2));
        for (row, (even, odd)) in rows.chunks_exact(n).zip(parts) {
            fold_row(row, even, odd);
        }
    } else {
        even.iter_mut().zip(&*rows).for_each(|(to, &from)| *to = from);
    }
    let (mut first, mut column) = (0, 0);
    for parity in PARITIES {
        let part = modes.count(parity);
        if part == 0 {
            continue;
        }
        let columns = part.next_multiple_of(COLUMNS);
        let halves = &mut halves[TOGETHER * first..][..TOGETHER * part];
        let products = &mut products[column..][..TOGETHER * columns];
        product(halves, part, modes.analysis(parity), columns, products);
        let rows = products.chunks_exact(columns).zip(halves.chunks_exact_mut(part));
        for (row, (coefficients, out)) in rows.enumerate().take(count) {
            symbol(row, first..first + part, &coefficients[..part], out);
        }
        product(halves, part, modes.synthesis(parity), columns, products);
        (first, column) = (first + part, column + TOGETHER * columns);
    }
    let [even, odd] = PARITIES.map(|parity| modes.count(parity).next_multiple_of(COLUMNS));
    if !modes.folds {
        let whole = rows.chunks_exact_mut(n).zip(products.chunks_exact(even));
        return whole.for_each(|(row, values)| row.iter_mut().zip(values).for_each(|(to, &from)| *to = from));
    }
    let (evens, odds) = products.split_at(TOGETHER * even);
    let parts = evens.chunks_exact(even).zip(odds.chunks_exact(odd));
    for (row, (even, odd)) in rows.chunks_exact_mut(n).zip(parts) {
        unfold_row(even, odd, row);
    }
}

vectorised! {
    /// `out = A B`. A has rows of `depth` values, B and `out` have rows of `columns`, a multiple of [`COLUMNS`]. A has a multiple of
    /// [`TOGETHER`] rows, and those that `out` lacks are left out.
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
