//! Buoyancy in the flow (mathematics section 2): the momentum equation of v_k has b rho_k at the faces on its right-hand side,
//! rho at a face the mean of its two cells, 0 on walls and at closed faces.

use crate::exec::{Exec, RowBuffers, for_rows};
use crate::field::{Vector, VectorMut, reborrow, rows};
use crate::grid::solids::{Solids, closed};
use crate::grid::{Grid, Side};
use crate::real::Real;
use core::ops::Range;

/// B: the acceleration at faces by the density of cells, in trajectories of so many slots.
#[derive(Clone, Copy, Debug)]
pub struct Lift<'g> {
    /// The grid.
    pub grid: &'g Grid,
    /// Slots of the trajectories.
    pub slots: usize,
    /// The solid cells in it: at closed faces there is no buoyancy.
    pub solids: Solids<'g>,
    /// b: the acceleration where the density is 1, in scaled numbers.
    pub acceleration: [f64; 3],
}

impl Lift<'_> {
    /// Axis and half the acceleration along it, for all axes along which there is any.
    fn halves<T: Real>(&self, s: f64) -> impl Iterator<Item = (usize, T)> {
        let along = self.acceleration.into_iter().enumerate().take(self.grid.dims);
        along
            .filter(|&(_, b)| b != 0.0)
            .map(move |(axis, b)| (axis, T::from_f64(0.5 * s * b)))
    }

    /// `out += s B rho` in the slots `range`: in slot k, which is step k + 1, by field k + 1 of `rho`.
    pub fn add<T: Real>(
        &self,
        exec: &dyn Exec,
        s: f64,
        rho: &[T],
        range: Range<usize>,
        out: &mut VectorMut<'_, T>,
    ) {
        let (grid, cells, n) = (self.grid, self.grid.cells(), self.grid.n[0]);
        for_rows(exec, grid.rows(), RowBuffers::fields(reborrow(out)), |task| {
            for (axis, half) in self.halves::<T>(s) {
                for slot in range.clone() {
                    let rho = &rho[(slot + 1) * cells..][..cells];
                    let row = |row: usize| &rho[row * n..][..n];
                    let (here, out) = (row(task.row), &mut task.fields[axis][slot * n..][..n]);
                    if self.solids.there() {
                        let table = self.solids.row(n, task.row).iter();
                        for (x, (out, &bits)) in out.iter_mut().zip(table).enumerate() {
                            let low = grid.beside(grid.cell_at(task.row, x), axis, Side::Low);
                            if let (Some(low), true) = (low, bits & closed(axis) == 0) {
                                *out += half * (here[x] + rho[grid.index(low)]);
                            }
                        }
                        continue;
                    }
                    if axis == 0 {
                        rows::add_scaled(&mut out[1..], half, &here[1..]);
                        rows::add_scaled(&mut out[1..], half, &here[..n - 1]);
                        if grid.axis(0).is_ring() {
                            out[0] += half * here[0] + half * here[n - 1];
                        }
                    } else if let Some(low) = grid.neighbour(task.row, axis, Side::Low) {
                        rows::add_scaled(out, half, here);
                        rows::add_scaled(out, half, row(low));
                    }
                }
            }
        });
    }

    /// `mu += s B^T z_k` for the density of step `slot` + 1, by slot `slot` of z, which is 0 on walls and at closed faces.
    pub fn add_adjoint<T: Real>(&self, exec: &dyn Exec, s: f64, z: Vector<'_, T>, slot: usize, mu: &mut [T]) {
        let (grid, n, slots) = (self.grid, self.grid.n[0], self.slots);
        for_rows(exec, grid.rows(), RowBuffers::fields([mu]), |task| {
            let [mu] = task.fields;
            for (axis, half) in self.halves::<T>(s) {
                let row = |row: usize| &z[axis][(row * slots + slot) * n..][..n];
                let here = row(task.row);
                rows::add_scaled(mu, half, here);
                if axis == 0 {
                    rows::add_scaled(&mut mu[..n - 1], half, &here[1..]);
                    if grid.axis(0).is_ring() {
                        mu[n - 1] += half * here[0];
                    }
                } else if let Some(high) = grid.neighbour(task.row, axis, Side::High) {
                    rows::add_scaled(mu, half, row(high));
                }
            }
        });
    }
}
