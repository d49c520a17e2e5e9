//! Conjugate gradients on fields of faces (Hestenes & Stiefel 1952).

use crate::exec::{Exec, RowBuffers, for_rows};
use crate::field::trajectory::{Shape, dot};
use crate::field::{Vector, VectorMut, rows, view};
use crate::grid::Grid;
use crate::real::Real;
use crate::transport::Stop;

/// When they stop.
#[derive(Clone, Copy, Debug)]
pub struct Goal {
    /// At |r| of this part of |right-hand side|.
    pub tolerance: f64,
    /// Steps at most.
    pub steps: usize,
    /// |right-hand side|^2.
    pub size: f64,
    /// |r|^2 that is rounding, at which they stop too.
    pub least: f64,
}

/// Right-hand sides of this squared size are 0: smoke of 1e-20 underflows.
const NOTHING: f64 = 1e-24;

/// What is solved: writes A q for a q.
pub type Apply<'a, T> = dyn FnMut(Vector<'_, T>, &mut VectorMut<'_, T>, &mut [f64]) -> Result<(), Stop> + 'a;

/// The fields of a solve: x, at first a guess, r, at first what that leaves of the right-hand side, q and A q.
pub struct Fields<'f, 'a, T> {
    /// The solution.
    pub x: &'f mut VectorMut<'a, T>,
    /// The residual.
    pub r: &'f mut VectorMut<'a, T>,
    /// The direction.
    pub q: &'f mut VectorMut<'a, T>,
    /// Its image.
    pub image: &'f mut VectorMut<'a, T>,
}

/// Solves A x = right-hand side; how many products by A it took.
///
/// # Errors
/// Those of `apply`.
pub fn solve<T: Real>(
    exec: &dyn Exec,
    grid: &Grid,
    fields: Fields<'_, '_, T>,
    goal: Goal,
    sums: &mut [f64],
    apply: &mut Apply<'_, T>,
) -> Result<usize, Stop> {
    let Fields { x, r, q, image } = fields;
    let shape = Shape { grid, slots: 1 };
    let mut left = dot(exec, shape, view(r), view(r), sums);
    q.iter_mut().zip(r.iter()).for_each(|(q, r)| q.copy_from_slice(r));
    for step in 0..goal.steps {
        let enough = (goal.tolerance * goal.tolerance * goal.size).max(goal.least);
        if !(goal.size > NOTHING) || left <= enough {
            return Ok(step);
        }
        apply(view(q), image, sums)?;
        let curvature = dot(exec, shape, view(q), view(image), sums);
        if !(curvature > 0.0) {
            return Ok(step + 1);
        }
        let next = advance(
            exec,
            grid,
            left / curvature,
            [view(q), view(image)],
            [&mut *x, &mut *r],
            sums,
        );
        turn(exec, grid, next / left, view(r), q);
        left = next;
    }
    Ok(goal.steps)
}

/// `x += s q`, `r -= s A q`; |r|^2.
fn advance<T: Real>(
    exec: &dyn Exec,
    grid: &Grid,
    s: f64,
    [q, image]: [Vector<'_, T>; 2],
    [x, r]: [&mut VectorMut<'_, T>; 2],
    sums: &mut [f64],
) -> f64 {
    let (n, s) = (grid.n[0], T::from_f64(s));
    let sums = rows::part_mut(sums, 0..grid.rows());
    let ([x0, x1, x2], [r0, r1, r2]) = (
        x.each_mut().map(|part| &mut **part),
        r.each_mut().map(|part| &mut **part),
    );
    let buffers = RowBuffers::fields([x0, x1, x2, r0, r1, r2]).with_sums(&mut *sums);
    for_rows(exec, grid.rows(), buffers, |task| {
        let span = task.row * n..(task.row + 1) * n;
        let [x0, x1, x2, r0, r1, r2] = task.fields;
        let mut squares = 0.0;
        for (axis, (x, r)) in [(x0, r0), (x1, r1), (x2, r2)]
            .into_iter()
            .enumerate()
            .take(grid.dims)
        {
            rows::add_scaled(x, s, rows::part(q[axis], span.clone()));
            rows::add_scaled(r, -s, rows::part(image[axis], span.clone()));
            squares += rows::sum_squares(r);
        }
        task.sums.fill(squares);
    });
    sums.iter().sum()
}

/// `q = r + s q`.
fn turn<T: Real>(exec: &dyn Exec, grid: &Grid, s: f64, r: Vector<'_, T>, q: &mut VectorMut<'_, T>) {
    let (n, s) = (grid.n[0], T::from_f64(s));
    let fields = q.each_mut().map(|part| &mut **part);
    for_rows(exec, grid.rows(), RowBuffers::fields(fields), |task| {
        for (axis, q) in task.fields.into_iter().enumerate().take(grid.dims) {
            rows::combine(q, s, rows::part(r[axis], task.row * n..(task.row + 1) * n));
        }
    });
}
