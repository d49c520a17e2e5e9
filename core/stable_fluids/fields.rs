//! The fields of a simulation by name: a step's, its adjoint's, and the state at hand.

use super::cells::Cells;
use super::conjugate::Tape;
use super::project::{Room, Solve};
use crate::field::{Vector, VectorMut, reborrow};
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
}

fn take<'a, T>(rest: &mut &'a mut [T], (len, pitch): (usize, usize)) -> &'a mut [T] {
    let (field, behind) = core::mem::take(rest)
        .split_at_mut_checked(pitch)
        .unwrap_or_default();
    *rest = behind;
    field.get_mut(..len).unwrap_or_default()
}

pub(super) fn take_vector<'a, T>(
    rest: &mut &'a mut [T],
    dims: usize,
    shape: (usize, usize),
) -> VectorMut<'a, T> {
    let mut field = VectorMut::default();
    field
        .iter_mut()
        .take(dims)
        .for_each(|component| *component = take(rest, shape));
    field
}
