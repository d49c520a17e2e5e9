//! How much coordinates that ride on a flow are stretched.

use crate::exec::{Exec, RowBuffers, for_rows};
use crate::field::Vector;
use crate::grid::Grid;
use crate::real::Real;

/// `out` = s >= 1 at cells for coordinates c = x + `drift`: s^2 = |grad c|^2 - (d - 1), which is 1 where nothing is stretched, and 1 + g^2 where
/// c is sheared by g. Differences are those of the two cells beside.
pub fn fill<T: Real>(exec: &dyn Exec, grid: &Grid, drift: Vector<'_, T>, out: &mut [T]) {
    for_rows(exec, grid.rows(), RowBuffers::fields([out]), |task| {
        let [out] = task.fields;
        for (x, out) in out.iter_mut().enumerate() {
            let here = grid.cell_at(task.row, x);
            let mut square = 1.0 - grid.dims as f64;
            for along in 0..grid.dims {
                let beside = |step: isize| {
                    let mut at = here;
                    at[along] = grid.axis(along).nearest(here[along] as isize + step);
                    at
                };
                let (low, high) = (beside(-1), beside(1));
                // At a wall they are one cell apart.
                let apart = if grid.axis(along).is_ring() {
                    2
                } else {
                    high[along].abs_diff(low[along]).max(1)
                };
                for (axis, drift) in drift.into_iter().enumerate().take(grid.dims) {
                    let value = |at| drift.get(grid.index(at)).map_or(0.0, |value| value.to_f64());
                    let slope = (value(high) - value(low)) / apart as f64;
                    let own = if axis == along { 1.0 } else { 0.0 };
                    square += (own + slope) * (own + slope);
                }
            }
            *out = T::from_f64(libm::sqrt(square.max(1.0)));
        }
    });
}
