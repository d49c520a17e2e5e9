//! The three stages of a sub-step.

use super::super::kernel::{Extremes, Layout};
use super::super::rows::{Cells, Rows, cells, faces};
use super::super::runs::{Sparse, each_run, long_rows};
use super::limiter::{Numbers, inflow, inflow_across, opening};
use super::{KEEP, KEPT, Substep};
use crate::exec::{Exec, RunTask, for_runs};
use crate::field::borders;
use crate::field::rows::{self, part, part_mut};
use crate::grid::halo;
use crate::grid::stencil::Stencil;
use crate::real::Real;
use crate::simd::{self, vectorised};
use crate::transport::terms::Terms;
use core::ops::Range;

/// rho' from rho = `from`; `to` may be empty. Stages a and b go to `stages`, whose rows have halos, with max |x| of each row. Returns
/// how many stages there are, or `None` where `stages` has no room for them.
pub fn forward<T: Real>(
    exec: &dyn Exec,
    substep: &Substep<'_, T>,
    from: &[T],
    stages: Terms<&mut [T]>,
    to: &mut [T],
    scratch: &mut [T],
) -> Option<usize> {
    let (grid, rows) = (substep.grid, substep.grid.rows());
    let len = halo::field_len(grid);
    let (first, second) = stages.fields.split_at_mut_checked(stages.stride)?;
    let (first_sizes, second_sizes) = stages.sizes.split_at_mut_checked(rows)?;
    let (first, second) = (first.get_mut(..len)?, second.get_mut(..len)?);
    let second_sizes = second_sizes.get_mut(..rows)?;
    let flowing = Sparse {
        cells: Cells::Plain(from),
        sizes: None,
    };
    let stage = |k: usize, flowing| Stage::new(substep, k, from, flowing);
    stage(0, flowing).run(exec, first, first_sizes, scratch);
    stage(1, halo_field(first, first_sizes)).run(exec, second, second_sizes, scratch);
    if !to.is_empty() {
        stage(2, halo_field(second, second_sizes)).run(exec, to, &mut [], scratch);
    }
    Some(KEPT)
}

/// A stage whose rows have halos and sizes.
fn halo_field<'a, T>(field: &'a [T], sizes: &'a [T]) -> Sparse<'a, T> {
    Sparse {
        cells: Cells::WithHalo(field),
        sizes: Some(sizes),
    }
}

/// A stage and what it is made from.
struct Stage<'a, T> {
    substep: &'a Substep<'a, T>,
    rho: &'a [T],
    /// rho, a or b.
    flowing: Sparse<'a, T>,
    /// What is kept of rho; the rest is of what flows.
    keep: T,
    scales: [T; 3],
}

/// Rows of a run to write.
struct Run<'t, T> {
    to: &'t mut [T],
    sizes: &'t mut [T],
    layout: Layout,
}

impl<'a, T: Real> Stage<'a, T> {
    fn new(substep: &'a Substep<'a, T>, k: usize, rho: &'a [T], flowing: Sparse<'a, T>) -> Self {
        Self {
            substep,
            rho,
            flowing,
            keep: T::from_f64(KEEP.get(k).copied().unwrap_or(0.0)),
            scales: substep.scales().map(T::from_f64),
        }
    }

    /// The stage in all rows: in `to`, with halos where it has room for them, and the sizes of its rows unless that is empty.
    fn run(&self, exec: &dyn Exec, to: &mut [T], sizes: &mut [T], scratch: &mut [T]) {
        let grid = self.substep.grid;
        let fields = [&mut *to, &mut *sizes];
        for_runs(exec, grid.rows(), fields, scratch, |task| self.compute(task));
        borders::refresh(exec, grid, to);
        borders::refresh(exec, grid, sizes);
    }

