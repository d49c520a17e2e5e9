//! Buoyancy in the flow (mathematics section 2): the momentum equation of v_k has b rho_k at the faces on its right-hand side,
//! rho at a face the mean of its two cells, 0 on walls and at closed faces.

use crate::exec::{Exec, RowBuffers, for_rows};
use crate::field::rows::{self, part, part_mut};
use crate::field::{Vector, VectorMut, borders, reborrow};
use crate::grid::solids::{Solids, closed, exit};
use crate::grid::{Grid, Side};
use crate::memory::Pool;
use crate::real::Real;
use core::ops::Range;

/// B: the acceleration at faces by the density of cells, in trajectories of so many slots.
#[derive(Clone, Copy, Debug)]
pub struct Lift<'g> {
    /// The grid.
    pub grid: &'g Grid,
    /// Slots of the trajectories.
    pub slots: usize,
    /// The solid cells in it: at closed faces and exits there is no buoyancy.
    pub solids: Solids<'g>,
    /// b: the acceleration where the density is 1, in scaled numbers.
    pub acceleration: [f64; 3],
}

impl Lift<'_> {
    /// Whether nothing is pushed.
    fn is_none(&self) -> bool {
        self.acceleration == [0.0; 3]
    }

    /// Takes a field for B rho: a trajectory of faces along the axes that have any buoyancy.
    pub fn take<'a, T: Real>(&self, pool: &mut Pool<'a, T>) -> VectorMut<'a, T> {
        let len = self.grid.cells() * self.slots;
        pool.line("buoyancy at faces", |pool| {
            self.acceleration.map(|b| match b {
                0.0 => Default::default(),
                _ => pool.take("component", len),
            })
        })
    }

    /// Half of `s` times the acceleration along an axis, if there is any.
    fn half<T: Real>(&self, axis: usize, s: f64) -> Option<T> {
        let along = self.acceleration.get(axis).filter(|_| axis < self.grid.dims);
        along.filter(|&&b| b != 0.0).map(|b| T::from_f64(0.5 * s * b))
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
        let cells = self.grid.cells();
        let of_slot = |slot: usize| part(rho, (slot + 1) * cells..(slot + 2) * cells);
        self.add_of(exec, s, of_slot, range, out);
    }

    /// `out += B rho` for fields of one slot.
    pub fn add_now<T: Real>(&self, exec: &dyn Exec, rho: &[T], out: &mut VectorMut<'_, T>) {
        self.add_of(exec, 1.0, |_| rho, 0..1, out);
    }

    /// `out += s B rho` in the slots `range`, by what `rho` gives of each.
    fn add_of<'r, T: Real>(
        &self,
        exec: &dyn Exec,
        s: f64,
        rho: impl Fn(usize) -> &'r [T] + Sync,
        range: Range<usize>,
        out: &mut VectorMut<'_, T>,
    ) {
        if self.is_none() {
            return;
        }
        let (grid, n) = (self.grid, self.grid.n[0]);
        for_rows(exec, grid.rows(), RowBuffers::fields(reborrow(out)), |task| {
            for (axis, out) in task.fields.into_iter().enumerate() {
                let Some(half) = self.half::<T>(axis, s) else {
                    continue;
                };
                let low = match axis {
                    0 => Some(task.row),
                    _ => grid.neighbour(task.row, axis, Side::Low),
                };
                let Some(low) = low else { continue };
                for slot in range.clone() {
                    let rho = rho(slot);
                    let [here, low] = [task.row, low].map(|row| part(rho, row * n..(row + 1) * n));
                    let out = part_mut(out, slot * n..(slot + 1) * n);
                    let open = self.solids.row(n, task.row);
                    if axis == 0 {
                        let ring = grid.axis(0).is_ring();
                        let before = here.last().copied().filter(|_| ring);
                        let low = core::iter::once(before).chain(here.iter().copied().map(Some));
                        add_open(out, half, here, low, open, axis);
                    } else {
                        add_open(out, half, here, low.iter().copied().map(Some), open, axis);
                    }
                }
            }
        });
    }

    /// `mu += s B^T z_k` for the density of step `slot` + 1, by slot `slot` of z, which is 0 on walls and at closed faces, but not at exits.
    pub fn add_adjoint<T: Real>(&self, exec: &dyn Exec, s: f64, z: Vector<'_, T>, slot: usize, mu: &mut [T]) {
        if self.is_none() {
            return;
        }
        let (grid, n, slots) = (self.grid, self.grid.n[0], self.slots);
        for_rows(exec, grid.rows(), RowBuffers::fields([&mut *mu]), |task| {
            let [mu] = task.fields;
            for (axis, z) in z.into_iter().enumerate() {
                let Some(half) = self.half::<T>(axis, s) else {
                    continue;
                };
                let row = |row: usize| part(z, (row * slots + slot) * n..(row * slots + slot + 1) * n);
                let here = row(task.row);
                let add = |mu: &mut [T], faces: &[T], bits: &[u16]| {
                    if grid.is_open() {
                        add_inside(mu, half, faces, bits, axis);
                    } else {
                        rows::add_scaled(mu, half, faces);
                    }
                };
                let bits = self.solids.row(n, task.row);
                add(mu, here, bits);
                if axis == 0 {
                    add(mu, here.get(1..).unwrap_or(&[]), bits.get(1..).unwrap_or(&[]));
                    if let (true, Some(last), Some(&first)) =
                        (grid.axis(0).is_ring(), mu.last_mut(), here.first())
                    {
                        *last += half * first;
                    }
                } else if let Some(high) = grid.neighbour(task.row, axis, Side::High) {
                    add(mu, row(high), self.solids.row(n, high));
                }
            }
        });
        borders::refresh(exec, grid, mu);
    }
}

/// `mu += half z` for faces that are no exits.
fn add_inside<T: Real>(mu: &mut [T], half: T, faces: &[T], solids: &[u16], axis: usize) {
    for ((mu, &face), bits) in mu.iter_mut().zip(faces).zip(solids) {
        if bits & exit(axis) == 0 {
            *mu += half * face;
        }
    }
}

/// `out += half (here + low)` at the open faces of a row: those with a cell below them that no solid cell closes, and no exits.
fn add_open<T: Real>(
    out: &mut [T],
    half: T,
    here: &[T],
    low: impl Iterator<Item = Option<T>>,
    solids: &[u16],
    axis: usize,
) {
    let bits = solids.iter().copied().chain(core::iter::repeat(0));
    for (((out, &here), low), bits) in out.iter_mut().zip(here).zip(low).zip(bits) {
        if let (Some(low), 0) = (low, bits & (closed(axis) | exit(axis))) {
            *out += half * (here + low);
        }
    }
}
