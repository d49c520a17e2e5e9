//! Stable Fluids as an operator: everything at the centres of cells, covectors from the last state to that at the start.

use super::fields::{Places, Room};
use super::{Ask, Given, Input, OperatorError, Show, Simulator, Start, View};
use crate::exec::Exec;
use crate::field::{VectorMut, reborrow};
use crate::grid::Space;
use crate::observe::{Event, Observer};
use crate::progress::Status;
use crate::real::Real;
use crate::stable_fluids::cells::Cells;
use crate::stable_fluids::results::Moment;
use crate::stable_fluids::{Fluids, Slots};
use core::cell::Cell;
use core::ops::ControlFlow;

/// Hears the observer, and stops where something was refused.
struct Heard<'a> {
    observer: &'a mut dyn Observer,
    refused: &'a Cell<Option<OperatorError>>,
}

impl Observer for Heard<'_> {
    fn on(&mut self, event: Event) -> ControlFlow<()> {
        if self.refused.get().is_some() {
            return ControlFlow::Break(());
        }
        self.observer.on(event)
    }
}

/// How a run ended.
fn ended(done: Result<(), Status>, refused: &Cell<Option<OperatorError>>) -> Result<(), OperatorError> {
    match (refused.get(), done) {
        (Some(error), _) => Err(error),
        (None, Ok(())) => Ok(()),
        (None, Err(Status::Cancelled)) => Err(OperatorError::Cancelled),
        (None, Err(_)) => Err(OperatorError::NotSimulated),
    }
}

/// Asks for the force of a step.
fn push<T: Real>(
    ask: &mut Ask<'_, T>,
    unit: f64,
    refused: &Cell<Option<OperatorError>>,
    (step, cells, force): (usize, &Cells, &mut VectorMut<'_, T>),
) {
    let given = Given::new(Room::Plain(cells), &mut [], reborrow(force), unit);
    first(refused, given.ask(ask, step, Input::Force { step }));
}

/// Remembers the first refusal.
fn first(refused: &Cell<Option<OperatorError>>, asked: Result<(), OperatorError>) {
    refused.set(refused.get().or(asked.err()));
}

/// The state of a moment.
fn state<'a, T: Real>(moment: &Moment<'a, '_, T>) -> View<'a, T> {
    let (cells, density, vector, unit) = moment.state();
    View {
        places: Places::Padded(cells),
        density,
        vector,
        unit,
    }
}

impl<T: Real> View<'_, T> {
    /// Whether all numbers are finite.
    fn is_finite(&self) -> bool {
        let fields = [self.density].into_iter().chain(self.vector);
        fields.flatten().all(|value| value.is_finite())
    }
}

impl<T: Real, S: Space> Fluids<'_, T, S> {
    fn start(&mut self, start: &Start<'_, T>) -> Result<(), OperatorError> {
        self.set_density(start.density)
            .map_err(Input::Density.refused())?;
        self.set_at_rest();
        for (axis, component) in start.velocity.iter().enumerate().take(S::DIM) {
            if !component.is_empty() {
                let set = self.set_initial_velocity(axis, component);
                set.map_err(Input::Velocity.refused())?;
            }
        }
        Ok(())
    }
}

impl<T: Real, S: Space> Simulator<T> for Fluids<'_, T, S> {
    fn density_len(&self) -> usize {
        self.cells()
    }

    fn vector_len(&self, axis: usize) -> usize {
        if axis < S::DIM { self.cells() } else { 0 }
    }

    /// As [`Operator::simulate`](super::Operator::simulate); templates of the scene act as they are given. The velocity at the start is not
    /// projected, and one that is given must be announced ([`initial_velocity`](crate::FluidsParams::initial_velocity)).
    fn simulate(
        &mut self,
        exec: &dyn Exec,
        observer: &mut dyn Observer,
        start: &Start<'_, T>,
        force: &mut Ask<'_, T>,
        show: &mut Show<'_, T>,
    ) -> Result<(), OperatorError> {
        self.start(start)?;
        let (unit, last) = (1.0 / self.units().force, self.steps());
        let refused = &Cell::new(None);
        let observer = &mut Heard { observer, refused };
        let done = self.drive(
            exec,
            observer,
            &mut |step, cells, out| push(force, unit, refused, (step, cells, out)),
            &mut |moment| {
                // A force that was refused leads nowhere that is worth a look.
                if refused.get().is_some() {
                    return ControlFlow::Break(());
                }
                let view = state(&moment);
                // What is not finite once stays so.
                if moment.step == last && !view.is_finite() {
                    refused.set(refused.get().or(Some(OperatorError::TooFast { step: last - 1 })));
                    return ControlFlow::Break(());
                }
                show(moment.step, &view);
                ControlFlow::Continue(())
            },
        );
        ended(done, refused)
    }

    fn vjp(
        &mut self,
        exec: &dyn Exec,
        observer: &mut dyn Observer,
        force: &mut Ask<'_, T>,
        cotangent: &mut Ask<'_, T>,
        show: &mut Show<'_, T>,
    ) -> Result<(), OperatorError> {
        if self.params().slots == Slots::None {
            return Err(OperatorError::NothingKept);
        }
        let units = self.units();
        let refused = &Cell::new(None);
        let observer = &mut Heard { observer, refused };
        let mut forces = |step: usize, cells: &Cells, out: &mut VectorMut<'_, T>| {
            push(force, 1.0 / units.force, refused, (step, cells, out));
        };
        let mut covectors = |step: usize, cells: &Cells, density: &mut [T], v: &mut VectorMut<'_, T>| {
            let given = Given::new(Room::Padded(cells), density, reborrow(v), units.velocity);
            first(refused, given.ask(cotangent, step, Input::Cotangent { step }));
        };
        let done = self.take_back(
            exec,
            observer,
            &mut forces,
            &mut covectors,
            &mut |step, cells, vector| {
                show(
                    step,
                    &View {
                        places: Places::Padded(cells),
                        density: &[],
                        vector,
                        unit: 1.0 / units.force,
                    },
                );
            },
        );
        ended(done, refused)
    }

    fn gradient(&self) -> View<'_, T> {
        let (density, vector) = self.of_start();
        View {
            places: Places::Padded(self.box_of_cells()),
            density,
            vector,
            unit: 1.0 / self.units().velocity,
        }
    }

    fn buoyancy_gradient(&self) -> [f64; 3] {
        self.of_buoyancy()
    }

    fn repeated(&self) -> usize {
        Fluids::repeated(self)
    }
}
