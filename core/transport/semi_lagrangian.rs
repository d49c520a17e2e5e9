//! Semi-Lagrangian transport (Stam 1999): every cell takes the density from where its centre was, linearly interpolated.
//!
//! rho'(x) = rho(x - tau v(x)), v the mean of the cell's faces; places beyond a wall are moved to the last cell centre. A
//! sub-step goes at most one cell along each axis, so both the map and its transpose gather from the 3^d cells around.

use super::rows::Velocity;
use crate::exec::{Exec, RowBuffers, for_rows};
use crate::field::{VectorMut, borders};
use crate::grid::{Grid, Side};
use crate::real::Real;

/// One sub-step and what its adjoint reads.
pub struct Step<'a, T> {
    /// The grid.
    pub grid: &'a Grid,
    /// Velocity at faces.
    pub velocity: Velocity<'a, T>,
    /// Length of the sub-step.
    pub tau: f64,
    /// Density before.
    pub rho: &'a [T],
    /// Adjoint after.
    pub mu: &'a [T],
}

/// Where a cell's density comes from along one axis: two cells, the weight of the second, whether it moves with v, and whether it is the cell itself
/// since v is 0.
#[derive(Clone, Copy)]
struct Origin {
    cells: [usize; 2],
    weight: f64,
    moves: bool,
    rests: bool,
}

/// The origins of cell `at`, one for each axis.
fn origins<T: Real>(grid: &Grid, velocity: Velocity<'_, T>, tau: f64, at: [usize; 3]) -> [Origin; 3] {
    core::array::from_fn(|axis| {
        if axis >= grid.dims {
            return Origin {
                cells: [0, 0],
                weight: 0.0,
                moves: false,
                rests: false,
            };
        }
        let line = grid.axis(axis);
        let low = |[x, y, z]: [usize; 3]| velocity.low(grid.n[0], axis, grid.row(y, z))[x].to_f64();
        let v = 0.5 * (low(at) + grid.beside(at, axis, Side::High).map_or(0.0, low));
        // Places are those in the whole box, so that every rank that shares it rounds alike.
        let first = grid.in_whole(axis, at[axis]) as isize - at[axis] as isize;
        let place = (at[axis] as isize + first) as f64 - tau * v / grid.h[axis];
        let (place, moves) = grid.whole_axis(axis).nearest_point(place);
        let low = libm::floor(place);
        Origin {
            cells: [0, 1].map(|next| line.nearest(low as isize - first + next)),
            weight: place - low,
            moves,
            rests: v == 0.0,
        }
    })
}

/// The 2^d cells a density comes from, with their weights; `weight(axis, side)` gives the factors.
fn corners(
    grid: &Grid,
    origins: &[Origin; 3],
    weight: impl Fn(usize, usize) -> f64,
    mut visit: impl FnMut(usize, f64),
) {
    for corner in 0..1usize << grid.dims {
        let side = |axis: usize| corner >> axis & 1;
        let product: f64 = (0..grid.dims).map(|axis| weight(axis, side(axis))).product();
        let at = core::array::from_fn(|axis| {
            if axis < grid.dims {
                origins[axis].cells[side(axis)]
            } else {
                0
            }
        });
        visit(grid.index(at), product);
    }
}

fn linear(origin: &Origin, side: usize) -> f64 {
    if side == 1 {
        origin.weight
    } else {
        1.0 - origin.weight
    }
}

/// `to(x) = from(x - tau v(x))`.
pub fn trace<T: Real>(
    exec: &dyn Exec,
    grid: &Grid,
    velocity: Velocity<'_, T>,
    tau: f64,
    from: &[T],
    to: &mut [T],
) {
    for_rows(exec, grid.rows(), RowBuffers::fields([&mut *to]), |task| {
        let [to] = task.fields;
        for (x, to) in to.iter_mut().enumerate() {
            let origins = origins(grid, velocity, tau, grid.cell_at(task.row, x));
            let mut sum = 0.0;
            corners(
                grid,
                &origins,
                |axis, side| linear(&origins[axis], side),
                |at, w| sum += w * from[at].to_f64(),
            );
            *to = T::from_f64(sum);
        }
    });
    borders::refresh(exec, grid, to);
}

