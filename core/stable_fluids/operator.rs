//! The simulation by forces that are given, and all its steps taken back: what [`operator`](crate::operator) builds on.

use super::Fluids;
use super::cells::Cells;
use super::conjugate::Frame;
use super::flow::Seen;
use super::march::{March, Script};
use super::results::Moment;
use super::slots::Slots;
use crate::exec::Exec;
use crate::field::{Vector, VectorMut, rows, view};
use crate::grid::{Grid, Space};
use crate::observe::Observer;
use crate::problem::Units;
use crate::progress::Status;
use crate::real::Real;
use crate::solver::InputError;
use core::ops::ControlFlow;

/// Adds the force of a step, in the units of steps, at the centres of cells and without ghosts, to what is 0.
pub(crate) type Forces<'a, T> = dyn FnMut(usize, &Cells, &mut VectorMut<'_, T>) + 'a;
/// Adds covectors to those of the padded density and velocity after so many steps.
pub(crate) type Covectors<'a, T> = dyn FnMut(usize, &Cells, &mut [T], &mut VectorMut<'_, T>) + 'a;
/// Takes the covector of the force of a step, padded.
pub(crate) type ForceCovectors<'a, T> = dyn FnMut(usize, &Cells, Vector<'_, T>) + 'a;

/// What a program gives, as a script.
struct Given<'a, T> {
    forces: &'a mut Forces<'a, T>,
    covectors: &'a mut Covectors<'a, T>,
    taken: &'a mut ForceCovectors<'a, T>,
    /// What the scene has: templates, which act as they are.
    scene: super::given::Given<'a, T>,
    z: &'a [T],
    factors: &'a mut [f64],
    /// What the acceleration of buoyancy gets, in the units of steps.
    of_buoyancy: [f64; 3],
}

/// The force of a step: what a program gives, and templates.
fn push<T: Real>(
    exec: &dyn Exec,
    scene: &super::given::Given<'_, T>,
    (step, forces): (usize, &mut Forces<'_, T>),
    (grid, z, factors): ((&Cells, &Grid), &[T], &mut [f64]),
    force: &mut VectorMut<'_, T>,
) {
    force.iter_mut().for_each(|component| component.fill(T::ZERO));
    forces(step, grid.0, force);
    scene.add_templates(exec, grid, z, step, factors, force);
}

impl<T: Real> Script<T> for Given<'_, T> {
    fn force(
        &mut self,
        exec: &dyn Exec,
        grid: (&Cells, &Grid),
        step: usize,
        force: &mut VectorMut<'_, T>,
        _: &mut [f64],
    ) {
        let place = (grid, self.z, &mut *self.factors);
        push(exec, &self.scene, (step, self.forces), place, force);
    }

    fn see(&mut self, _: &dyn Exec, _: usize, _: Seen<'_, T>) {}

    fn add_adjoint(&mut self, exec: &dyn Exec, step: usize, mut seen: Seen<'_, T>) {
        // Before covectors are added the adjoint is that of the force of the step that begins here.
        let (adjoint, grid) = (view(&seen.v_adjoint), seen.cells.grid());
        let mut frame = Frame {
            cells: seen.cells,
            grid: &grid,
            sums: &mut *seen.sums,
        };
        for (out, adjoint) in self.of_buoyancy.iter_mut().zip(adjoint).take(seen.cells.dims) {
            *out += frame.dot(exec, adjoint, seen.rho);
        }
        (self.covectors)(step, seen.cells, seen.rho_adjoint, &mut seen.v_adjoint);
    }

    fn looks_at(&self, _: usize) -> bool {
        true
    }

    fn take_gradient(
        &mut self,
        _: &dyn Exec,
        (cells, _): (&Cells, &Grid),
        step: usize,
        [adjoint, _]: [Vector<'_, T>; 2],
        _: &mut [f64],
    ) {
        (self.taken)(step, cells, adjoint);
    }
}

impl<T: Real, S: Space> Fluids<'_, T, S> {
    /// The cells.
    pub(crate) fn box_of_cells(&self) -> &Cells {
        &self.flow.cells
    }

    /// Sets rho_0 to any finite numbers: densities of a program need not be positive.
    pub(crate) fn set_density(&mut self, density: &[T]) -> Result<(), InputError> {
        self.check(density)?;
        rows::part_mut(self.source, 0..density.len()).copy_from_slice(density);
        // What keyframes are scaled to; it says that there is a source, too.
        let mass: f64 = density.iter().map(|value| value.to_f64()).sum();
        (self.mass, self.taped) = (mass.max(f64::MIN_POSITIVE), false);
        Ok(())
    }

    /// The velocity at the start is 0.
    pub(crate) fn set_at_rest(&mut self) {
        for component in &mut self.initial {
            component.fill(T::ZERO);
        }
        self.taped = false;
    }

    /// Simulates from what was set by given forces, in the place of those that are searched for, and by templates; `each` sees the flow at
    /// the start and after every step.
    pub(crate) fn drive(
        &mut self,
        exec: &dyn Exec,
        observer: &mut dyn Observer,
        forces: &mut Forces<'_, T>,
        each: &mut dyn FnMut(Moment<'_, '_, T>) -> ControlFlow<()>,
    ) -> Result<(), Status> {
        self.repeated = 0;
        self.play(exec, observer, each, &mut |scene, step, place, force| {
            push(exec, scene, (step, forces), place, force);
        })
    }

    /// Takes covectors of all states, the last first, back to the start: `taken` hears of those of the forces, [`Self::of_start`] and
    /// [`Self::of_buoyancy`] have the others. Steps that were repeated; `NotReady` where nothing is kept for the way back.
    pub(crate) fn take_back<'a>(
        &'a mut self,
        exec: &dyn Exec,
        observer: &mut dyn Observer,
        forces: &'a mut Forces<'a, T>,
        covectors: &'a mut Covectors<'a, T>,
        taken: &'a mut ForceCovectors<'a, T>,
    ) -> Result<(), Status> {
        if self.params.slots == Slots::None || self.mass <= 0.0 {
            return Err(Status::NotReady);
        }
        let _ = self.unknowns();
        self.taped = false;
        let steps = self.steps();
        let mut search = self.search();
        search.begin();
        let super::Search {
            flow,
            given: scene,
            work,
            kept,
            z,
            ..
        } = search;
        let mut given = Given {
            forces,
            covectors,
            taken,
            scene,
            z,
            factors: work.factors,
            of_buoyancy: [0.0; 3],
        };
        let mut march = March {
            flow: &mut *flow,
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
        let repeated = done?;
        // The state at the start, of which the way back leaves nothing.
        flow.put_density(scene.source);
        flow.seen(|seen| given.add_adjoint(exec, 0, seen));
        let of_buoyancy = given.of_buoyancy;
        (self.repeated, self.of_buoyancy) = (repeated, of_buoyancy);
        Ok(())
    }

    /// The covectors of density and velocity at the start, padded and in the units of steps.
    pub(crate) fn of_start(&self) -> (&[T], Vector<'_, T>) {
        (self.flow.rho_adjoint(), self.flow.v_adjoint())
    }

    /// What the acceleration of buoyancy got along each axis, in the scene's units.
    pub(crate) fn of_buoyancy(&self) -> [f64; 3] {
        let Units { force, .. } = self.units;
        self.of_buoyancy.map(|gradient| gradient / force)
    }

    /// Steps that the last way back repeated.
    pub(crate) fn repeated(&self) -> usize {
        self.repeated
    }
}
