//! A step of the flow and the same step backwards, in the fields of a simulation.
//!
//! ```text
//! v1 = v + f + buoyancy rho,   v2 = diffuse(v1),   v3 = project(v2),   v4 = advect(v3 by v3),   v' = project(v4)
//! rho2 = diffuse(rho),   rho' = advect(rho2 by v')
//! ```

use super::advect::advect;
use super::advect_back::{density_adjoint, velocity_adjoint};
use super::cells::Cells;
use super::fields::{Flow, Parts, pitch, take_vector};
use super::project::{project, project_adjoint};
use super::sweeps::{diffuse, diffuse_adjoint};
use crate::exec::Exec;
use crate::field::{Vector, VectorMut, reborrow, view};
use crate::grid::Grid;
use crate::real::Real;

impl<T: Real> Flow<'_, T> {
    /// One step from the state at hand, with the force that is set.
    pub fn advance(&mut self, exec: &dyn Exec) {
        let (cells, grid, physics) = (self.cells, self.grid, self.physics);
        let Parts {
            mut v3,
            mut v,
            rho2,
            rho,
            mut room,
            kept: [first, second],
            force,
            ..
        } = self.parts();
        add_forces(
            exec,
            &cells,
            physics.buoyancy,
            (view(&v), rho, view(&force)),
            &mut v3,
        );
        let viscous = (physics.viscosity, physics.sweeps);
        for (axis, v3) in v3.iter_mut().enumerate().take(cells.dims) {
            diffuse(exec, &cells, viscous, Some(axis), v3, room.fields);
        }
        project(exec, (&cells, &grid), physics.solve, &mut v3, &mut room, first);
        advect(exec, &cells, view(&v3), view(&v3), reborrow(&mut v));
        for (axis, v) in v.iter_mut().enumerate().take(cells.dims) {
            cells.set_bnd(Some(axis), v);
        }
        project(exec, (&cells, &grid), physics.solve, &mut v, &mut room, second);
        rho2.copy_from_slice(rho);
        diffuse(
            exec,
            &cells,
            (physics.diffusion, physics.sweeps),
            None,
            rho2,
            room.fields,
        );
        advect(exec, &cells, view(&v), [rho2], [rho]);
    }

    /// The density after the step whose fields are at hand, made again.
    pub fn carry_density(&mut self, exec: &dyn Exec) {
        let cells = self.cells;
        let Parts { v, rho2, rho, .. } = self.parts();
        advect(exec, &cells, view(&v), [rho2], [rho]);
    }

    /// Takes back the step whose fields are at hand: the adjoints of the state after it become those of the state before. That of the velocity
    /// is that of the force too. The state at hand is lost.
    pub fn take_back(&mut self, exec: &dyn Exec) {
        let (cells, grid, physics) = (self.cells, self.grid, self.physics);
        let Parts {
            v3,
            v,
            rho2,
            mut v_adjoint,
            rho_adjoint,
            rho,
            mut room,
            kept: [first, second],
            ..
        } = self.parts();
        rho.fill(T::ZERO);
        density_adjoint(exec, &cells, (view(&v), rho2), rho_adjoint, rho, &mut v_adjoint);
        rho_adjoint.copy_from_slice(rho);
        let diffusive = (physics.diffusion, physics.sweeps);
        diffuse_adjoint(exec, &cells, diffusive, None, rho_adjoint, room.fields);
        project_adjoint(
            exec,
            (&cells, &grid),
            physics.solve,
            &mut v_adjoint,
            &mut room,
            second,
        );
        for (axis, component) in v_adjoint.iter_mut().enumerate().take(cells.dims) {
            cells.set_bnd_adjoint(Some(axis), component);
        }
        let shape = (cells.padded, pitch::<T>(cells.padded));
        let mut fields = &mut *room.fields;
        let mut carried = take_vector(&mut fields, cells.dims, shape);
        carried.iter_mut().for_each(|component| component.fill(T::ZERO));
        velocity_adjoint(exec, &cells, view(&v3), &mut v_adjoint, &mut carried);
        for (sum, carried) in v_adjoint.iter_mut().zip(&carried) {
            crate::field::rows::add(sum, carried);
        }
        project_adjoint(
            exec,
            (&cells, &grid),
            physics.solve,
            &mut v_adjoint,
            &mut room,
            first,
        );
        let viscous = (physics.viscosity, physics.sweeps);
        for (axis, component) in v_adjoint.iter_mut().enumerate().take(cells.dims) {
            diffuse_adjoint(exec, &cells, viscous, Some(axis), component, room.fields);
        }
        add_lift(exec, &cells, physics.buoyancy, view(&v_adjoint), rho_adjoint);
    }

    /// Hands out the adjoint of the force of the step that was taken back, padded, that force, and the sums.
    pub fn taken_back<R>(
        &mut self,
        take: impl FnOnce((&Cells, &Grid), [Vector<'_, T>; 2], &mut [f64]) -> R,
    ) -> R {
        let (cells, grid) = (self.cells, self.grid);
        let Parts {
            v_adjoint,
            force,
            room,
            ..
        } = self.parts();
        take((&cells, &grid), [view(&v_adjoint), view(&force)], room.sums)
    }

    /// What a script adds to the adjoints after a step, with the density there and fields for its work.
    pub fn seen<R>(&mut self, see: impl FnOnce(Seen<'_, T>) -> R) -> R {
        let cells = self.cells;
        let Parts {
            v_adjoint,
            rho_adjoint,
            rho,
            room,
            ..
        } = self.parts();
        see(Seen {
            cells: &cells,
            rho,
            rho_adjoint,
            v_adjoint,
            work: room.fields,
            sums: room.sums,
        })
    }
}

/// A state and its adjoints, padded.
pub struct Seen<'a, T> {
    /// The cells.
    pub cells: &'a Cells,
    /// The density.
    pub rho: &'a [T],
    /// The adjoint of the density.
    pub rho_adjoint: &'a mut [T],
    /// The adjoint of the velocity.
    pub v_adjoint: VectorMut<'a, T>,
    /// Fields that may be written: two padded ones at least.
    pub work: &'a mut [T],
    /// Sums of rows.
    pub sums: &'a mut [f64],
}

/// `out = v + f + buoyancy rho` in the cells.
fn add_forces<T: Real>(
    exec: &dyn Exec,
    cells: &Cells,
    buoyancy: [f64; 3],
    (v, rho, force): (Vector<'_, T>, &[T], Vector<'_, T>),
    out: &mut VectorMut<'_, T>,
) {
    cells.for_rows(exec, reborrow(out), |row, out| {
        let (span, plain) = (cells.row(row), row * cells.n[0]..(row + 1) * cells.n[0]);
        let parts = out.into_iter().zip(v).zip(force).zip(buoyancy);
        for (((out, v), force), lift) in parts.take(cells.dims) {
            out.copy_from_slice(v.get(span.clone()).unwrap_or_default());
            if let Some(force) = force.get(plain.clone()) {
                crate::field::rows::add(out, force);
            }
            if lift != 0.0 {
                let rho = rho.get(span.clone()).unwrap_or_default();
                crate::field::rows::add_scaled(out, T::from_f64(lift), rho);
            }
        }
    });
}

/// The adjoint of buoyancy: `rho += buoyancy v`.
fn add_lift<T: Real>(exec: &dyn Exec, cells: &Cells, buoyancy: [f64; 3], v: Vector<'_, T>, rho: &mut [T]) {
    if buoyancy == [0.0; 3] {
        return;
    }
    cells.for_rows(exec, [rho], |row, [rho]| {
        for (v, lift) in v.iter().zip(buoyancy).take(cells.dims) {
            let v = v.get(cells.row(row)).unwrap_or_default();
            crate::field::rows::add_scaled(rho, T::from_f64(lift), v);
        }
    });
}
