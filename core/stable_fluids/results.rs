//! The flow of the unknowns, a step at a time, and what was found of templates.

use super::Fluids;
use super::cells::Cells;
use super::fields::Flow;
use super::given::Given;
use crate::exec::Exec;
use crate::field::{Vector, VectorMut, rows};
use crate::grid::{Grid, Space};
use crate::observe::{Event, Observer};
use crate::problem::{Template, Units};
use crate::progress::Status;
use crate::real::Real;
use core::ops::ControlFlow;

/// The flow after some steps, in the scene's units.
pub struct Moment<'a, 'm, T> {
    /// How many steps.
    pub step: usize,
    flow: &'a Flow<'m, T>,
    out: &'a mut [T],
    units: Units,
}

impl<'a, T: Real> Moment<'a, '_, T> {
    /// The state as it lies: cells, the density and the velocity, padded, and what 1 is in the scene's units.
    pub(crate) fn state(&self) -> (&'a Cells, &'a [T], Vector<'a, T>, f64) {
        let flow = self.flow;
        (&flow.cells, flow.rho(), flow.v(), self.units.velocity)
    }

    /// The density, one number a cell, x fastest.
    pub fn density(&mut self) -> &[T] {
        self.flow.cells.pack(self.flow.rho(), self.out);
        self.out
    }

    /// Component `axis` of the velocity, at the centres of cells.
    pub fn velocity(&mut self, axis: usize) -> &[T] {
        let v = self.flow.v();
        self.flow
            .cells
            .pack(v.get(axis).copied().unwrap_or_default(), self.out);
        rows::scale_in_place(self.out, T::from_f64(self.units.velocity));
        self.out
    }

    /// Component `axis` of the force of the step that led here, at the centres of cells; nothing at the start.
    pub fn force(&mut self, axis: usize) -> Option<&[T]> {
        let force = self.flow.force.get(axis).filter(|_| self.step > 0)?;
        rows::scale(self.out, T::from_f64(self.units.force), force);
        Some(self.out)
    }
}

/// Writes the force of a step, from what a search has: the cells, the unknowns, and room for the factors of a template.
pub(super) type Push<'a, T> =
    dyn FnMut(&Given<'_, T>, usize, ((&Cells, &Grid), &[T], &mut [f64]), &mut VectorMut<'_, T>) + 'a;

/// A template as it was found, in the scene's units: see [`Fluids::template`].
#[derive(Clone, Copy, Debug)]
pub struct FoundTemplate {
    /// As it was given, with its middle and radius as found.
    pub template: Template,
    /// Amplitudes that it has.
    pub intervals: usize,
    /// Numbers of an amplitude.
    pub numbers: usize,
}

impl<T: Real, S: Space> Fluids<'_, T, S> {
    /// Simulates with the unknowns as they are; `each` sees the flow at the start and after every step. A search may go on afterwards.
    ///
    /// # Errors
    /// [`Status`]: cancelled by the observer or by `each`; not ready.
    pub fn replay(
        &mut self,
        exec: &dyn Exec,
        observer: &mut dyn Observer,
        each: &mut dyn FnMut(Moment<'_, '_, T>) -> ControlFlow<()>,
    ) -> Result<(), Status> {
        self.play(
            exec,
            observer,
            each,
            &mut |pushed, step, (cells, z, factors), force| {
                pushed.force(exec, cells, z, step, factors, force);
            },
        )
    }

    /// Simulates with the forces that `push` writes step by step.
    pub(super) fn play(
        &mut self,
        exec: &dyn Exec,
        observer: &mut dyn Observer,
        each: &mut dyn FnMut(Moment<'_, '_, T>) -> ControlFlow<()>,
        push: &mut Push<'_, T>,
    ) -> Result<(), Status> {
        if self.mass <= 0.0 {
            return Err(Status::NotReady);
        }
        let _ = self.unknowns();
        self.taped = false;
        let (steps, units) = (self.steps(), self.units);
        let mut search = self.search();
        search.begin();
        let super::Search {
            flow, given, work, z, ..
        } = search;
        let [_, out] = work.metric;
        let out = out.get_mut(..flow.cells.count()).unwrap_or_default();
        for step in 0..=steps {
            let moment = Moment {
                step,
                flow: &*flow,
                out: &mut *out,
                units,
            };
            if each(moment).is_break() || observer.on(Event::Work).is_break() {
                return Err(Status::Cancelled);
            }
            if step < steps {
                let cells = (&flow.cells, &flow.grid);
                push(&given, step, (cells, z, work.factors), &mut flow.force);
                flow.advance(exec);
            }
        }
        Ok(())
    }

    /// Template `index` as it is now.
    #[must_use]
    pub fn template(&mut self, index: usize) -> Option<FoundTemplate> {
        let _ = self.unknowns();
        let (length, force) = (self.length, self.units.force);
        let search = self.search();
        let placed = search.given.unknowns.placed(search.given.templates).nth(index)?;
        let (center, radius) = placed.now(search.z);
        let now = Template {
            center,
            radius,
            ..placed.given
        };
        Some(FoundTemplate {
            template: now.scaled(1.0 / length, 1.0 / force),
            intervals: placed.intervals(),
            numbers: placed.numbers(),
        })
    }

    /// The amplitude of template `index` in an interval, in length / time^2.
    #[must_use]
    pub fn template_amplitude(&mut self, index: usize, interval: usize) -> Option<[f64; 3]> {
        let force = self.units.force;
        let search = self.search();
        let placed = search.given.unknowns.placed(search.given.templates).nth(index)?;
        Some(placed.amplitude(search.z, interval).map(|a| a * force))
    }
}
