//! What a host can watch and stop: plain numbers at fixed points of a solve.

use core::ops::ControlFlow;

/// A point of the solve that an [`Observer`] hears about.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Event {
    /// An outer iteration begins.
    IterationBegin {
        /// Outer iteration, from 1.
        iteration: usize,
    },
    /// The advection problem (AO, paper section 4.1) begins.
    AoBegin,
    /// One fixed-point iteration of AO is over.
    AoIteration {
        /// AO objective after it (paper eq. 7).
        objective: f64,
        /// Blending step that was taken.
        step: f64,
    },
    /// The advection problem ends.
    AoEnd,
    /// The Navier-Stokes problem (NSO, paper section 4.2) begins.
    NsoBegin,
    /// One FAS V-cycle of NSO is over.
    NsoCycle {
        /// Count of V-cycles in this Navier-Stokes problem, from 1.
        cycle: usize,
        /// max |f| after it, in scaled accelerations.
        residual: f64,
    },
    /// The Navier-Stokes problem ends.
    NsoEnd,
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
