//! The simulation as an operator for other programs: densities and velocities from a start and forces, and the vector-Jacobian product back.

use super::Fluids;
use super::cells::Cells;
use super::flow::Seen;
use super::march::{March, Script};
use super::params::Slots;
use super::results::Moment;
use crate::exec::Exec;
use crate::field::{Vector, VectorMut, rows};
use crate::grid::{Grid, Space};
use crate::observe::Observer;
use crate::problem::Units;
use crate::progress::Status;
use crate::real::Real;
use crate::solver::InputError;
use core::ops::ControlFlow;

/// What a number of a state or a gradient is of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// The density.
    Density,
    /// A component of the velocity.
    Velocity(usize),
}

/// Writes component `axis` of the force of step `step`, at the centres of cells, in length / time^2.
pub type Forces<'a, T> = dyn FnMut(usize, usize, &mut [T]) + 'a;
/// Writes the cotangent of a part of the state after `step` steps; whether it is not 0.
pub type Cotangents<'a, T> = dyn FnMut(usize, Part, &mut [T]) -> bool + 'a;
/// Takes the gradient by component `axis` of the force of step `step`.
pub type ForceGradients<'a, T> = dyn FnMut(usize, usize, &[T]) + 'a;

/// What a program gives, as a script.
struct Given<'a, T> {
    units: Units,
    forces: &'a mut Forces<'a, T>,
    cotangents: &'a mut Cotangents<'a, T>,
    gradients: &'a mut ForceGradients<'a, T>,
    /// A field without ghosts.
    field: &'a mut [T],
}

/// Asks for the components of the force of a step, in the units of steps.
fn ask<T: Real>(
    forces: &mut Forces<'_, T>,
    step: usize,
    dims: usize,
    units: Units,
    force: &mut VectorMut<'_, T>,
) {
    let unit = T::from_f64(1.0 / units.force);
    for (axis, force) in force.iter_mut().enumerate().take(dims) {
        force.fill(T::ZERO);
        forces(step, axis, force);
        rows::scale_in_place(force, unit);
    }
}

impl<T: Real> Script<T> for Given<'_, T> {
    fn force(
        &mut self,
        _: &dyn Exec,
        (cells, _): (&Cells, &Grid),
        step: usize,
        force: &mut VectorMut<'_, T>,
        _: &mut [f64],
    ) {
        ask(self.forces, step, cells.dims, self.units, force);
    }

    fn see(&mut self, _: &dyn Exec, _: usize, _: Seen<'_, T>) {}

    fn add_adjoint(&mut self, exec: &dyn Exec, step: usize, mut seen: Seen<'_, T>) {
        let (cells, n) = (seen.cells, seen.cells.n[0]);
        let mut add = |part: Part, unit: f64, adjoint: &mut [T]| {
            self.field.fill(T::ZERO);
            if (self.cotangents)(step, part, self.field) {
                let field = &*self.field;
                cells.for_rows(exec, [adjoint], |row, [adjoint]| {
                    rows::add_scaled(
                        adjoint,
                        T::from_f64(unit),
                        rows::part(field, row * n..(row + 1) * n),
                    );
                });
            }
        };
        add(Part::Density, 1.0, seen.rho_adjoint);
        for (axis, adjoint) in seen.v_adjoint.iter_mut().enumerate().take(cells.dims) {
            add(Part::Velocity(axis), self.units.velocity, adjoint);
        }
    }

    fn looks_at(&self, _: usize) -> bool {
        false
    }

    fn take_gradient(
        &mut self,
        _: &dyn Exec,
        (cells, _): (&Cells, &Grid),
        step: usize,
        [adjoint, _]: [Vector<'_, T>; 2],
        _: &mut [f64],
    ) {
        let unit = T::from_f64(1.0 / self.units.force);
        for (axis, adjoint) in adjoint.iter().enumerate().take(cells.dims) {
            cells.pack(adjoint, self.field);
            rows::scale_in_place(self.field, unit);
            (self.gradients)(step, axis, self.field);
        }
    }
}

impl<T: Real, S: Space> Fluids<'_, T, S> {
    /// Sets rho_0 to any finite numbers: densities of a program need not be positive.
    ///
    /// # Errors
    /// [`InputError`]: wrong length, a value that is not finite.
    pub fn set_density(&mut self, density: &[T]) -> Result<(), InputError> {
        self.check(density)?;
        rows::part_mut(self.source, 0..density.len()).copy_from_slice(density);
        // What keyframes are scaled to; it says that there is a source, too.
        let mass: f64 = density.iter().map(|value| value.to_f64()).sum();
        (self.mass, self.taped) = (mass.max(f64::MIN_POSITIVE), false);
        Ok(())
    }

    /// Simulates from what was set by given forces, in the place of controls and templates; `each` sees the flow at the start and after every
    /// step.
    ///
    /// # Errors
    /// [`Status`]: cancelled, or not ready.
    pub fn simulate(
        &mut self,
        exec: &dyn Exec,
        observer: &mut dyn Observer,
        forces: &mut Forces<'_, T>,
        each: &mut dyn FnMut(Moment<'_, '_, T>) -> ControlFlow<()>,
    ) -> Result<(), Status> {
        let units = self.units;
        self.play(exec, observer, each, &mut |_, step, _, force| {
            ask(forces, step, S::DIM, units, force);
        })
    }

    /// Takes cotangents of all states after the start, the last first, back to the start: `gradients` hears of those by the forces, and
    /// [`Self::cotangent`] reads those by the density and the velocity at the start. Steps that were repeated.
    ///
    /// # Errors
    /// [`Status`]: cancelled, or not ready: nothing is kept for the way back.
    pub fn vjp<'a>(
        &'a mut self,
        exec: &dyn Exec,
        observer: &mut dyn Observer,
        forces: &'a mut Forces<'a, T>,
        cotangents: &'a mut Cotangents<'a, T>,
        gradients: &'a mut ForceGradients<'a, T>,
    ) -> Result<usize, Status> {
        if self.params.slots == Slots::None || self.mass <= 0.0 {
            return Err(Status::NotReady);
        }
        self.taped = false;
        let (steps, units) = (self.steps(), self.units);
        let mut search = self.search();
        search.begin();
        let super::Search { flow, work, kept, .. } = search;
        let [_, field] = work.metric;
        let mut given = Given {
            units,
            forces,
            cotangents,
            gradients,
            field: field.get_mut(..flow.cells.count()).unwrap_or_default(),
        };
        let mut march = March {
            flow,
            script: &mut given,
            observer,
        };
        let done = match kept.slots {
            Slots::Tape => march
                .forward(exec, steps, (&mut *kept.fields, kept.len))
                .and_then(|()| march.backward_on_tape(exec, steps, (kept.fields, kept.len)))
                .map(|()| 0),
            _ => march.backward(exec, steps, kept.fields, kept.steps),
        };
        done.map_err(Status::from)
    }

    /// The cotangent of a part of the start, after [`Self::vjp`].
    pub fn cotangent(&self, part: Part, out: &mut [T]) {
        let (field, unit) = match part {
            Part::Density => (self.flow.rho_adjoint(), 1.0),
            Part::Velocity(axis) => {
                let v = self.flow.v_adjoint();
                (
                    v.get(axis).copied().unwrap_or_default(),
                    1.0 / self.units.velocity,
                )
            }
        };
        self.flow.cells.pack(field, out);
        rows::scale_in_place(out, T::from_f64(unit));
    }
}
