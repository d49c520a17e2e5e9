//! The sum of the series.

use super::super::kernel::{Extremes, around};
use super::super::rows::{Cells, Rows, cells, faces};
use super::super::runs::{Sparse, each_run};
use super::super::terms::Terms;
use super::{MAX_TERMS, Series, VANISHED, previous};
use crate::exec::{Exec, RunTask, for_runs};
use crate::field::rows::{self, part, part_mut};
use crate::field::{borders, sums};
use crate::grid::halo::{self, BEFORE};
use crate::grid::stencil::Stencil;
use crate::real::Real;
use crate::simd::{self, vectorised};

/// The terms of the series from y_0 = `from`, and `total` = their sum with y_0 unless it is empty. Returns how many terms there
/// are, or `None` where `terms` has no room for all of them.
pub fn sum<T: Real>(
    exec: &dyn Exec,
    series: &Series<'_, T>,
    from: &[T],
    terms: Terms<&mut [T]>,
    total: &mut [T],
    scratch: &mut [T],
) -> Option<usize> {
    let (rows, stride) = (series.grid.rows(), terms.stride);
    for k in 1..=MAX_TERMS.min(terms.fields.len() / stride) {
        let (known, fields) = terms.fields.split_at_mut((k - 1) * stride);
        let (known_sizes, sizes) = terms.sizes.split_at_mut((k - 1) * rows);
        let known = Terms {
            fields: &*known,
            stride,
            sizes: &*known_sizes,
        };
        let before = previous(k, series.grid, from, &known);
        if add_term(exec, series, k, before, [fields, &mut *total, sizes], scratch) {
            return Some(k);
        }
    }
    None
}

/// As [`sum`], where `terms` has room for [`ROLLING`] terms: each takes the place of the one before the last.
pub fn sum_rolling<T: Real>(
    exec: &dyn Exec,
    series: &Series<'_, T>,
    from: &[T],
    terms: Terms<&mut [T]>,
    total: &mut [T],
    scratch: &mut [T],
) {
    let (mut next, mut last) = terms.fields.split_at_mut(terms.stride);
    let (mut next_sizes, mut last_sizes) = terms.sizes.split_at_mut(series.grid.rows());
    for k in 1..=MAX_TERMS {
        let before = if k == 1 {
            Sparse {
                cells: Cells::Plain(from),
                sizes: None,
            }
        } else {
            Sparse {
                cells: Cells::WithHalo(&*last),
                sizes: Some(&*last_sizes),
            }
        };
        let fields = [&mut *next, &mut *total, &mut *next_sizes];
        if add_term(exec, series, k, before, fields, scratch) {
            return;
        }
        core::mem::swap(&mut next, &mut last);
        core::mem::swap(&mut next_sizes, &mut last_sizes);
    }
}

/// Term `k`, made from the one `before`, what it adds to the total, and the sizes of its rows: `fields` in this order. Whether it is the
/// last.
fn add_term<T: Real>(
    exec: &dyn Exec,
    series: &Series<'_, T>,
    k: usize,
    before: Sparse<'_, T>,
    [to, total, sizes]: [&mut [T]; 3],
    scratch: &mut [T],
) -> bool {
    let grid = series.grid;
    let term = Term {
        series,
        k,
        from: before,
        scales: grid.h.map(|h| T::from_f64(series.tau / k as f64 / h)),
        negligible: T::from_f64(series.negligible),
    };
    let to = &mut to[..halo::field_len(grid)];
    let sizes = &mut sizes[..grid.rows()];
    let fields = [&mut *to, &mut *total, &mut *sizes];
    for_runs(exec, grid.rows(), fields, scratch, move |task| term.compute(task));
    borders::refresh(exec, grid, to);
    borders::refresh(exec, grid, sizes);
    let largest = sums::most(exec, grid, sizes.iter().map(|size| size.to_f64()));
    let last = k == MAX_TERMS || !(largest >= series.cut);
    if last {
        borders::refresh(exec, grid, total);
    }
    last
}

