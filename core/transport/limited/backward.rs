//! The adjoint of a sub-step, stage by stage backward, and the gradient by the velocity.
//!
//! With mu the adjoint of rho' and L'(x) the derivative of L at x:
//!
//! ```text
//! z_b = 2/3 (mu + tau L'(b)^T mu)           z_a = 1/4 (z_b + tau L'(a)^T z_b)
//! mu <- 1/3 mu + 3/4 z_b + z_a + tau L'(rho)^T z_a
//! ```

use super::super::kernel::{Layout, Read};
use super::super::rows::{Cells, cells, faces};
use super::super::runs::{Sparse, each_run, long_rows};
use super::transposed::{Input, Output, transposed, transposed_among_solids};
use super::{KEEP, Substep};
use crate::exec::{Exec, RunTask, for_runs};
use crate::field::borders;
use crate::field::rows::{part, part_mut};
use crate::grid::halo::{HALO, field_len};
use crate::grid::stencil::Stencil;
use crate::real::Real;
use crate::transport::terms::{Backward, Terms};

/// The adjoint of [`forward`](super::forward()) from rho = `from`, whose stages a and b are `stages`.
///
/// Rows around which nothing flows are passed over, unless it goes back everywhere: no smoke is there that a velocity could move.
pub fn backward<T: Real>(
    exec: &dyn Exec,
    substep: &Substep<'_, T>,
    from: &[T],
    stages: Terms<&[T]>,
    back: Backward<'_, T>,
    scratch: &mut [T],
) {
    let (grid, rows) = (substep.grid, substep.grid.rows());
    let kept = |stage: usize| Sparse {
        cells: Cells::WithHalo(part(
            stages.fields,
            stage * stages.stride..(stage + 1) * stages.stride,
        )),
        sizes: stages.sizes.get(stage * rows..(stage + 1) * rows),
    };
    let rho = Sparse {
        cells: Cells::Plain(from),
        sizes: None,
    };
    let Backward {
        mu,
        work: [of_b, of_a],
        gradient: [g0, g1, g2],
        first,
    } = back;
    let [of_b, of_a] = [of_b, of_a].map(|field| part_mut(field, 0..field_len(grid)));
    let last = Stage {
        clear: first,
        ..Stage::new(substep, 2, kept(1), Cells::Plain(mu))
    };
    last.run(exec, [of_b, &mut [], &mut *g0, &mut *g1, &mut *g2], scratch);
    let middle = Stage::new(substep, 1, kept(0), Cells::WithHalo(of_b));
    middle.run(exec, [of_a, mu, &mut *g0, &mut *g1, &mut *g2], scratch);
    let first = Stage::new(substep, 0, rho, Cells::WithHalo(of_a));
    first.run(exec, [&mut [], mu, g0, g1, g2], scratch);
}

/// A stage on the way back and what it reads.
struct Stage<'a, T> {
    substep: &'a Substep<'a, T>,
    /// What flowed: rho, a or b.
    y: Sparse<'a, T>,
    /// The adjoint of the stage.
    z: Cells<'a, T>,
    /// What the adjoint of y takes of z + tau L'(y)^T z.
    share: T,
    /// What mu keeps, and what it takes.
    of_mu: [T; 2],
    scales: [T; 3],
    /// Whether the gradient begins with this stage.
    clear: bool,
}

impl<'a, T: Real> Stage<'a, T> {
    /// Stage `k`: y's share is passed on to the stage before. rho's shares of the last and the middle stage go to mu with the middle
    /// one, and all of the first stage's.
    fn new(substep: &'a Substep<'a, T>, k: usize, y: Sparse<'a, T>, z: Cells<'a, T>) -> Self {
        let [_, of_middle, of_last] = KEEP;
        let of_mu = if k == 0 { [1.0, 1.0] } else { [of_last, of_middle] };
        Self {
            substep,
            y,
            z,
            share: T::from_f64(KEEP.get(k).map_or(1.0, |keep| 1.0 - keep)),
            of_mu: of_mu.map(T::from_f64),
            scales: substep.scales().map(T::from_f64),
            clear: false,
        }
    }

    /// Writes [the next z, mu, gradient] in all rows; the first two where they are not empty.
    fn run(&self, exec: &dyn Exec, mut fields: [&mut [T]; 5], scratch: &mut [T]) {
        let grid = self.substep.grid;
        let all = fields.each_mut().map(|field| &mut **field);
        for_runs(exec, grid.rows(), all, scratch, |task| self.compute(task));
        let [next, mu, ..] = fields;
        borders::refresh(exec, grid, next);
        borders::refresh(exec, grid, mu);
    }

    fn compute(&self, task: RunTask<'_, T, 5>) {
        let (grid, n) = (self.substep.grid, self.substep.grid.n[0]);
        let ([next, mu, mut gradient @ ..], first) = (task.fields, task.rows.start);
        if self.clear {
            gradient.iter_mut().for_each(|component| component.fill(T::ZERO));
        }
        let layout = Layout::new(n, next.len(), task.rows.len());
        let apart = layout.apart;
        let plain = |cells: Cells<'_, T>| matches!(cells, Cells::Plain(_));
        let single = long_rows(grid) || plain(self.z) || plain(self.y.cells);
        let everywhere = self.substep.everywhere;
        let empty = |stencil: &Stencil, behind: usize| {
            !everywhere && self.y.is_empty(grid, stencil, behind, |size| size == T::ZERO)
        };
        let scratch = task.scratch;
        each_run(grid, task.rows, single, empty, |stencil, count, empty| {
            let (begin, end) = (stencil.row - first, stencil.row - first + count);
            let mut output = Output {
                next: part_mut(next, begin * apart..end * apart),
                mu: part_mut(mu, begin * n..end * n),
                gradient: gradient
                    .each_mut()
                    .map(|component| part_mut(component, begin * n..end * n)),
                layout,
            };
            self.compute_run(stencil, count, &mut output, empty, scratch);
            for next in output.next.chunks_exact_mut(apart) {
                grid.axis(0).surround_cells(next);
            }
        });
    }

    fn compute_run(
        &self,
        stencil: &Stencil,
        count: usize,
        output: &mut Output<'_, T>,
        still: bool,
        scratch: &mut [T],
    ) {
        let grid = self.substep.grid;
        let among_solids = self.substep.among_solids();
        let (of_z, of_y) = scratch.split_at_mut(grid.n[0] + HALO);
        let n = grid.n[0];
        let flowing = if still || self.substep.everywhere {
            0..n
        } else {
            self.y.extent(grid, stencil)
        };
        let mut input = Input {
            count,
            read: Read {
                z: cells(grid, stencil, self.z, of_z),
                y: cells(grid, stencil, self.y.cells, of_y),
                faces: faces(grid, stencil, self.substep.velocity),
            },
            open: among_solids.then(|| faces(grid, stencil, self.substep.open)),
            scales: part(&self.scales, 0..grid.dims),
            share: self.share,
            of_mu: self.of_mu,
            still,
            span: flowing.clone(),
        };
        let mut run = |input: &Input<'_, T>| {
            if among_solids {
                transposed_among_solids(output, input);
            } else {
                transposed(output, input);
            }
        };
        run(&input);
        // The ends of a long row.
        input.still = true;
        for outside in [0..flowing.start, flowing.end..n] {
            if !outside.is_empty() {
                input.span = outside;
                run(&input);
            }
        }
    }
}
