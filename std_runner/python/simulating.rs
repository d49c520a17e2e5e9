//! Which simulator an operator has: chosen by words, planned under its ceiling, made in its block.

use crate::choices::{Choices, set_options};
use crate::plan::{Precision, under_ceiling};
use crate::words::{automatic, number, one_of, refused};
use core::mem::MaybeUninit;
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use pyo3::types::PyMapping;
use thurible_core::operator::Simulator;
use thurible_core::stable_fluids::{Controls, NAME, Slots};
use thurible_core::{
    D2, D3, Fluids, FluidsParams, FluidsPlan, Operator, OperatorParams, OperatorPlan, PlanError, Problem,
    Real, SolverError, Space,
};

/// An operator of either simulator, in either dimension.
type Boxed<T> = Box<dyn Simulator<T> + Send + Sync>;

/// An operator of either precision.
pub enum Any {
    /// Of `float32`.
    Single(Boxed<f32>),
    /// Of `float64`.
    Double(Boxed<f64>),
}

/// Calls `$work` with the operator, whatever it is.
macro_rules! each {
    ($any:expr, $one:ident => $work:expr) => {
        match $any {
            $crate::simulating::Any::Single($one) => $work,
            $crate::simulating::Any::Double($one) => $work,
        }
    };
}

pub(crate) use each;

/// Evaluates `$call` by the types of a precision and a number of axes.
macro_rules! typed {
    ($kind:expr, $real:ident, $space:ident => $call:expr) => {
        match $kind {
            (Precision::Single, 2) => typed!(@ f32, D2, $real, $space, $call),
            (Precision::Double, 2) => typed!(@ f64, D2, $real, $space, $call),
            (Precision::Single, _) => typed!(@ f32, D3, $real, $space, $call),
            (Precision::Double, _) => typed!(@ f64, D3, $real, $space, $call),
        }
    };
    (@ $of:ty, $dim:ty, $real:ident, $space:ident, $call:expr) => {{
        type $real = $of;
        type $space = $dim;
        $call
    }};
}

/// What simulates, and what is chosen for it.
#[derive(Clone, Copy)]
pub enum Chosen {
    /// The implicit solver on the staggered grid.
    Implicit(OperatorParams),
    /// Stable Fluids, and what is to be kept for the way back, if that is said.
    Fluids(FluidsParams, Option<Slots>),
}

/// The words for them.
const SOLVERS: [&str; 2] = ["implicit", NAME];

/// Options of Stable Fluids that belong to its search.
const OF_SEARCH: [&str; 3] = ["initial_weight", "history", "tolerance"];

impl Chosen {
    /// What the arguments `solver`, `tolerance`, `slots` and `options` say.
    pub fn read([solver, tolerance, slots, options]: [Option<Bound<'_, PyAny>>; 4]) -> PyResult<Self> {
        let solver = solver.map_or(Ok(SOLVERS[0]), |solver| one_of("solver", &solver, &SOLVERS))?;
        let slots = slots.map_or(Ok(None), |slots| automatic("slots", &slots))?;
        if solver == NAME {
            if tolerance.is_some() {
                let why = "is of the implicit solver; Stable Fluids takes options={\"pressure\": \"cg\", \"cg_tolerance\": ..}";
                return Err(refused("tolerance", why));
            }
            let mut params = FluidsParams {
                controls: Controls::none(),
                initial_velocity: true,
                ..FluidsParams::default()
            };
            if let Some(options) = options {
                for name in OF_SEARCH {
                    if options
                        .cast::<PyMapping>()
                        .is_ok_and(|given| given.contains(name).unwrap_or(false))
                    {
                        return Err(refused(&format!("options[\"{name}\"]"), STEERS));
                    }
                }
                set_options(&mut params, &options)?;
            }
            return Ok(Self::Fluids(params, slots.map(Slots::of)));
        }
        if options.is_some() {
            return Err(refused("options", STEERS));
        }
        let mut params = OperatorParams {
            slots,
            ..OperatorParams::default()
        };
        if let Some(tolerance) = tolerance {
            params.tolerance = number("tolerance", &tolerance)?;
        }
        Ok(Self::Implicit(params))
    }

    fn set_threads(&mut self, count: usize) {
        match self {
            Self::Implicit(params) => params.threads = count,
            Self::Fluids(params, _) => params.threads = count,
        }
    }

    /// Whether everything is at the centres of cells.
    pub fn has_centers(&self) -> bool {
        matches!(self, Self::Fluids(..))
    }
}

/// Why what is chosen of a search is refused.
pub const STEERS: &str = "steers, and an operator steers nothing; take it out";

/// A plan of either simulator.
#[derive(Clone, Copy)]
pub struct Planned {
    /// Bytes of the block.
    pub bytes: usize,
    /// States that are kept; 0 where all is that an adjoint reads.
    pub slots: usize,
    /// Bytes with one state more, where there may be one.
    pub next: Option<usize>,
    /// Steps that a gradient repeats.
    pub repeated: usize,
    /// Threads.
    pub threads: usize,
    /// The choices that were planned.
    pub chosen: Chosen,
}

impl Planned {
    /// Plans under the ceiling, on fewer threads if that is what it takes and nobody asked for a number.
    pub fn new(choices: &Choices, mut chosen: Chosen, precision: Precision) -> PyResult<Self> {
        let problem = choices.scene.problem();
        let kind = (precision, choices.scene.cells.len());
        under_ceiling(choices, "operator", |threads, ceiling| {
            chosen.set_threads(threads);
            typed!(kind, T, S => of::<T, S>(&problem, chosen, ceiling, threads))
        })
    }