/// A term and what it is made from.
struct Term<'a, T> {
    series: &'a Series<'a, T>,
    k: usize,
    /// y_{k-1}.
    from: Sparse<'a, T>,
    /// tau / (k h).
    scales: [T; 3],
    /// What is smaller is set to 0.
    negligible: T,
}

/// Rows of a run to write.
struct Run<'t, T> {
    /// The term, with halos.
    to: &'t mut [T],
    /// The sum of all terms, or empty.
    total: &'t mut [T],
    /// A size a row.
    sizes: &'t mut [T],
}

impl<T: Real> Term<'_, T> {
    /// The term, what it adds to the total, and the sizes of its rows, in the rows of a task.
    fn compute(&self, task: RunTask<'_, T, 3>) {
        let grid = self.series.grid;
        let n = self.series.grid.n[0];
        let [to, total, sizes] = task.fields;
        let first = task.rows.start;
        let empty = |stencil: &Stencil, behind: usize| {
            self.from.is_empty(grid, stencil, behind, |size| size <= T::ZERO)
        };
        let scratch = task.scratch;
        each_run(grid, task.rows, self.k == 1, empty, |stencil, count, empty| {
            let (begin, end) = (stencil.row - first, stencil.row - first + count);
            let run = Run {
                to: part_mut(to, begin * halo::stride(n)..end * halo::stride(n)),
                total: part_mut(total, begin * n..end * n),
                sizes: part_mut(sizes, begin..end),
            };
            let before = self
                .from
                .sizes
                .map(|sizes| part(sizes, stencil.row..stencil.row + count));
            if empty {
                self.pass_over(before, run);
            } else {
                self.compute_run(stencil, before, run, scratch);
            }
        });
    }

    /// A run of rows around which y_{k-1} is 0.
    fn pass_over(&self, before: Option<&[T]>, run: Run<'_, T>) {
        run.to.fill(T::ZERO);
        match before {
            Some(before) => run.sizes.copy_from_slice(before),
            None => run.sizes.fill(T::ZERO),
        }
        if self.k == 1 {
            run.total.fill(T::ZERO);
        }
    }

    fn compute_run(&self, stencil: &Stencil, before: Option<&[T]>, run: Run<'_, T>, scratch: &mut [T]) {
        let series = self.series;
        let grid = self.series.grid;
        let n = self.series.grid.n[0];
        let input = Input {
            n,
            first: self.k == 1,
            cells: cells(grid, stencil, self.from.cells, scratch),
            faces: faces(grid, stencil, series.velocity),
            weights: series.weights,
            scales: &self.scales[..grid.dims],
            negligible: self.negligible,
        };
        let Run { to, total, sizes } = run;
        compute(to, total, sizes, &input);
        for (row, (to, size)) in to.chunks_exact_mut(halo::stride(n)).zip(sizes).enumerate() {
            let was = || match before.and_then(|sizes| sizes.get(row)) {
                Some(size) => size.to_f64(),
                None => rows::max_abs(&input.cells.own(row, BEFORE + n)[BEFORE..]),
            };
            if *size == T::ZERO && was() != 0.0 {
                *size = T::from_f64(VANISHED);
            }
            grid.axis(0).surround_cells(to);
        }
    }
}

/// What the kernel reads.
struct Input<'a, T> {
    /// Cells of a row.
    n: usize,
    /// Whether this is the first term, with which the total begins.
    first: bool,
    /// y_{k-1} in the rows of a run and around them.
    cells: Rows<'a, T>,
    faces: Rows<'a, T>,
    /// See [`super::weights`].
    weights: [T; 3],
    /// tau / (k h) of the grid's axes.
    scales: &'a [T],
    negligible: T,
}

