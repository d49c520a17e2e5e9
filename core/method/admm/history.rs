//! What ADMM knows of its earlier iterations: the fall-back to the plain augmented Lagrangian (mathematics section 5).

use crate::checkpoint::{Damaged, MANY, Record};

/// Growths of the gap in a row after which the multipliers are held.
const GROWTHS: usize = 3;

/// What one iteration has to know of those before.
#[derive(Clone, Copy, Debug, Default)]
pub struct History {
    /// Whether NSO overwrote the multiplier's bytes to damp.
    pub damped: bool,
    gap: f64,
    growths: usize,
    /// Iterations in a row that ended with a small change of rho.
    pub still: usize,
}

impl History {
    /// Itself in a checkpoint.
    pub fn record(&mut self, record: &mut Record<'_>) -> Result<(), Damaged> {
        record.flag(&mut self.damped)?;
        record.real(&mut self.gap)?;
        record.count(&mut self.growths, MANY)?;
        record.count(&mut self.still, MANY)
    }

    /// Whether to hold the multipliers: v and v* have drifted apart several times in a row. Held, the iteration alternates
    /// AO and NSO at fixed multipliers, the plain augmented Lagrangian, until they come closer again.
    pub fn hold(&mut self, gap: f64) -> bool {
        self.growths = if gap > self.gap { self.growths + 1 } else { 0 };
        self.gap = gap;
        self.growths > GROWTHS
    }
}
