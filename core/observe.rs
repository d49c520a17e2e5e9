//! What a host can watch and stop: plain numbers at fixed points of a solve.

use core::ops::ControlFlow;

/// A part of an iteration, of which a method may have several.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Phase {
    /// Its key in reports: lower case, with underscores.
    pub name: &'static str,
    /// What it is, in a few words.
    pub words: &'static str,
    /// What it measures after each of its steps.
    pub measure: &'static str,
}

/// A point of the solve that an [`Observer`] hears about.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Event {
    /// An outer iteration begins.
    IterationBegin {
        /// Outer iteration, from 1.
        iteration: usize,
    },
    /// A part of the iteration begins.
    PhaseBegin(Phase),
    /// One step of that part is over.
    PhaseStep {
        /// The part.
        phase: Phase,
        /// The step, from 1.
        step: usize,
        /// What the part measures of itself by: see [`Phase::measure`].
        value: f64,
        /// How far it went along its direction, 0 where that says nothing.
        taken: f64,
    },
    /// It ends.
    PhaseEnd(Phase),
    /// A piece of work well below a second at ordinary sizes is over: a smoothing sweep, a transport step, a projection cycle.
    Work,
}

/// Hooks with plain numbers. A break is heard within one sweep.
pub trait Observer {
    /// Called at every [`Event`]; `Break` stops the solve with [`Status::Cancelled`](crate::Status::Cancelled).
    fn on(&mut self, event: Event) -> ControlFlow<()>;
}

/// The observer that watches nothing.
#[derive(Clone, Copy, Debug, Default)]
pub struct Silent;

impl Observer for Silent {
    fn on(&mut self, _event: Event) -> ControlFlow<()> {
        ControlFlow::Continue(())
    }
}

/// Passes on [`Event::Work`] alone: what the inner solve of a coarser grid may say, since its iterations are not the caller's.
pub struct WorkOnly<'a>(pub &'a mut dyn Observer);

impl Observer for WorkOnly<'_> {
    fn on(&mut self, _event: Event) -> ControlFlow<()> {
        self.0.on(Event::Work)
    }
}
