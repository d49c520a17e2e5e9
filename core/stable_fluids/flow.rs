//! A step of the flow and the same step backwards, in the fields of a simulation.
//!
//! ```text
//! v1 = v + f + buoyancy rho,   v2 = diffuse(v1),   v3 = project(v2),   v4 = advect(v3 by v3),   v' = project(v4)
//! rho2 = diffuse(rho),   rho' = advect(rho2 by v')
//! ```

use super::advect::advect;
use super::advect_back::{density_adjoint, velocity_adjoint};
use super::cells::Cells;
use super::conjugate::Tape;
use super::project::{Room, Solve, project, project_adjoint};
use super::sweeps::{diffuse, diffuse_adjoint};
use crate::exec::Exec;
use crate::field::{Vector, VectorMut, reborrow, view};
use crate::grid::Grid;
use crate::memory::ALIGN;
use crate::real::Real;

/// What moves the flow, in scaled numbers.
#[derive(Clone, Copy, Debug)]
pub struct Physics {
    /// Viscosity.
    pub viscosity: f64,
    /// Diffusion of the density.
    pub diffusion: f64,
    /// Acceleration along each axis where the density is 1.
    pub buoyancy: [f64; 3],
    /// Sweeps of a diffusion.
    pub sweeps: usize,
    /// How the pressure is found.
    pub solve: Solve,
}

/// The fields of a step, its adjoint, and the state at hand.
#[derive(Debug)]
pub struct Flow<'m, T> {
    /// The cells.
    pub cells: Cells,
    /// The same as a grid without ghosts.
    pub grid: Grid,
    /// What moves the flow.
    pub physics: Physics,
    /// All padded fields of a step and its adjoint.
    pub fields: &'m mut [T],
    /// Five padded fields of conjugate gradients, or none.
    pub conjugate: &'m mut [T],
    /// What the exact adjoint of conjugate gradients reads: fields and scalars.
    pub tape: [&'m mut [T]; 2],
    /// The force of a step, without ghosts; empty where there is none.
    pub force: VectorMut<'m, T>,
    /// Sums of rows.
    pub sums: &'m mut [f64],
}

/// Padded fields by name.
pub(super) struct Parts<'a, T> {
    pub v3: VectorMut<'a, T>,
    pub v: VectorMut<'a, T>,
    pub rho2: &'a mut [T],
    pub v_adjoint: VectorMut<'a, T>,
    pub rho_adjoint: &'a mut [T],
    /// rho before a step and after it; the adjoint of rho2 while a step is taken back.
    pub rho: &'a mut [T],
    pub room: Room<'a, T>,
    /// The divergences of both projections, where they are kept.
    pub kept: [&'a mut [T]; 2],
    pub force: VectorMut<'a, T>,
}

/// Numbers from one padded field to the next.
#[must_use]
pub fn pitch<T: Real>(len: usize) -> usize {
    len.next_multiple_of(ALIGN / T::BYTES)
}

/// Padded fields of a step and its adjoint.
#[must_use]
pub fn fields(dims: usize) -> usize {
    4 * dims + 6
}

impl<T: Real> Flow<'_, T> {
    fn pitch(&self) -> usize {
        pitch::<T>(self.cells.padded)
    }

    /// All fields.
    pub(super) fn parts(&mut self) -> Parts<'_, T> {
        let (dims, pitch) = (self.cells.dims, self.pitch());
        let shape = (self.cells.padded, pitch);
        let mut rest = &mut *self.fields;
        let (v3, v) = (
            take_vector(&mut rest, dims, shape),
            take_vector(&mut rest, dims, shape),
        );
        let rho2 = take(&mut rest, shape);
        let v_adjoint = take_vector(&mut rest, dims, shape);
        let (rho_adjoint, rho) = (take(&mut rest, shape), take(&mut rest, shape));
        let mut others = &mut *self.conjugate;
        let conjugate = [(); 3].map(|()| take(&mut others, shape));
        let kept = [(); 2].map(|()| take(&mut others, shape));
        let [fields, scalars] = self.tape.each_mut();
        Parts {
            v3,
            v,
            rho2,
            v_adjoint,
            rho_adjoint,
            rho,
            room: Room {
                fields: rest,
                conjugate,
                tape: Tape {
                    fields,
                    pitch: self::pitch::<T>(self.cells.count()),
                    scalars,
                },
                sums: self.sums,
            },
            kept,
            force: reborrow(&mut self.force),
        }
    }

    /// A field of the list, padded.
    fn field(&self, index: usize) -> &[T] {
        let begin = index * self.pitch();
        self.fields
            .get(begin..begin + self.cells.padded)
            .unwrap_or_default()
    }

    fn vector(&self, first: usize) -> Vector<'_, T> {
        core::array::from_fn(|axis| {
            if axis < self.cells.dims {
                self.field(first + axis)
            } else {
                &[]
            }
        })
    }

    /// The density at hand, padded.
    #[must_use]
    pub fn rho(&self) -> &[T] {
        self.field(3 * self.cells.dims + 2)
    }

    /// The velocity at hand, padded.
    #[must_use]
    pub fn v(&self) -> Vector<'_, T> {
        self.vector(self.cells.dims)
    }

    /// The adjoint of the velocity, padded: of the force too, where a step was taken back.
    #[must_use]
    pub fn v_adjoint(&self) -> Vector<'_, T> {
        self.vector(2 * self.cells.dims + 1)
    }

    /// The adjoint of the density, padded.
    #[must_use]
    pub fn rho_adjoint(&self) -> &[T] {
        self.field(3 * self.cells.dims + 1)
    }

    /// Makes a density that at hand: a field without ghosts.
    pub fn put_density(&mut self, rho: &[T]) {
        let cells = self.cells;
        cells.unpack(rho, self.parts().rho);
    }

    /// Makes component `axis` of a velocity that at hand: a field without ghosts.
    pub fn put_velocity(&mut self, axis: usize, v: &[T]) {
        let cells = self.cells;
        if let Some(own) = self.parts().v.get_mut(axis) {
            cells.unpack(v, own);
        }
    }

    /// Adjoints of 0 to begin with.
    pub fn clear_adjoints(&mut self) {
        let Parts {
            mut v_adjoint,
            rho_adjoint,
            ..
        } = self.parts();
        rho_adjoint.fill(T::ZERO);
        v_adjoint.iter_mut().for_each(|component| component.fill(T::ZERO));
    }

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
            v,
            v_adjoint,
            rho_adjoint,
            rho,
            room,
            ..
        } = self.parts();
        see(Seen {
            cells: &cells,
            rho,
            v: view(&v),
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
    /// The velocity.
    pub v: Vector<'a, T>,
    /// The adjoint of the density.
    pub rho_adjoint: &'a mut [T],
    /// The adjoint of the velocity.
    pub v_adjoint: VectorMut<'a, T>,
    /// Fields that may be written: two padded ones at least.
    pub work: &'a mut [T],
    /// Sums of rows.
    pub sums: &'a mut [f64],
}

fn take<'a, T>(rest: &mut &'a mut [T], (len, pitch): (usize, usize)) -> &'a mut [T] {
    let (field, behind) = core::mem::take(rest)
        .split_at_mut_checked(pitch)
        .unwrap_or_default();
    *rest = behind;
    field.get_mut(..len).unwrap_or_default()
}

fn take_vector<'a, T>(rest: &mut &'a mut [T], dims: usize, shape: (usize, usize)) -> VectorMut<'a, T> {
    let mut field = VectorMut::default();
    field
        .iter_mut()
        .take(dims)
        .for_each(|component| *component = take(rest, shape));
    field
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
