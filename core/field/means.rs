//! The mean of every slot of a trajectory of cells.

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
    let (means, others) = sums.split_at_mut(slots);
    for row in others.chunks_exact(slots) {
        means.iter_mut().zip(row).for_each(|(mean, sum)| *mean += sum);
    }
    means.iter_mut().for_each(|mean| *mean /= grid.cells() as f64);
    let means = &*means;
    for_rows(exec, rows, RowBuffers::fields([field]), |task| {
        let [field] = task.fields;
        for (row, &mean) in field.chunks_exact_mut(nx).zip(means) {
            let mean = T::from_f64(mean);
            row.iter_mut().for_each(|x| *x -= mean);
        }
    });
}
