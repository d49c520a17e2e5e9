//! How many bytes a solve needs.

use super::engine::Engine;
use crate::checkpoint;
use crate::grid::Space;
use crate::memory::ALIGN;
use crate::memory::{Entry, Ledger, Sharing};
use crate::method::admm::{self, AdmmParams, Dimensions};
use crate::method::direct::{self, DirectParams};
use crate::method::lbfgs::{self, LbfgsParams};
use crate::method::simulate::drive::PdParams;
use crate::method::simulate::forward::{self, SimulationParams};
use crate::nso::{self, Shape};
use crate::problem::{Problem, ProblemError};
use crate::real::Real;
use crate::words::named;
use core::fmt;

/// How a problem is solved.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Method {
    /// Force elimination and quasi-Newton: no splitting.
    #[default]
    Direct,
    /// The paper's: ADMM over an advection and a Navier-Stokes problem.
    Admm,
    /// A baseline: L-BFGS over the forces by the adjoint of a simulation.
    Lbfgs,
    /// A baseline: smoke driven to the next keyframe while it is simulated.
    Pd,
    /// No control: the flow alone. Keyframes may be missing.
    Simulate,
}

named!(Method {
    Direct = "direct",
    Admm = "admm",
    Lbfgs = "lbfgs",
    Pd = "pd",
    Simulate = "simulate",
});

/// What a caller chooses besides the problem.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Params {
    /// The method.
    pub method: Method,
    /// Outer iterations at most, of the direct method those on the finest grid.
    pub iterations: usize,
    /// Threads that scratch is planned for; the [`Exec`](crate::Exec) of a step must not have more.
    pub threads: usize,
    /// Bytes that the plan should stay within if it can.
    pub ceiling: Option<usize>,
    /// Choices of ADMM.
    pub admm: AdmmParams,
    /// Choices of the direct method.
    pub direct: DirectParams,
    /// Choices of L-BFGS over the forces.
    pub lbfgs: LbfgsParams,
    /// Choices of target-driven smoke.
    pub pd: PdParams,
    /// Choices of every simulation: of `Simulate`, and but for buoyancy of `Lbfgs` and `Pd`.
    pub simulation: SimulationParams,
}

impl Default for Params {
    fn default() -> Self {
        Self {
            method: Method::Direct,
            iterations: 60,
            threads: 1,
            ceiling: None,
            admm: AdmmParams::default(),
            direct: DirectParams::default(),
            lbfgs: LbfgsParams::default(),
            pd: PdParams::default(),
            simulation: SimulationParams::default(),
        }
    }
}

/// Most outer iterations: more than any run needs.
pub const MAX_ITERATIONS: usize = 1_000_000;
/// Most threads that a plan serves.
pub const MAX_THREADS: usize = 1024;

/// Why a [`Plan`] is refused.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum PlanError {
    /// The problem or a parameter is wrong.
    Problem(ProblemError),
    /// `iterations` or `threads` is 0 or absurd.
    OutOfRange {
        /// The field.
        field: &'static str,
        /// The value.
        given: usize,
        /// The largest value.
        most: usize,
    },
    /// The sizes do not fit this machine's addresses.
    TooLarge,
}

impl fmt::Display for PlanError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Problem(error) => error.fmt(f),
            Self::OutOfRange { field, given, most } => {
                write!(f, "{field} is {given}; it must be from 1 to {most}")
            }
            Self::TooLarge => write!(
                f,
                "cells times steps is more than this machine can address; use fewer cells or steps"
            ),
        }
    }
}

impl core::error::Error for PlanError {}

impl From<ProblemError> for PlanError {
    fn from(error: ProblemError) -> Self {
        Self::Problem(error)
    }
}

/// What a plan chooses to fit its bytes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Choice {
    /// ADMM: how the smoother uses its memory.
    shape: Shape,
    /// The direct method: pairs of L-BFGS.
    pub(super) history: usize,
    /// The direct method: whether two threads may do different works at a time.
    tandem: bool,
}

