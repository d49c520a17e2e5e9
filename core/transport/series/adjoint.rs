//! The adjoint of the series, by which mu goes back through a sub-step, and the gradient by the velocity.

use super::super::kernel::{Layout, Read};
use super::super::rows::{Cells, cells, faces};
use super::super::runs::{Sparse, each_run};
use super::super::terms::{Backward, Terms};
use super::transposed::{Input, transposed};
use super::{Series, previous};
use crate::exec::{Exec, RunTask, for_runs};
use crate::field::rows::{part, part_mut};
use crate::field::{VectorMut, borders};
use crate::grid::Side;
use crate::grid::halo::{BEFORE, HALO, field_len};
use crate::grid::stencil::Stencil;
use crate::real::Real;

/// The adjoint of [`sum`](super::sum) from `from` with `last` terms: `mu` <- z_0 where z_last = mu and
/// z_{k-1} = mu + (tau / k) L^T z_k, and `gradient` += (tau / k) rho_f(y_{k-1}) (z_k[R] - z_k[L]) / h at every face, whose cells
/// are L on its low and R on its high side.
///
/// Rows around which y_0 .. y_{k-1} are 0 are passed over: what z is there meets no smoke on the way back, unless smoke that lies
/// perfectly still is let go beside rows that move. None is where it goes back everywhere.
pub fn adjoint<T: Real>(
    exec: &dyn Exec,
    series: &Series<'_, T>,
    from: &[T],
    terms: Terms<&[T]>,
    last: usize,
    backward: Backward<'_, T>,
    scratch: &mut [T],
) {
    let grid = series.grid;
    let len = series.grid.cells();
    let Backward {
        mu,
        work: [mut z, mut next],
        gradient: [g0, g1, g2],
        first,
    } = backward;
    for k in (1..=last).rev() {
        let mut term = Term {
            series,
            scales: grid.h.map(|h| T::from_f64(series.tau / k as f64 / h)),
            y: previous(k, grid, from, &terms),
            clear: first && k == last,
            mu: &[],
            z: Cells::WithHalo(z),
        };
        let gradient = [&mut *g0, &mut *g1, &mut *g2];
        // mu itself is the first z, and what the last is written to: a row of it is read by that row alone then.
        if k == last {
            let room = if k == 1 { len } else { field_len(grid) };
            (term.mu, term.z) = (&*mu, Cells::Plain(mu));
            take_back(exec, term, &mut next[..room], gradient, scratch);
        } else if k == 1 {
            take_back(exec, term, mu, gradient, scratch);
        } else {
            term.mu = &*mu;
            take_back(exec, term, &mut next[..field_len(grid)], gradient, scratch);
        }
        core::mem::swap(&mut z, &mut next);
    }
    if last == 1 {
        mu.copy_from_slice(&z[..len]);
    }
}

/// A term on the way back and what it reads.
struct Term<'a, T> {
    series: &'a Series<'a, T>,
    /// tau / (k h).
    scales: [T; 3],
    /// y_{k-1}.
    y: Sparse<'a, T>,
    /// Whether the gradient begins with this term.
    clear: bool,
    /// mu, or empty where z_{k-1} is written over it.
    mu: &'a [T],
    /// z_k.
    z: Cells<'a, T>,
}

/// `next` = mu + (tau / k) L^T z, or `next` += the latter where mu is empty, and the gradient's share.
fn take_back<T: Real>(
    exec: &dyn Exec,
    term: Term<'_, T>,
    next: &mut [T],
    [g0, g1, g2]: VectorMut<'_, T>,
    scratch: &mut [T],
) {
    let grid = term.series.grid;
    let fields = [&mut *next, g0, g1, g2];
    for_runs(exec, grid.rows(), fields, scratch, move |task| {
        term.compute(task);
    });
    borders::refresh(exec, grid, next);
}

/// Rows of a run to write.
struct Run<'t, T> {
    /// z_{k-1}.
    next: &'t mut [T],
    /// The gradient.
    gradient: VectorMut<'t, T>,
    layout: Layout,
}

