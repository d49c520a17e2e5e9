//! How many bytes tracking needs.

use super::{Capture, TrackParams, Tracker};
use crate::grid::Space;
use crate::memory::{ALIGN, Arena, Entry, Layout, Ledger, Sharing};
use crate::method::refusal::PlanError;
use crate::real::Real;

/// No buffer holds more than this many numbers a cell, or a thread and row: later sizes cannot overflow.
const NUMBERS: u128 = 4096;

/// Every buffer of tracking, to the byte; it does not depend on the number of frames.
#[derive(Clone, Debug)]
pub struct TrackPlan {
    ledger: Ledger,
    bytes: usize,
}

impl TrackPlan {
    /// Alignment that the memory must have.
    pub const ALIGN: usize = ALIGN;

    /// Plans a capture in precision `T` and dimension `S`.
    ///
    /// # Errors
    /// [`PlanError`] when a field is wrong or sizes overflow.
    pub fn new<T: Real, S: Space>(capture: &Capture<'_>, params: &TrackParams) -> Result<Self, PlanError> {
        capture.check(S::DIM)?;
        params.check()?;
        let cells: u128 = capture.cells.iter().map(|&n| n as u128).product();
        let numbers = cells + params.threads as u128 * NUMBERS;
        if numbers * NUMBERS * T::BYTES as u128 > isize::MAX as u128 * 64 {
            return Err(PlanError::TooLarge);
        }
        Self::with::<T, S>(capture, params)
    }

    #[inline(never)]
    fn with<T: Real, S: Space>(capture: &Capture<'_>, params: &TrackParams) -> Result<Self, PlanError> {
        let mut ledger = Ledger::new();
        ledger.group("tracking", Sharing::Together, |ledger| {
            let mut arena = Arena::measuring(ledger);
            let mut tracker = Tracker::<T, S>::bare(capture, params);
            // An arena that measures is never too small.
            let _ = tracker.layout(&mut Layout::carve(&mut arena));
        });
        let bytes = ledger.bytes().ok_or(PlanError::TooLarge)?;
        Ok(Self { ledger, bytes })
    }

    /// Bytes of the whole block.
    #[must_use]
    pub fn bytes(&self) -> usize {
        self.bytes
    }

    /// The ledger, groups before their children.
    #[must_use]
    pub fn entries(&self) -> &[Entry] {
        self.ledger.entries()
    }
}