/// Every buffer of a solve, to the byte.
#[derive(Clone, Debug)]
pub struct Plan {
    ledger: Ledger,
    bytes: usize,
    method_bytes: usize,
    paper_bound: usize,
    saved_bytes: usize,
    pub(super) choice: Choice,
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
        match params.method {
            Method::Admm => Self::of_admm::<T, S>(problem, params),
            Method::Direct => Self::of_direct::<T, S>(problem, params),
            Method::Lbfgs | Method::Pd | Method::Simulate => Self::with::<T, S>(
                problem,
                params,
                Choice {
                    shape: Shape::LEAST,
                    history: params.lbfgs.history,
                    tandem: false,
                },
            ),
        }
    }

    /// The fastest shape of the smoother's memory within the ceiling and the paper's bound, the fastest of all if there is none.
    #[inline(never)]
    fn of_admm<T: Real, S: Space>(problem: &Problem<'_>, params: &Params) -> Result<Self, PlanError> {
        let with = |shape: Shape| {
            Self::with::<T, S>(
                problem,
                params,
                Choice {
                    shape,
                    history: 0,
                    tandem: false,
                },
            )
        };
        let (mut fastest, mut within_ceiling) = (None, None);
        let mut smallest: Option<(usize, Shape)> = None;
        for shape in Shape::all::<T, S>(&problem.grid()) {
            let plan = with(shape)?;
            let fits = params.ceiling.is_none_or(|ceiling| plan.bytes <= ceiling);
            if fits && plan.method_bytes <= plan.paper_bound {
                return Ok(plan);
            }
            if fits && within_ceiling.is_none() {
                within_ceiling = Some(shape);
            }
            if smallest.is_none_or(|(bytes, _)| plan.bytes < bytes) {
                smallest = Some((plan.bytes, shape));
            }
            fastest = fastest.or(Some(shape));
        }
        let chosen = if params.ceiling.is_some() {
            within_ceiling.or(smallest.map(|(_, shape)| shape))
        } else {
            fastest
        };
        with(chosen.ok_or(PlanError::TooLarge)?)
    }

    /// As many pairs as are asked for, or as many as the ceiling allows one thread, so that results do not depend on threads; two threads that do
    /// different works where it allows that too.
    #[inline(never)]
    fn of_direct<T: Real, S: Space>(problem: &Problem<'_>, params: &Params) -> Result<Self, PlanError> {
        let choice = |history: usize, tandem: bool| Choice {
            shape: Shape::LEAST,
            history,
            tandem,
        };
        let fits = |choice: Choice, threads: usize| match params.ceiling {
            Some(ceiling) => Ok::<_, PlanError>(
                Self::bytes_with::<T, S>(problem, &Params { threads, ..*params }, choice)? <= ceiling,
            ),
            None => Ok(true),
        };
        let least = params.direct.history.unwrap_or(1);
        let mut history = params.direct.history.unwrap_or(DirectParams::MOST_BY_DEFAULT);
        while history > least && !fits(choice(history, false), 1)? {
            history -= 1;
        }
        let tandem = fits(choice(history, true), params.threads)?;
        Self::with::<T, S>(problem, params, choice(history, tandem))
    }

    /// Bytes alone: a plan takes much of a stack.
    #[inline(never)]
    fn bytes_with<T: Real, S: Space>(
        problem: &Problem<'_>,
        params: &Params,
        choice: Choice,
    ) -> Result<usize, PlanError> {
        Self::with::<T, S>(problem, params, choice).map(|plan| plan.bytes)
    }

    #[inline(never)]
    fn with<T: Real, S: Space>(
        problem: &Problem<'_>,
        params: &Params,
        choice: Choice,
    ) -> Result<Self, PlanError> {
        let mut ledger = Ledger::new();
        let (keyframes, cells) = (problem.keyframes.len(), problem.grid().cells());
        ledger.group("the method", Sharing::Together, |ledger| {
            Engine::<T, S>::requirement(ledger, problem, params, choice)
        });
        ledger.line("keyframe steps", keyframes, 4);
        ledger.line("keyframe densities", keyframes * cells, T::BYTES);
        let bytes = ledger.bytes().ok_or(PlanError::TooLarge)?;
        let method_bytes = ledger.entries().first().map_or(0, |entry| entry.bytes);
        // No more numbers than the block has.
        let numbers = Engine::<T, S>::live(problem, params, choice) + keyframes * cells;
        let saved_bytes = (numbers * T::BYTES)
            .checked_add(checkpoint::HEAD)
            .ok_or(PlanError::TooLarge)?;
        Ok(Self {
            ledger,
            bytes,
            method_bytes,
            paper_bound: paper_bound::<T, S>(problem),
            saved_bytes,
            choice,
        })
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

fn check<T: Real, S: Space>(problem: &Problem<'_>, params: &Params) -> Result<(), PlanError> {
    if problem.cells.len() != S::DIM {
        return Err(ProblemError::Dimensions {
            expected: S::DIM,
            given: problem.cells.len(),
        }
        .into());
    }
    problem.check()?;
    if problem.keyframes.is_empty() && params.method != Method::Simulate {
        return Err(ProblemError::NoKeyframe.into());
    }
    params.admm.check()?;
    params.direct.check()?;
    params.lbfgs.check()?;
    params.pd.check()?;
    params.simulation.check()?;
    let ranges = [
        ("iterations", params.iterations, MAX_ITERATIONS),
        ("threads", params.threads, MAX_THREADS),
        (
            "admm.ao_iterations",
            params.admm.ao_iterations,
            AdmmParams::MOST_AO_ITERATIONS,
        ),
        (
            "direct.history",
            params.direct.history.unwrap_or(1),
            DirectParams::MOST,
        ),
        ("lbfgs.history", params.lbfgs.history, LbfgsParams::MOST),
        ("admm.nso_cycles", params.admm.nso.cycles, nso::MAX_CYCLES - 1),
    ];
    for (field, given, most) in ranges {
        if !(1..=most).contains(&given) {
            return Err(PlanError::OutOfRange { field, given, most });
        }
    }
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
    let (numbers, power) = (
        4 * (1 + S::DIM as u128) * problem.steps as u128 * cells,
        1u128 << S::DIM,
    );
    usize::try_from(numbers * T::BYTES as u128 * power / (power - 1)).unwrap_or(usize::MAX)
}

pub(super) fn admm_settings(problem: &Problem<'_>, params: &Params, choice: Choice) -> admm::Settings {
    let (threads, shape) = (params.threads, choice.shape);
    let dimensions = Dimensions {
        grid: problem.grid(),
        slots: problem.slots(),
        filters: problem.filters(),
        threads,
        shape,
    };
    admm::Settings::new(problem, &params.admm, dimensions, params.iterations)
}

pub(super) fn direct_settings(problem: &Problem<'_>, params: &Params, choice: Choice) -> direct::Settings {
    direct::Settings::new(
        problem,
        &params.direct,
        choice.history,
        params.threads,
        choice.tandem,
        params.iterations,
    )
}

pub(super) fn lbfgs_settings(problem: &Problem<'_>, params: &Params) -> lbfgs::Settings {
    lbfgs::Settings::new(
        problem,
        &params.lbfgs,
        params.simulation.tolerance,
        params.threads,
        params.iterations,
    )
}

pub(super) fn forward_settings(problem: &Problem<'_>, params: &Params) -> forward::Settings {
    let target = (params.method == Method::Pd).then_some(params.pd);
    forward::Settings::new(problem, &params.simulation, target, params.threads)
}
