//! Sums and maxima over trajectories, row by row: the same bits for any number of threads.

use super::Vector;
use super::rows::{self, part_mut};
use crate::exec::ranks::{Along, in_order, joined, tell};
use crate::exec::{Exec, Ranks, RowBuffers, for_rows};
use crate::grid::Grid;
use crate::real::Real;

/// What a sum begins with, as that of an iterator does: the sum of nothing but -0 is -0.
pub const NOTHING: f64 = -0.0;

/// Adds up what every row has, as [`over_rows`] does.
pub fn add_up(exec: &dyn Exec, grid: &Grid, of_rows: &[f64]) -> f64 {
    let mut sum = [0.0];
    add_up_each(exec, grid, of_rows, &mut sum);
    sum[0]
}

/// The same of each of as many sums as there are `totals`, of which every row has its own one after the other.
pub fn add_up_each(exec: &dyn Exec, grid: &Grid, of_rows: &[f64], totals: &mut [f64]) {
    let count = totals.len();
    over_rows(exec.ranks(), grid, totals, |row, which| {
        of_rows.get(row * count + which).copied().unwrap_or(0.0)
    });
}

/// Sums of planes that go on from rank to rank in one message, at most.
const TOGETHER: usize = 1 << 8;

/// Adds up what `of` tells of every row for each of `totals`: the rows of a plane in their order, and the sums of planes in theirs. Where ranks share the
/// box each goes on with what the one before it found, those with rows of the same planes for each plane, and those with other planes after all of these;
/// what copies have counts for nothing.
pub fn over_rows(ranks: &dyn Ranks, grid: &Grid, totals: &mut [f64], of: impl Fn(usize, usize) -> f64) {
    let on = |sum: f64, plane: usize, which: usize| {
        grid.own_rows(plane).fold(sum, |sum, row| sum + of(row, which))
    };
    totals.fill(NOTHING);
    let Some(parts) = grid.parts() else {
        for plane in 0..grid.planes() {
            for (which, total) in totals.iter_mut().enumerate() {
                *total += on(NOTHING, plane, which);
            }
        }
        return;
    };
    let (planes, rows) = (parts.share.along_planes(), parts.share.along_rows());
    let (own, each) = (grid.own_planes(), totals.len().max(1));
    let of_planes = |totals: &mut [f64]| {
        for begin in (0..own.len() * each).step_by(TOGETHER) {
            let mut sums = [NOTHING; TOGETHER];
            let sums = part_mut(&mut sums, 0..TOGETHER.min(own.len() * each - begin));
            let place = |index: usize| (own.start + (begin + index) / each, (begin + index) % each);
            in_order(&Along::new(ranks, rows), sums, |sums| {
                for (index, sum) in sums.iter_mut().enumerate() {
                    let (plane, which) = place(index);
                    *sum = on(*sum, plane, which);
                }
            });
            for (index, &sum) in sums.iter().enumerate() {
                let (_, which) = place(index);
                totals
                    .iter_mut()
                    .skip(which)
                    .take(1)
                    .for_each(|total| *total += sum);
            }
        }
    };
    // Only the last of those that share planes knows their sums.
    if rows.place + 1 == rows.count {
        in_order(&Along::new(ranks, planes), totals, of_planes);
    } else {
        of_planes(totals);
    }
    tell(ranks, ranks.count() - 1, totals);
}

/// The largest of what every row has in all ranks, NaN when any is.
pub fn most(exec: &dyn Exec, grid: &Grid, of_rows: impl Iterator<Item = f64>) -> f64 {
    if !grid.is_part() {
        return rows::largest(of_rows);
    }
    let own = of_rows.enumerate().filter(|(row, _)| grid.is_own(*row));
    let largest = rows::largest(own.map(|(_, value)| value));
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