impl<T: Real> Term<'_, T> {
    /// z_{k-1} and the gradient in the rows of a task.
    fn compute(&self, task: RunTask<'_, T, 4>) {
        let grid = self.series.grid;
        let n = self.series.grid.n[0];
        let [next, mut gradient @ ..] = task.fields;
        let first = task.rows.start;
        if self.clear {
            gradient.iter_mut().for_each(|component| component.fill(T::ZERO));
        }
        let layout = Layout::new(n, next.len(), task.rows.len());
        let Layout { apart, before, .. } = layout;
        let single = matches!(self.z, Cells::Plain(_)) || matches!(self.y.cells, Cells::Plain(_));
        let everywhere = self.series.everywhere;
        let empty = |stencil: &Stencil, behind: usize| {
            !everywhere && self.y.is_empty(grid, stencil, behind, |size| size == T::ZERO)
        };
        let scratch = task.scratch;
        each_run(grid, task.rows, single, empty, |stencil, count, empty| {
            let (begin, end) = (stencil.row - first, stencil.row - first + count);
            let mu = part(self.mu, stencil.row * n..(stencil.row + count) * n);
            let next = part_mut(next, begin * apart..end * apart);
            if !empty {
                let gradient = gradient
                    .each_mut()
                    .map(|component| part_mut(component, begin * n..end * n));
                let run = Run {
                    next: &mut *next,
                    gradient,
                    layout,
                };
                self.compute_run(stencil, mu, run, scratch);
            } else if !mu.is_empty() {
                for (next, mu) in next.chunks_exact_mut(apart).zip(mu.chunks_exact(n)) {
                    next[before..before + n].copy_from_slice(mu);
                }
            }
            if before > 0 {
                next.chunks_exact_mut(apart)
                    .for_each(|next| grid.axis(0).surround_cells(next));
            }
        });
    }

    fn compute_run(&self, stencil: &Stencil, mu: &[T], run: Run<'_, T>, scratch: &mut [T]) {
        let series = self.series;
        let grid = self.series.grid;
        let Run {
            next,
            mut gradient,
            layout,
        } = run;
        let (of_z, of_y) = scratch.split_at_mut(layout.n + HALO);
        let input = Input {
            read: Read {
                z: cells(grid, stencil, self.z, of_z),
                y: cells(grid, stencil, self.y.cells, of_y),
                faces: faces(grid, stencil, series.velocity),
            },
            weights: series.weights,
            scales: &self.scales[..grid.dims],
        };
        transposed(next, mu, &mut gradient, layout, &input);
        let Layout { n, apart, before } = layout;
        for (row, next) in next.chunks_exact_mut(apart).enumerate() {
            self.fold_at_walls(stencil, row, &mut next[before..before + n], &input);
        }
    }

    /// At a wall the last cell stands for the missing one further upstream, and so takes its share too.
    fn fold_at_walls(&self, stencil: &Stencil, row: usize, out: &mut [T], input: &Input<'_, T>) {
        let Read { z, faces, .. } = &input.read;
        let grid = self.series.grid;
        let n = out.len();
        let scales = self.scales;
        let w = input.weights[2];
        let (c, through) = (&z.own(row, n + BEFORE)[BEFORE..], faces.own(row, n + 1));
        if grid.axis(0).cell(-1).is_none() {
            out[0] -= scales[0] * w * through[2].max(T::ZERO) * (c[1] - c[0]);
        }
        if grid.axis(0).cell(n as isize).is_none() {
            out[n - 1] -= scales[0] * w * through[n].min(T::ZERO) * (c[n - 1] - c[n - 2]);
        }
        for axis in 1..grid.dims {
            if stencil.at_wall(axis, Side::Low) {
                let (above, high) = (z.along(axis, row, n)[2], faces.along(axis, row, n)[2]);
                for i in 0..n {
                    out[i] -= scales[axis] * w * high[i].max(T::ZERO) * (above[i] - c[i]);
                }
            }
            if stencil.at_wall(axis, Side::High) {
                let (below, low) = (z.along(axis, row, n)[1], faces.along(axis, row, n)[1]);
                for i in 0..n {
                    out[i] -= scales[axis] * w * low[i].min(T::ZERO) * (c[i] - below[i]);
                }
            }
        }
    }
}