    fn compute(&self, task: RunTask<'_, T, 2>) {
        let (grid, n) = (self.substep.grid, self.substep.grid.n[0]);
        let ([to, sizes], first) = (task.fields, task.rows.start);
        let layout = Layout::new(n, to.len(), task.rows.len());
        let apart = layout.apart;
        let empty = |stencil: &Stencil, behind: usize| {
            self.flowing
                .is_empty(grid, stencil, behind, |size| size == T::ZERO)
        };
        let single = long_rows(grid) || matches!(self.flowing.cells, Cells::Plain(_));
        let scratch = task.scratch;
        each_run(grid, task.rows, single, empty, |stencil, count, empty| {
            let (begin, end) = (stencil.row - first, stencil.row - first + count);
            let run = Run {
                to: part_mut(to, begin * apart..end * apart),
                sizes: part_mut(sizes, begin..end),
                layout,
            };
            let rho = part(self.rho, stencil.row * n..(stencil.row + count) * n);
            if empty {
                self.pass_over(rho, run);
            } else {
                self.compute_run(stencil, rho, run, scratch);
            }
        });
    }

    /// A run of rows around which nothing flows: rho's share alone.
    fn pass_over(&self, rho: &[T], run: Run<'_, T>) {
        let Layout { n, apart, before } = run.layout;
        let mut sizes = run.sizes.iter_mut();
        for (to, rho) in run
            .to
            .chunks_exact_mut(apart.max(1))
            .zip(rho.chunks_exact(n.max(1)))
        {
            rows::scale(part_mut(to, before..before + n), self.keep, rho);
            if let Some(size) = sizes.next() {
                *size = T::from_f64(rows::max_abs(part(to, before..before + n)));
            }
            self.surround(to, before);
        }
    }

    fn surround(&self, row: &mut [T], before: usize) {
        if before > 0 {
            self.substep.grid.axis(0).surround_cells(row);
        }
    }

    fn compute_run(&self, stencil: &Stencil, rho: &[T], run: Run<'_, T>, scratch: &mut [T]) {
        let Run { to, sizes, layout } = run;
        let grid = self.substep.grid;
        let among_solids = self.substep.among_solids();
        let input = Input {
            layout,
            cells: cells(grid, stencil, self.flowing.cells, scratch),
            faces: faces(grid, stencil, self.substep.velocity),
            open: among_solids.then(|| faces(grid, stencil, self.substep.open)),
            span: self.flowing.extent(grid, stencil),
            keep: self.keep,
            scales: part(&self.scales, 0..grid.dims),
            negligible: T::from_f64(self.substep.negligible),
        };
        if among_solids {
            compute_among_solids(to, sizes, rho, &input);
        } else {
            compute(to, sizes, rho, &input);
        }
        to.chunks_exact_mut(layout.apart.max(1))
            .for_each(|row| self.surround(row, layout.before));
    }
}

/// What the kernel reads.
struct Input<'a, T> {
    /// Of the output.
    layout: Layout,
    /// What flows, in the rows of a run and around them.
    cells: Rows<'a, T>,
    faces: Rows<'a, T>,
    /// Which faces are open, where there are solid cells.
    open: Option<Rows<'a, T>>,
    /// The cells to which there is a flux.
    span: Range<usize>,
    /// What is kept of rho; the rest is of what flows.
    keep: T,
    /// tau / h of the grid's axes.
    scales: &'a [T],
    negligible: T,
}

vectorised! {
    /// Rows of a run of `to` = p rho + (1 - p) (x + tau L x), what is negligible set to 0. `sizes`, unless empty, receives max |to| of every
    /// row, not finite when any value is not.
    fn compute[T, V](to: &mut [T], sizes: &mut [T], rho: &[T], input: &Input<'_, T>) {
        compute_rows::<T, V, false>(to, sizes, rho, input);
    }
}

vectorised! {
    /// As [`compute`], among solid cells.
    fn compute_among_solids[T, V](to: &mut [T], sizes: &mut [T], rho: &[T], input: &Input<'_, T>) {
        compute_rows::<T, V, true>(to, sizes, rho, input);
    }
}

