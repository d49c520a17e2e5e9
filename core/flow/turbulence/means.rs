//! What a grid of half as many cells an axis holds of a flow, and what it does not.

use crate::exec::{Exec, RowBuffers, for_rows};
use crate::field::{Vector, rows};
use crate::flow::resample::{Kind, resample};
use crate::grid::Grid;
use crate::grid::levels::coarsen;
use crate::grid::taps::{Taps, Transfer, taps};
use crate::real::Real;

/// Fields of the grid that [`unresolved`] works in.
pub const FIELDS: usize = 5;

/// `out` = R `field`: on `coarse` the means over its cells.
pub fn halve<T: Real>(exec: &dyn Exec, [fine, coarse]: [&Grid; 2], field: &[T], out: &mut [T]) {
    let of = |axis: usize, i: usize| {
        if axis < fine.dims {
            taps(Transfer::RestrictCell, i, fine.axis(axis), coarse.axis(axis))
        } else {
            Taps::from_iter([(0, 1.0)])
        }
    };
    let out = rows::part_mut(out, 0..coarse.cells());
    for_rows(exec, coarse.rows(), RowBuffers::fields([out]), |task| {
        let [out] = task.fields;
        let [y, z] = coarse.row_at(task.row);
        let (in_y, in_z) = (of(1, y), of(2, z));
        for (x, out) in out.iter_mut().enumerate() {
            let in_x = of(0, x);
            let mut sum = 0.0;
            for &(z, weight_z) in &in_z {
                for &(y, weight_y) in &in_y {
                    for &(x, weight_x) in &in_x {
                        let value = field
                            .get(fine.index([x, y, z]))
                            .map_or(0.0, |value| value.to_f64());
                        sum += weight_z * weight_y * weight_x * value;
                    }
                }
            }
            *out = T::from_f64(sum);
        }
    });
}

/// `out` = e = 1/2 |v - U R v|^2 at cells, U the cubic resampling: the energy of waves of two to four cells. 0 where no axis halves.
pub fn unresolved<T: Real>(
    exec: &dyn Exec,
    grid: &Grid,
    v: Vector<'_, T>,
    out: &mut [T],
    [own, means, back, first, second]: [&mut [T]; FIELDS],
) {
    out.fill(T::ZERO);
    let Some(coarse) = coarsen(grid) else {
        return;
    };
    for (axis, v) in v.into_iter().enumerate().take(grid.dims) {
        at_cells(exec, grid, axis, v, own);
        halve(exec, [grid, &coarse], own, means);
        resample(
            exec,
            [&coarse, grid],
            (Kind::Cells, 1.0),
            means,
            back,
            [&mut *first, &mut *second],
        );
        for ((out, &own), &back) in out.iter_mut().zip(&*own).zip(&*back) {
            *out += T::HALF * (own - back) * (own - back);
        }
    }
}

/// `out` = the component `v` at cells, the mean of two faces.
fn at_cells<T: Real>(exec: &dyn Exec, grid: &Grid, axis: usize, v: &[T], out: &mut [T]) {
    for_rows(exec, grid.rows(), RowBuffers::fields([out]), |task| {
        let [out] = task.fields;
        for (x, out) in out.iter_mut().enumerate() {
            let cell = grid.cell_at(task.row, x);
            let value = |at: [usize; 3]| v.get(grid.index(at)).copied().unwrap_or(T::ZERO);
            let mut next = cell;
            let after = grid.axis(axis).open_face(cell[axis] as isize + 1);
            let after = after.map_or(T::ZERO, |face| {
                next[axis] = face;
                value(next)
            });
            *out = T::HALF * (value(cell) + after);
        }
    });
}