vectorised! {
    /// Rows of a run of `to` = (tau / k) L y_{k-1}, what is negligible set to 0. `total` += `to` unless it is empty, or y_0 + `to` with the
    /// first term. `sizes` receives max |to| of every row, not finite when any value is not.
    fn compute[T, V](to: &mut [T], total: &mut [T], sizes: &mut [T], input: &Input<'_, T>) {
        let (n, apart) = (input.n, halo::stride(input.n));
        for (row, size) in sizes.iter_mut().enumerate() {
            let begin = row * apart + BEFORE;
            let to = part_mut(to, begin..begin + n);
            let total = part_mut(total, row * n..(row + 1) * n);
            let (mut extremes, mut rest) = (Extremes::<V>::none(), Extremes::<T>::none());
            let i = compute_from::<T, V>(0, row, to, total, input, &mut extremes);
            compute_from::<T, T>(i, row, to, total, input, &mut rest);
            let largest = T::from_f64(extremes.with(rest));
            // 0 where all was set to 0, not finite where any value was not.
            *size = if input.negligible > largest { T::ZERO } else { largest };
        }
    }
}

/// The inflow through the faces of cell c along an axis, `low` and `high`, the cells being a b c d e.
#[inline(always)]
fn inflow<T: Real, V: simd::Vector<Elem = T>>(
    [a, b, c, d, e]: [V; 5],
    [low, high]: [V; 2],
    [near, upstream, next]: [V; 3],
) -> V {
    let below = low * (near * low.select(c, b) + upstream * low.select(b, c) - next * low.select(a, d));
    let above = high * (near * high.select(d, c) + upstream * high.select(c, d) - next * high.select(b, e));
    below - above
}

/// The inflow along y or z to cells `c` at `i` of a row, from the rows of cells at -2, -1, 1, 2 and of faces at -1, 0, 1, 2.
#[inline(always)]
fn inflow_across<T: Real, V: simd::Vector<Elem = T>>(
    i: usize,
    c: V,
    cells: &[&[T]; 4],
    faces: &[&[T]; 4],
    weights: [V; 3],
) -> V {
    let through = [V::at(faces[1], i), V::at(faces[2], i)];
    inflow(around(cells, i, c), through, weights)
}

/// The kernel of [`compute`] from cell `i` as far as whole vectors go; returns the first cell that is left.
#[inline(always)]
fn compute_from<T: Real, V: simd::Vector<Elem = T>>(
    mut i: usize,
    row: usize,
    to: &mut [T],
    total: &mut [T],
    input: &Input<'_, T>,
    extremes: &mut Extremes<V>,
) -> usize {
    let n = to.len();
    let (summed, deep) = (!total.is_empty(), input.scales.len() > 2);
    let (x, faces_x) = (input.cells.own(row, n + 4), input.faces.own(row, n + 3));
    let (y, faces_y) = (input.cells.along(1, row, n), input.faces.along(1, row, n));
    let (z, faces_z) = if deep {
        (input.cells.along(2, row, n), input.faces.along(2, row, n))
    } else {
        (y, faces_y)
    };
    let (zero, negligible) = (V::splat(T::ZERO), V::splat(input.negligible));
    let [w0, w1, w2] = input.weights;
    let w = [V::splat(w0), V::splat(w1), V::splat(w2)];
    let (scale_x, scale_y) = (V::splat(input.scales[0]), V::splat(input.scales[1]));
    let scale_z = V::splat(if deep { input.scales[2] } else { T::ZERO });
    while i + V::LANES <= n {
        let c = V::at(x, i + 2);
        let along_x = [V::at(x, i), V::at(x, i + 1), c, V::at(x, i + 3), V::at(x, i + 4)];
        let through_x = [V::at(faces_x, i + 1), V::at(faces_x, i + 2)];
        let mut sum = scale_x * inflow(along_x, through_x, w);
        sum = sum + scale_y * inflow_across(i, c, &y, &faces_y, w);
        if deep {
            sum = sum + scale_z * inflow_across(i, c, &z, &faces_z, w);
        }
        let size = sum.max(-sum);
        extremes.take(sum, size);
        let sum = (negligible - size).select(zero, sum);
        sum.put(to, i);
        if summed {
            let before = if input.first { c } else { V::at(total, i) };
            (before + sum).put(total, i);
        }
        i += V::LANES;
    }
    i
}