#[inline(always)]
fn compute_rows<T: Real, V: simd::Vector<Elem = T>, const SOLIDS: bool>(
    to: &mut [T],
    sizes: &mut [T],
    rho: &[T],
    input: &Input<'_, T>,
) {
    let Layout { n, apart, before } = input.layout;
    let mut sizes = sizes.iter_mut();
    for (row, (to, rho)) in to
        .chunks_exact_mut(apart.max(1))
        .zip(rho.chunks_exact(n.max(1)))
        .enumerate()
    {
        let to = part_mut(to, before..before + n);
        let (mut extremes, mut rest) = (Extremes::<V>::none(), Extremes::<T>::none());
        let mut largest = 0.0;
        if input.span.len() < n {
            largest = keep_outside(&input.span, input.keep, to, rho);
        }
        let i = compute_from::<T, V, SOLIDS>(input.span.start, row, to, rho, input, &mut extremes);
        compute_from::<T, T, SOLIDS>(i, row, to, rho, input, &mut rest);
        if let Some(size) = sizes.next() {
            let largest = T::from_f64(rows::largest([largest, extremes.with(rest)]));
            *size = if input.negligible > largest {
                T::ZERO
            } else {
                largest
            };
        }
    }
}

/// Outside of `span` rho's share alone; max |to| there.
#[inline(never)]
fn keep_outside<T: Real>(span: &Range<usize>, keep: T, to: &mut [T], rho: &[T]) -> f64 {
    rows::largest([0..span.start, span.end..to.len()].map(|outside| {
        let to = part_mut(to, outside.clone());
        rows::scale(to, keep, part(rho, outside));
        rows::max_abs(to)
    }))
}

/// The kernel of [`compute`] from cell `i` as far as whole vectors go; returns the first cell that is left.
#[inline(always)]
fn compute_from<T: Real, V: simd::Vector<Elem = T>, const SOLIDS: bool>(
    mut i: usize,
    row: usize,
    to: &mut [T],
    rho: &[T],
    input: &Input<'_, T>,
    extremes: &mut Extremes<V>,
) -> usize {
    let (n, last) = (to.len(), input.scales.len() - 1);
    let rho = &rho[..n];
    let (x, faces_x) = (input.cells.own(row, n + 4), input.faces.own(row, n + 3));
    let (y, faces_y) = (input.cells.along(1, row, n), input.faces.along(1, row, n));
    let (z, faces_z) = (input.cells.along(last, row, n), input.faces.along(last, row, n));
    let open = input.open.filter(|_| SOLIDS).unwrap_or(input.faces);
    let open_x = open.own(row, n + 3);
    let open_x = [&open_x[..n], &open_x[1..], &open_x[2..], &open_x[3..]];
    let (open_y, open_z) = (open.along(1, row, n), open.along(last, row, n));
    let numbers = Numbers::<V>::new();
    let (zero, negligible) = (numbers.zero, V::splat(input.negligible));
    let keep = V::splat(input.keep);
    let (scale_x, scale_y) = (V::splat(input.scales[0]), V::splat(input.scales[1]));
    let scale_z = V::splat(input.scales[last]);
    let end = input.span.end.min(n);
    while i + V::LANES <= end {
        let c = V::at(x, i + 2);
        let along_x = [V::at(x, i), V::at(x, i + 1), c, V::at(x, i + 3), V::at(x, i + 4)];
        let through_x = [V::at(faces_x, i + 1), V::at(faces_x, i + 2)];
        let open_here = opening::<T, V, SOLIDS>(&open_x, i, c);
        let mut sum = scale_x * inflow::<V, SOLIDS>(numbers, along_x, through_x, open_here);
        sum = sum + scale_y * inflow_across::<T, V, SOLIDS>(numbers, i, c, &y, &faces_y, &open_y);
        if last > 1 {
            sum = sum + scale_z * inflow_across::<T, V, SOLIDS>(numbers, i, c, &z, &faces_z, &open_z);
        }
        // p rho + q moved with p + q = 1, so that smoke at rest keeps every bit.
        let moved = c + sum;
        let value = moved + keep * (V::at(rho, i) - moved);
        let size = value.max(-value);
        extremes.take(value, size);
        (negligible - size).select(zero, value).put(to, i);
        i += V::LANES;
    }
    i
}
