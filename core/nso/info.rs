//! How a Navier-Stokes problem was solved, by either solver.

pub use crate::progress::MAX_CYCLES;

use crate::observe::{Event, Phase};

/// How observers hear of a Navier-Stokes problem.
pub const NSO: Phase = Phase {
    name: "nso",
    words: "Navier-Stokes problem",
    measure: "residual",
};

/// What observers hear after a cycle, 0 before the first.
pub(super) fn cycle_event(cycle: usize, residual: f64) -> Event {
    Event::PhaseStep {
        phase: NSO,
        step: cycle,
        value: residual,
        taken: 0.0,
    }
}

/// How a solve ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ended {
    /// max |f| is below the tolerance.
    Converged,
    /// All V-cycles or Newton steps were taken, or no step gained anything.
    Cycles,
    /// The residual is not finite and damping did not help.
    NotFinite,
    /// The observer said stop.
    Cancelled,
}

/// What happened in a solve.
#[derive(Clone, Debug)]
pub struct Info {
    /// How it ended.
    pub ended: Ended,
    /// max |f| before the first cycle and after each.
    pub residuals: heapless::Vec<f64, MAX_CYCLES>,
    /// Whether the problem was damped, for which the spare field was overwritten.
    pub damped: bool,
}

impl Default for Info {
    /// Before the first cycle.
    fn default() -> Self {
        Self {
            ended: Ended::Cycles,
            residuals: heapless::Vec::new(),
            damped: false,
        }
    }
}

impl Info {
    /// The last residual, NaN before there is one.
    #[must_use]
    pub fn residual(&self) -> f64 {
        self.residuals.last().copied().unwrap_or(f64::NAN)
    }

    /// With another end.
    #[must_use]
    pub fn ended(self, ended: Ended) -> Self {
        Self { ended, ..self }
    }
}
