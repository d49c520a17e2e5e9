//! Sums and maxima over trajectories, row by row: the same bits for any number of threads.

use super::{Vector, rows};
use crate::exec::ranks::{in_order, joined};
use crate::exec::{Exec, Ranks, RowBuffers, for_rows};
use crate::grid::Grid;
use crate::real::Real;

/// What a sum begins with, as that of an iterator does: the sum of nothing but -0 is -0.
pub const NOTHING: f64 = -0.0;

/// Adds up what every row has, in the order of rows, and on from rank to rank.
pub fn add_up(exec: &dyn Exec, grid: &Grid, of_rows: &[f64]) -> f64 {
    let mut sum = [0.0];
    add_up_each(exec, grid, of_rows, &mut sum);
    sum[0]
}

/// The same of each of as many sums as there are `totals`, of which every row has its own one after the other.
pub fn add_up_each(exec: &dyn Exec, grid: &Grid, of_rows: &[f64], totals: &mut [f64]) {
    let count = totals.len();
    let go_on = |own: &[f64], totals: &mut [f64]| {
        for (which, total) in totals.iter_mut().enumerate() {
            let own = own.iter().skip(which).step_by(count);
            *total = own.fold(*total, |sum, own| sum + own);
        }
    };
    totals.fill(NOTHING);
    if !grid.is_part() {
        return go_on(of_rows, totals);
    }
    let rows = grid.own_rows();
    let own = of_rows.get(count * rows.start..count * rows.end).unwrap_or(&[]);
    over_ranks(exec, grid, totals, |totals| go_on(own, totals));
}

/// Sums that `own` goes on with over the rows of `grid` that are no copies, and on from rank to rank where it is a part.
pub fn over_ranks(exec: &dyn Exec, grid: &Grid, totals: &mut [f64], own: impl FnOnce(&mut [f64])) {
    if grid.is_part() {
        in_order(exec.ranks(), totals, own);
    } else {
        own(totals);
    }
}

/// The largest of what every row has in all ranks, NaN when any is.
pub fn most(exec: &dyn Exec, grid: &Grid, of_rows: impl Iterator<Item = f64>) -> f64 {
    if !grid.is_part() {
        return rows::largest(of_rows);
    }
    let own = grid.own_rows();
    let largest = rows::largest(of_rows.skip(own.start).take(own.len()));
    largest_of(exec.ranks(), largest)
}

/// The largest of all ranks' values, NaN when any is.
pub fn largest_of(ranks: &dyn Ranks, value: f64) -> f64 {
    joined(ranks, value, |x, y| rows::largest([x, y]))
}

/// `of(row)` for every row, collected in `sums` and added up in order.
pub fn total<F: Fn(usize) -> f64 + Sync>(exec: &dyn Exec, grid: &Grid, sums: &mut [f64], of: F) -> f64 {
    add_up(exec, grid, fill(exec, grid, sums, of))
}

/// The largest `of(row)`, NaN when any is.
pub fn largest<F: Fn(usize) -> f64 + Sync>(exec: &dyn Exec, grid: &Grid, sums: &mut [f64], of: F) -> f64 {
    most(exec, grid, fill(exec, grid, sums, of).iter().copied())
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
