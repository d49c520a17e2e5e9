//! How many bytes an operator needs, and how many states it keeps in them.

use super::layout::bare_problem;
use super::{Operator, OperatorParams};
use crate::grid::Space;
use crate::memory::{ALIGN, Arena, Entry, Ledger, Sharing};
use crate::method::refusal::PlanError;
use crate::problem::{Problem, ProblemError};
use crate::real::Real;
use crate::reversal::repeated_steps;

/// No buffer holds more than this many numbers a cell and kept state, or a thread and row: later sizes cannot overflow.
const NUMBERS: u128 = 4096;

/// Every buffer of an operator, to the byte.
#[derive(Clone, Debug)]
pub struct OperatorPlan {
    ledger: Ledger,
    bytes: usize,
    next: Option<usize>,
    steps: usize,
    slots: usize,
}

impl OperatorPlan {
    /// Alignment that the memory must have.
    pub const ALIGN: usize = ALIGN;

    /// Plans the operator of `problem` in precision `T` and dimension `S`. Keyframes, release, price and mask of the problem count for
    /// nothing; steps may be 1.
    ///
    /// # Errors
    /// [`PlanError`] when a field is wrong, sizes overflow, or the ceiling holds too little.
    pub fn new<T: Real, S: Space>(problem: &Problem<'_>, params: &OperatorParams) -> Result<Self, PlanError> {
        let (expected, given) = (S::DIM, problem.cells.len());
        if given != expected {
            return Err(ProblemError::Dimensions { expected, given }.into());
        }
        let steps = problem.steps;
        crate::method::refusal::count("steps", steps, crate::problem::MAX_STEPS - 1)?;
        Problem {
            steps: steps.max(2),
            ..bare_problem(problem)
        }
        .check()?;
        params.check(steps)?;
        let cells: u128 = problem.cells.iter().map(|&n| n as u128).product();
        let numbers = cells * (steps + problem.emitters.len()) as u128 + params.threads as u128 * NUMBERS;
        if numbers * NUMBERS * T::BYTES as u128 > isize::MAX as u128 * 64 {
            return Err(PlanError::TooLarge);
        }
        let slots = fit::<T, S>(problem, params)?;
        let next = (slots < steps)
            .then(|| Self::bytes_of::<T, S>(problem, params, slots + 1))
            .transpose()?;
        let ledger = Self::ledger::<T, S>(problem, params, slots);
        let bytes = ledger.bytes().ok_or(PlanError::TooLarge)?;
        Ok(Self {
            ledger,
            bytes,
            next,
            steps,
            slots,
        })
    }

    #[inline(never)]
    fn ledger<T: Real, S: Space>(problem: &Problem<'_>, params: &OperatorParams, slots: usize) -> Ledger {
        let mut ledger = Ledger::new();
        ledger.group("operator", Sharing::Together, |ledger| {
            let mut arena = Arena::measuring(ledger);
            let mut operator = Operator::<T, S>::bare(problem, params, slots);
            // An arena that measures is never too small.
            let _ = operator.layout(problem, &mut arena);
        });
        ledger
    }

    #[inline(never)]
    fn bytes_of<T: Real, S: Space>(
        problem: &Problem<'_>,
        params: &OperatorParams,
        slots: usize,
    ) -> Result<usize, PlanError> {
        let ledger = Self::ledger::<T, S>(problem, params, slots);
        ledger.bytes().ok_or(PlanError::TooLarge)
    }

    /// Bytes of the whole block.
    #[must_use]
    pub fn bytes(&self) -> usize {
        self.bytes
    }

    /// States that are kept.
    #[must_use]
    pub fn slots(&self) -> usize {
        self.slots
    }

    /// Bytes with one state more; `None` where every step has one.
    #[must_use]
    pub fn next_slot(&self) -> Option<usize> {
        self.next
    }

    /// Steps that a gradient runs again beside the one for each step that it takes back, the way forward of the simulation counted.
    #[must_use]
    pub fn repeated_steps(&self) -> usize {
        repeated_steps(self.steps, self.slots)
    }

    /// The ledger, groups before their children.
    #[must_use]
    pub fn entries(&self) -> &[Entry] {
        self.ledger.entries()
    }
}

/// How many states are kept: as many as are asked for, or the most that the ceiling holds.
fn fit<T: Real, S: Space>(problem: &Problem<'_>, params: &OperatorParams) -> Result<usize, PlanError> {
    let bytes = |slots: usize| OperatorPlan::bytes_of::<T, S>(problem, params, slots);
    let Some(ceiling) = params.ceiling else {
        return Ok(params.slots.unwrap_or(problem.steps));
    };
    let least = params.slots.unwrap_or(1);
    let needed = bytes(least)?;
    if needed > ceiling {
        return Err(PlanError::Ceiling { needed, ceiling });
    }
    let (mut fits, mut beyond) = (least, params.slots.unwrap_or(problem.steps) + 1);
    while beyond - fits > 1 {
        let middle = usize::midpoint(fits, beyond);
        // What cannot be counted does not fit.
        if bytes(middle).is_ok_and(|bytes| bytes <= ceiling) {
            fits = middle;
        } else {
            beyond = middle;
        }
    }
    Ok(fits)
}
