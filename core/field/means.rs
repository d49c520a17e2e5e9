//! The mean of every slot of a trajectory of cells.

use super::sums::{NOTHING, over_ranks};
use crate::exec::{Exec, RowBuffers, for_rows};
use crate::field::rows;
use crate::grid::Grid;
use crate::real::Real;

/// The length of `sums` in [`remove`].
#[must_use]
pub fn sums_len(grid: &Grid, slots: usize) -> usize {
    grid.rows() * slots
}

/// Subtracts from every slot of `field`, a trajectory of cells, its mean. `sums` holds [`sums_len`] values.
pub fn remove<T: Real>(exec: &dyn Exec, grid: &Grid, slots: usize, field: &mut [T], sums: &mut [f64]) {
    let (nx, rows) = (grid.n[0], grid.rows());
    let sums = &mut sums[..rows * slots];
    for_rows(
        exec,
        rows,
        RowBuffers::fields([&mut *field]).with_sums(&mut *sums),
        |task| {
            let [field] = task.fields;
            for (row, sum) in field.chunks_exact(nx).zip(task.sums) {
                *sum = rows::sum(row);
            }
        },
    );
    let means = add_up(exec, grid, slots, sums);
    let cells = grid.whole().cells() as f64;
    means.iter_mut().for_each(|mean| *mean /= cells);
    let means = &*means;
    for_rows(exec, rows, RowBuffers::fields([field]), |task| {
        let [field] = task.fields;
        for (row, &mean) in field.chunks_exact_mut(nx).zip(means) {
            let mean = T::from_f64(mean);
            row.iter_mut().for_each(|x| *x -= mean);
        }
    });
}

/// Adds up what the rows have of every slot, in the place of the first row, and on from rank to rank.
fn add_up<'s>(exec: &dyn Exec, grid: &Grid, slots: usize, of_rows: &'s mut [f64]) -> &'s mut [f64] {
    let own = grid.own_rows();
    let (totals, others) = of_rows.split_at_mut(slots);
    let go_on = |totals: &mut [f64]| {
        // The first row of a rank that others come before is a copy: the sums that it goes on with are in its place.
        let rest = own.start.max(1) - 1..own.end - 1;
        for row in others.chunks_exact(slots).skip(rest.start).take(rest.len()) {
            totals.iter_mut().zip(row).for_each(|(total, sum)| *total += sum);
        }
    };
    if own.start > 0 {
        totals.fill(NOTHING);
    }
    over_ranks(exec, grid, totals, go_on);
    totals
}
