//! Where force may act: its price is that of the force divided by a mask.
//!
//! The mask m of a face is the mean of its two cells' and at least [`LEAST`], where force is so dear that there is none. The price of a
//! force u is r/2 sum_k f_k <D u_k, (1 + s^2 C^T C) D u_k> with D = 1 / m, so that z_k = f_k D (1 + s^2 C^T C) D u_k is its derivative
//! over r. Other than without a mask, z has to be projected before it is a derivative along fields free of divergence.

use crate::exec::{Exec, RowBuffers, for_rows};
use crate::field::rows::{part, part_mut};
use crate::field::{VectorMut, reborrow};
use crate::grid::{Grid, Side};
use crate::real::Real;
use core::ops::Range;

/// The least value of a mask at a face: a force there costs a million times as much.
pub const LEAST: f64 = 1e-3;

/// What a field is to be done to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum By {
    /// Times m, or times this where that is more.
    Factor(f64),
    /// Divided by m.
    Divisor,
}

/// A mask on a grid, for trajectories of so many slots.
#[derive(Clone, Copy, Debug)]
pub struct Mask<'a, T> {
    /// The grid.
    pub grid: &'a Grid,
    /// Slots of the trajectories.
    pub slots: usize,
    /// The mask of cells, 0 to 1; empty where force may act everywhere.
    pub cells: &'a [T],
}

impl<T: Real> Mask<'_, T> {
    /// Whether there is one.
    #[must_use]
    pub fn there(&self) -> bool {
        !self.cells.is_empty()
    }

    /// Multiplies `field` in the slots `range` by the mask of its faces, or divides it by that.
    pub fn weigh(&self, exec: &dyn Exec, by: By, range: Range<usize>, field: &mut VectorMut<'_, T>) {
        if !self.there() {
            return;
        }
        let (grid, n) = (self.grid, self.grid.n[0]);
        for_rows(exec, grid.rows(), RowBuffers::fields(reborrow(field)), |task| {
            let row = |row: usize| part(self.cells, row * n..(row + 1) * n);
            let here = row(task.row);
            for (axis, field) in task.fields.into_iter().enumerate().take(grid.dims) {
                for slot in range.clone() {
                    let field = part_mut(field, slot * n..(slot + 1) * n);
                    if axis == 0 {
                        // On a wall the value is 0 whatever the mask.
                        let before = here.last().copied().filter(|_| grid.axis(0).is_ring());
                        let before = before.or_else(|| here.first().copied());
                        weigh_row(by, here, before.into_iter().chain(here.iter().copied()), field);
                    } else {
                        let low = grid.neighbour(task.row, axis, Side::Low).map_or(here, row);
                        weigh_row(by, here, low.iter().copied(), field);
                    }
                }
            }
        });
    }
}

/// A row of faces, whose cells are `here` and `low`.
fn weigh_row<T: Real>(by: By, here: &[T], low: impl Iterator<Item = T>, field: &mut [T]) {
    let least = T::from_f64(match by {
        By::Factor(least) => least,
        By::Divisor => LEAST,
    });
    for ((value, &here), low) in field.iter_mut().zip(here).zip(low) {
        let mask = (T::HALF * (here + low)).max(least);
        *value = match by {
            By::Factor(_) => *value * mask,
            By::Divisor => *value / mask,
        };
    }
}
