//! What the user sees while a scene is solved, and how a stop is heard.

mod clock;
mod display;

pub use clock::{Clock, Phase, Spent, in_words};
pub use display::{Display, Mode};

use crate::interrupt::Interrupt;
use core::ops::ControlFlow;
use thurible_core::{Event, Observer, Progress};

/// One outer iteration, for the report.
#[derive(Clone, Debug)]
pub struct Row {
    /// Seconds since the first iteration began.
    pub seconds: f64,
    /// What the core said.
    pub progress: Progress,
}

/// Rows that the history has room for from the start, so that it need not grow while the solve runs.
const ROWS: usize = 1024;

/// The runner's [`Observer`]: times phases, moves the bar, keeps the history, passes on Ctrl-C.
pub struct Watch {
    /// Seconds by phase.
    pub clock: Clock,
    /// What the user sees.
    pub display: Display,
    /// All iterations so far.
    pub history: Vec<Row>,
    interrupt: Interrupt,
}

impl Watch {
    /// Watches a solve of at most `limit` iterations; `clock` has run since the program began.
    pub fn new(clock: Clock, mode: Mode, limit: usize, interrupt: Interrupt) -> Self {
        Watch { clock, display: Display::new(mode, limit), history: Vec::with_capacity(limit.min(ROWS)), interrupt }
    }

    /// An outer iteration is over.
    pub fn iteration(&mut self, progress: &Progress) {
        self.clock.leave();
        let seconds = self.clock.seconds();
        self.display.iteration(progress, seconds);
        self.history.push(Row { seconds, progress: progress.clone() });
    }
}

impl Observer for Watch {
    fn on(&mut self, event: Event) -> ControlFlow<()> {
        match event {
            Event::AoBegin => self.clock.enter(Phase::Ao),
            Event::NsoBegin => self.clock.enter(Phase::Nso),
            Event::AoEnd | Event::NsoEnd => self.clock.leave(),
            Event::AoIteration { objective, step } => self.display.detail(format_args!("advection {objective:.4e}, step {step}")),
            Event::NsoCycle { cycle, residual } => self.display.detail(format_args!("V-cycle {cycle}, residual {residual:.1e}")),
            _ => self.display.tick(),
        }
        if self.interrupt.asked() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }
}