/// `to` = transpose of [`trace`] applied to mu: every cell gathers from the cells around whose origin it is.
pub fn adjoint<T: Real>(exec: &dyn Exec, step: &Step<'_, T>, to: &mut [T]) {
    let grid = step.grid;
    for_rows(exec, grid.rows(), RowBuffers::fields([&mut *to]), |task| {
        let [to] = task.fields;
        for (x, to) in to.iter_mut().enumerate() {
            let here = grid.cell_at(task.row, x);
            let mut sum = 0.0;
            around(grid, here, |source| {
                let origins = origins(grid, step.velocity, step.tau, source);
                let mut share = 0.0;
                corners(
                    grid,
                    &origins,
                    |axis, side| linear(&origins[axis], side),
                    |at, w| share += if at == grid.index(here) { w } else { 0.0 },
                );
                sum += share * step.mu[grid.index(source)].to_f64();
            });
            *to = T::from_f64(sum);
        }
    });
    borders::refresh(exec, grid, to);
}

/// Visits the cells at most one away along each axis, each once.
fn around(grid: &Grid, at: [usize; 3], mut visit: impl FnMut([usize; 3])) {
    let near = |axis: usize| {
        let mut list: heapless::Vec<usize, 3> = heapless::Vec::new();
        for offset in -1..=1isize {
            if let Some(i) = grid
                .axis(axis)
                .cell(at[axis] as isize + offset)
                .filter(|i| !list.contains(i))
            {
                let _ = list.push(i);
            }
        }
        list
    };
    let (xs, ys, zs) = (near(0), near(1), near(2));
    for &z in &zs {
        for &y in &ys {
            for &x in &xs {
                visit([x, y, z]);
            }
        }
    }
}

/// `gradient` += the derivative of <mu, trace(rho)> by the velocity at each face.
pub fn gradient<T: Real>(exec: &dyn Exec, step: &Step<'_, T>, gradient: VectorMut<'_, T>) {
    let grid = step.grid;
    for_rows(exec, grid.rows(), RowBuffers::fields(gradient), |task| {
        for (axis, out) in task.fields.into_iter().enumerate().take(grid.dims) {
            for (x, out) in out.iter_mut().enumerate() {
                let high = grid.cell_at(task.row, x);
                if let Some(low) = grid.beside(high, axis, Side::Low) {
                    *out += T::from_f64(by_cell(step, axis, high) + by_cell(step, axis, low));
                }
            }
        }
    });
}

/// The derivative of <mu, trace(rho)> by one face of cell `at` along `axis`, through that cell's origin.
fn by_cell<T: Real>(step: &Step<'_, T>, axis: usize, at: [usize; 3]) -> f64 {
    let grid = step.grid;
    let origins = origins(grid, step.velocity, step.tau, at);
    let Origin { moves, rests, .. } = origins[axis];
    if !moves && !rests {
        return 0.0;
    }
    let slope = |origins: &[Origin; 3]| {
        let weight = |other: usize, side: usize| {
            if other == axis {
                [-1.0, 1.0][side]
            } else {
                linear(&origins[other], side)
            }
        };
        let mut slope = 0.0;
        corners(grid, origins, weight, |at, w| slope += w * step.rho[at].to_f64());
        slope
    };
    let mut slope_here = slope(&origins);
    // Interpolation has a kink at a cell's centre, where cells at rest come from: neither side is better than the other. Beside a wall one of the sides
    // is a place that is moved back.
    if rests {
        let mut below = origins;
        below[axis].cells = [grid.axis(axis).nearest(at[axis] as isize - 1), at[axis]];
        slope_here = 0.5 * (slope_here + slope(&below));
    }
    step.mu[grid.index(at)].to_f64() * slope_here * -0.5 * step.tau / grid.h[axis]
}
