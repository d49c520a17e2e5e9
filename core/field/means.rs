//! The mean of every slot of a trajectory of cells.

use super::rows::part_mut;
use super::sums::over_rows;
use crate::exec::{Exec, RowBuffers, for_rows};
use crate::field::rows;
use crate::grid::Grid;
use crate::real::Real;

/// Slots whose sums are found together.
const TOGETHER: usize = 64;

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

/// Adds up what the rows have of every slot, in the place of the first row.
fn add_up<'s>(exec: &dyn Exec, grid: &Grid, slots: usize, of_rows: &'s mut [f64]) -> &'s mut [f64] {
    for first in (0..slots).step_by(TOGETHER) {
        let mut totals = [0.0; TOGETHER];
        let totals = part_mut(&mut totals, 0..TOGETHER.min(slots - first));
        over_rows(exec.ranks(), grid, totals, |row, which| {
            of_rows.get(row * slots + first + which).copied().unwrap_or(0.0)
        });
        part_mut(of_rows, first..first + totals.len()).copy_from_slice(totals);
    }
    part_mut(of_rows, 0..slots)
}
