//! How many bytes a simulation and its control need.

use super::{Fluids, FluidsParams, Slots};
use crate::checkpoint;
use crate::grid::Space;
use crate::memory::{ALIGN, Arena, Entry, Layout, Ledger, Sharing};
use crate::method::refusal::PlanError;
use crate::problem::Problem;
use crate::real::Real;

/// No buffer holds more than this many numbers a cell and step, or a thread and row: later sizes cannot overflow.
const NUMBERS: u128 = 4096;

/// Every buffer, to the byte.
#[derive(Clone, Debug)]
pub struct FluidsPlan {
    ledger: Ledger,
    bytes: usize,
    saved_bytes: usize,
}

impl FluidsPlan {
    /// Alignment that the memory must have.
    pub const ALIGN: usize = ALIGN;

    /// Plans a problem in precision `T` and dimension `S`.
    ///
    /// # Errors
    /// [`PlanError`] when a field is wrong or sizes overflow.
    pub fn new<T: Real, S: Space>(problem: &Problem<'_>, params: &FluidsParams) -> Result<Self, PlanError> {
        params.check(problem, S::DIM)?;
        let cells: u128 = problem.cells.iter().map(|&n| n as u128 + 2).product();
        let fields = 8 * (problem.steps as u128 + params.cg_iterations as u128 + 8) * 20;
        let numbers = cells * fields + params.threads as u128 * NUMBERS;
        if numbers * T::BYTES as u128 > isize::MAX as u128 {
            return Err(PlanError::TooLarge);
        }
        Self::with::<T, S>(problem, params)
    }

    #[inline(never)]
    fn with<T: Real, S: Space>(problem: &Problem<'_>, params: &FluidsParams) -> Result<Self, PlanError> {
        let mut ledger = Ledger::new();
        ledger.group("stable fluids", Sharing::Together, |ledger| {
            let mut arena = Arena::measuring(ledger);
            let mut fluids = Fluids::<T, S>::bare(problem, params);
            // An arena that measures is never too small.
            let _ = fluids.layout(&mut Layout::carve(&mut arena));
        });
        Ok(Self {
            bytes: ledger.bytes().ok_or(PlanError::TooLarge)?,
            saved_bytes: checkpoint::bytes(&ledger).ok_or(PlanError::TooLarge)?,
            ledger,
        })
    }

    /// The choices with the most of the way back kept that a ceiling allows: all that the adjoint reads, or as many states as fit, one at
    /// least.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn fitting<T: Real, S: Space>(
        problem: &Problem<'_>,
        params: &FluidsParams,
        ceiling: usize,
    ) -> Result<FluidsParams, PlanError> {
        let with = |slots| FluidsParams { slots, ..*params };
        let bytes = |slots| Self::new::<T, S>(problem, &with(slots)).map(|plan| plan.bytes());
        if bytes(Slots::Tape)? <= ceiling {
            return Ok(with(Slots::Tape));
        }
        let (mut fits, mut too_many) = (1, problem.steps + 1);
        while too_many - fits > 1 {
            let middle = usize::midpoint(fits, too_many);
            if bytes(Slots::States(middle))? <= ceiling {
                fits = middle;
            } else {
                too_many = middle;
            }
        }
        Ok(with(Slots::States(fits)))
    }

    /// The choices with what is kept for the way back, the most that the ceiling allows where nobody says what, and their plan.
    ///
    /// # Errors
    /// As [`Self::new`]; [`PlanError::Ceiling`] where the ceiling holds too little.
    pub fn within<T: Real, S: Space>(
        problem: &Problem<'_>,
        params: &FluidsParams,
        slots: Option<Slots>,
        ceiling: Option<usize>,
    ) -> Result<(FluidsParams, Self), PlanError> {
        let params = match (slots, ceiling) {
            (None, Some(ceiling)) => Self::fitting::<T, S>(problem, params, ceiling)?,
            (slots, _) => FluidsParams {
                slots: slots.unwrap_or(Slots::Tape),
                ..*params
            },
        };
        let plan = Self::new::<T, S>(problem, &params)?;
        match ceiling {
            Some(ceiling) if plan.bytes > ceiling => Err(PlanError::Ceiling {
                needed: plan.bytes,
                ceiling,
            }),
            _ => Ok((params, plan)),
        }
    }

    /// Bytes of the whole block.
    #[must_use]
    pub fn bytes(&self) -> usize {
        self.bytes
    }

    /// Bytes of a checkpoint: see [`Fluids::save`].
    #[must_use]
    pub fn saved_bytes(&self) -> usize {
        self.saved_bytes
    }

    /// The ledger, groups before their children.
    #[must_use]
    pub fn entries(&self) -> &[Entry] {
        self.ledger.entries()
    }
}