    /// Makes it in its memory.
    pub fn make(
        &self,
        choices: &Choices,
        precision: Precision,
        memory: &'static mut [MaybeUninit<u8>],
    ) -> PyResult<Any> {
        let (problem, chosen) = (choices.scene.problem(), self.chosen);
        let made = match (precision, choices.scene.cells.len()) {
            (Precision::Single, 2) => made::<f32, D2>(&problem, chosen, memory).map(Any::Single),
            (Precision::Double, 2) => made::<f64, D2>(&problem, chosen, memory).map(Any::Double),
            (Precision::Single, _) => made::<f32, D3>(&problem, chosen, memory).map(Any::Single),
            (Precision::Double, _) => made::<f64, D3>(&problem, chosen, memory).map(Any::Double),
        };
        made.map_err(|error| PyRuntimeError::new_err(error.to_string()))
    }
}

fn of<T: Real, S: Space>(
    problem: &Problem<'_>,
    chosen: Chosen,
    ceiling: Option<usize>,
    threads: usize,
) -> Result<Planned, PlanError> {
    match chosen {
        Chosen::Implicit(params) => {
            let params = OperatorParams { ceiling, ..params };
            let plan = OperatorPlan::new::<T, S>(problem, &params)?;
            Ok(Planned {
                bytes: plan.bytes(),
                slots: plan.slots(),
                next: plan.next_slot(),
                repeated: plan.repeated_steps(),
                threads,
                chosen: Chosen::Implicit(params),
            })
        }
        Chosen::Fluids(params, slots) => {
            let (params, plan) = FluidsPlan::within::<T, S>(problem, &params, slots, ceiling)?;
            let next = match params.slots {
                Slots::States(states) if states < problem.steps => Some(Slots::States(states + 1)),
                Slots::States(_) => Some(Slots::Tape),
                Slots::Tape | Slots::None => None,
            };
            let next = next.map(|slots| FluidsParams { slots, ..params });
            let next = next
                .map(|params| FluidsPlan::new::<T, S>(problem, &params))
                .transpose()?;
            Ok(Planned {
                bytes: plan.bytes(),
                slots: params.slots.states(),
                next: next.map(|plan| plan.bytes()),
                repeated: params.slots.repeated_steps(problem.steps),
                threads,
                chosen: Chosen::Fluids(params, Some(params.slots)),
            })
        }
    }
}

fn made<T: Real, S: Space + Send + Sync>(
    problem: &Problem<'_>,
    chosen: Chosen,
    memory: &'static mut [MaybeUninit<u8>],
) -> Result<Boxed<T>, SolverError> {
    Ok(match chosen {
        Chosen::Implicit(params) => Box::new(Operator::<T, S>::new(problem, &params, memory)?),
        Chosen::Fluids(params, _) => Box::new(Fluids::<T, S>::new(problem, &params, memory)?),
    })
}
