//! Sums and maxima over trajectories, row by row: the same bits for any number of threads.

use super::{Vector, rows};
use crate::exec::{Exec, RowBuffers, for_rows};
use crate::grid::Grid;
use crate::real::Real;

/// `of(row)` for every row, collected in `sums` and added up in order.
pub fn total<F: Fn(usize) -> f64 + Sync>(exec: &dyn Exec, grid: &Grid, sums: &mut [f64], of: F) -> f64 {
    fill(exec, grid, sums, of).iter().sum()
}

/// The largest `of(row)`, NaN when any is.
pub fn largest<F: Fn(usize) -> f64 + Sync>(exec: &dyn Exec, grid: &Grid, sums: &mut [f64], of: F) -> f64 {
    rows::largest(fill(exec, grid, sums, of).iter().copied())
}

fn fill<'a, F: Fn(usize) -> f64 + Sync>(
    exec: &dyn Exec,
    grid: &Grid,
    sums: &'a mut [f64],
    of: F,
) -> &'a [f64] {
    let sums = &mut sums[..grid.rows()];
    for_rows(
        exec,
        grid.rows(),
        RowBuffers::<f64, 0>::sums(&mut *sums),
        |task| {
            task.sums[0] = of(task.row);
        },
    );
    sums
}

/// A row of all slots of one component.
pub fn row<'a, T>(grid: &Grid, slots: usize, field: &'a [T], row: usize) -> &'a [T] {
    let len = slots * grid.n[0];
    &field[row * len..(row + 1) * len]
}

/// max |v| over all faces and slots.
pub fn max_abs<T: Real>(
    exec: &dyn Exec,
    grid: &Grid,
    slots: usize,
    v: Vector<'_, T>,
    sums: &mut [f64],
) -> f64 {
    largest(exec, grid, sums, |r| {
        rows::largest((0..grid.dims).map(|a| rows::max_abs(row(grid, slots, v[a], r))))
    })
}

/// The sum of squares over all faces and slots.
pub fn sum_squares<T: Real>(
    exec: &dyn Exec,
    grid: &Grid,
    slots: usize,
    v: Vector<'_, T>,
    sums: &mut [f64],
) -> f64 {
    total(exec, grid, sums, |r| {
        (0..grid.dims)
            .map(|a| rows::sum_squares(row(grid, slots, v[a], r)))
            .sum()
    })
}
