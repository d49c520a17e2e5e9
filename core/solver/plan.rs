//! How many bytes a solve needs.

use super::release::Release;
use crate::checkpoint;
use crate::exec::device::Room;
use crate::grid::Space;
use crate::memory::{ALIGN, Arena, Entry, Layout, Ledger, Sharing};
use crate::method::contract::Size;
use crate::method::direct::room;
use crate::method::params::{Method, Params};
use crate::method::refusal::PlanError;
use crate::method::registry::{self, Engine};
use crate::problem::{Feature, Problem, ProblemError, ShareError};
use crate::real::Real;
use crate::words::Named;

/// Every buffer of a solve, to the byte.
#[derive(Clone, Debug)]
pub struct Plan {
    ledger: Ledger,
    bytes: usize,
    method_bytes: usize,
    paper_bound: usize,
    saved_bytes: usize,
    pub(super) params: Params,
}

impl Plan {
    /// Alignment that the memory must have.
    pub const ALIGN: usize = ALIGN;

    /// Plans `problem` in precision `T` and dimension `S`.
    ///
    /// # Errors
    /// [`PlanError`] when a field is wrong or sizes overflow.
    pub fn new<T: Real, S: Space>(problem: &Problem<'_>, params: &Params) -> Result<Self, PlanError> {
        check::<T, S>(problem, params)?;
        let problem = &registry::resolved(problem, params);
        let measure = |params: &Params| Self::size::<T, S>(problem, params);
        let params = registry::fit::<T, S>(problem, params, &measure)?;
        Self::with::<T, S>(problem, &params)
    }

    /// The size alone: a plan takes much of a stack.
    #[inline(never)]
    fn size<T: Real, S: Space>(problem: &Problem<'_>, params: &Params) -> Result<Size, PlanError> {
        let plan = Self::with::<T, S>(problem, params)?;
        Ok(Size {
            bytes: plan.bytes,
            method: plan.method_bytes,
            paper_bound: plan.paper_bound,
        })
    }

    #[inline(never)]
    fn with<T: Real, S: Space>(problem: &Problem<'_>, params: &Params) -> Result<Self, PlanError> {
        let mut ledger = Ledger::new();
        ledger.group("the method", Sharing::Together, |ledger| {
            let mut arena = Arena::measuring(ledger);
            let mut engine = Engine::<T, S>::new(&problem.controlled(), params);
            // An arena that measures is never too small.
            let _ = engine.get_mut().layout(&mut Layout::carve(&mut arena));
        });
        Self::measure_release::<T, S>(problem, params, &mut ledger);
        super::script::measure::<T>(problem, &mut ledger);
        Ok(Self {
            bytes: ledger.bytes().ok_or(PlanError::TooLarge)?,
            method_bytes: ledger.entries().first().map_or(0, |entry| entry.bytes),
            paper_bound: paper_bound::<T, S>(problem),
            saved_bytes: checkpoint::bytes(&ledger).ok_or(PlanError::TooLarge)?,
            params: *params,
            ledger,
        })
    }

    /// Counts what is simulated after the release.
    #[inline(never)]
    fn measure_release<T: Real, S: Space>(problem: &Problem<'_>, params: &Params, ledger: &mut Ledger) {
        if problem.release.is_none() {
            return;
        }
        ledger.group("the flow after the release", Sharing::Together, |ledger| {
            let mut arena = Arena::measuring(ledger);
            if let Some(release) = &mut Release::<T, S>::new(problem, params) {
                let _ = release.layout(&mut Layout::carve(&mut arena));
            }
        });
    }

    /// Bytes of the whole block.
    #[must_use]
    pub fn bytes(&self) -> usize {
        self.bytes
    }

    /// Bytes of the method alone: all but the keyframes.
    #[must_use]
    pub fn method_bytes(&self) -> usize {
        self.method_bytes
    }

    /// The parameters, with what was left open chosen.
    #[must_use]
    pub fn params(&self) -> &Params {
        &self.params
    }

    /// The paper's bound for its method, 4 (1 + d) N prod(n) / (1 - 2^-d) numbers of the same precision, in bytes.
    #[must_use]
    pub fn paper_bound(&self) -> usize {
        self.paper_bound
    }

    /// Bytes of a checkpoint: see [`Solver::save`](super::Solver::save).
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

/// How large the search of a problem on the finest grid is, for a device.
///
/// # Errors
/// What of the problem a device cannot do yet, in words.
pub fn room(problem: &Problem<'_>, params: &Params) -> Result<Room, &'static str> {
    if params.method != Method::Direct {
        return Err("other method than direct");
    }
    room::room(&registry::resolved(problem, params).controlled(), params)
}

fn check<T: Real, S: Space>(problem: &Problem<'_>, params: &Params) -> Result<(), PlanError> {
    if problem.cells.len() != S::DIM {
        return Err(ProblemError::Dimensions {
            expected: S::DIM,
            given: problem.cells.len(),
        }
        .into());
    }
    registry::with_copies(problem, params).check()?;
    if problem.keyframes.is_empty() && registry::steers(params) {
        return Err(ProblemError::NoKeyframe.into());
    }
    let unfit = |&&feature: &&Feature| problem.asks_for(feature) && !registry::takes(params, feature);
    if let Some(&feature) = Feature::ALL.iter().find(unfit) {
        let method = params.method.name();
        return Err(ProblemError::Unfit { method, feature }.into());
    }
    if problem.is_shared() && registry::reach(params).is_none() {
        let method = params.method.name();
        return Err(ProblemError::Share(ShareError::Method { method }).into());
    }
    params.check()?;
    // No buffer holds more than this many numbers a cell and step (or a thread, row and step): later sizes cannot overflow.
    const NUMBERS: u128 = 4096;
    let cells: u128 = problem.cells.iter().map(|&n| n as u128).product();
    let numbers = cells * problem.steps as u128 + params.threads as u128 * (problem.steps as u128 + 4096);
    if numbers * NUMBERS * T::BYTES as u128 > isize::MAX as u128 * 64 {
        return Err(PlanError::TooLarge);
    }
    Ok(())
}

fn paper_bound<T: Real, S: Space>(problem: &Problem<'_>) -> usize {
    let cells: u128 = problem.cells.iter().map(|&n| n as u128).product();
    let numbers = 4 * (1 + S::DIM as u128) * problem.steps as u128 * cells;
    let power = 1u128 << S::DIM;
    usize::try_from(numbers * T::BYTES as u128 * power / (power - 1)).unwrap_or(usize::MAX)
}
