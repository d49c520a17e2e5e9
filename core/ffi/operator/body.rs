//! An operator in the caller's memory.

use super::config::{Chosen, ThuribleOperatorConfig};
use crate::config::{ConfigError, ThuribleConfig};
use crate::fluids::{AnyFluids, Planned, made};
use crate::instance::{self, Any, Handle, with_place};
use crate::result::ThuribleResult;
use crate::steps::{PARTS, lens};
use crate::typed;
use thurible_core::{D2, D3, Operator, OperatorParams, OperatorPlan, Problem, Real, Space};

/// A simulation that can be differentiated, in memory of the caller: a handle, whose inside is the library's.
pub struct ThuribleOperator {
    _inside: (),
}

impl Handle for ThuribleOperator {
    type Body = Body;
    const MARK: usize = 0x4f70_6572;
}

type Implicit = Any<
    Operator<'static, f32, D2>,
    Operator<'static, f64, D2>,
    Operator<'static, f32, D3>,
    Operator<'static, f64, D3>,
>;

/// A simulator of either kind, precision and dimension.
#[derive(Debug)]
#[expect(
    clippy::large_enum_variant,
    reason = "it lies once in the caller's block, and there is no heap for the larger one"
)]
pub enum AnySimulator {
    /// On the staggered grid.
    Implicit(Implicit),
    /// Stable Fluids.
    Fluids(AnyFluids),
}

/// Evaluates `$call` with `$one` bound to the simulator, whatever its type.
macro_rules! simulator {
    ($any:expr, $one:ident => $call:expr) => {
        match $any {
            $crate::operator::AnySimulator::Implicit(any) => $crate::each!(any, $one => $call),
            $crate::operator::AnySimulator::Fluids(any) => $crate::each!(any, $one => $call),
        }
    };
}

pub(super) use simulator;

/// What is behind the handle.
#[derive(Debug)]
pub struct Body {
    /// The simulator, in the block behind the place.
    pub simulator: AnySimulator,
    /// Numbers of a density and of each component, 0 where there is none.
    pub lens: [usize; PARTS],
    /// Bytes of a number.
    pub number: usize,
    /// Steps N.
    pub steps: usize,
    /// How many emitters there are.
    pub emitters: usize,
    /// Threads that memory was planned for.
    pub threads: usize,
    /// Whether there is a simulation to take back.
    pub simulated: bool,
    /// Whether there is a gradient to read.
    pub differentiated: bool,
}

/// Plans an operator.
///
/// # Errors
/// [`ConfigError`].
///
/// # Safety
/// As [`ThuribleOperatorConfig::with`].
#[inline(never)]
pub unsafe fn plan(scene: &ThuribleConfig, config: &ThuribleOperatorConfig) -> Result<Planned, ConfigError> {
    let (kind, ceiling) = (scene.kind()?, scene.ceiling());
    // SAFETY: the caller's promise.
    let planned = unsafe {
        config.with(scene, |problem, chosen| match chosen {
            Chosen::Implicit(params) => typed!(kind, T, S, _W => implicit::<T, S>(problem, params)),
            Chosen::Fluids(params, slots) => typed!(kind, T, S, _W => {
                Planned::behind::<ThuribleOperator, T, S>(problem, params, (*slots, ceiling))
            }),
        })
    };
    planned.flatten()
}

#[inline(never)]
fn implicit<T: Real, S: Space>(
    problem: &Problem<'_>,
    params: &OperatorParams,
) -> Result<Planned, ConfigError> {
    let plan = OperatorPlan::new::<T, S>(problem, params)?;
    Ok(Planned {
        bytes: with_place::<ThuribleOperator>(plan.bytes())?,
        // An operator is not saved.
        saved: 0,
        slots: plan.slots(),
        repeated: plan.repeated_steps(),
    })
}

/// Makes an operator in the first bytes of `memory`.
///
/// # Errors
/// [`ThuribleResult`].
///
/// # Safety
/// `memory` is null or points to `bytes` bytes that nobody else uses while the operator lives; otherwise as [`plan`].
pub unsafe fn make(
    memory: *mut u8,
    bytes: usize,
    scene: &ThuribleConfig,
    config: &ThuribleOperatorConfig,
) -> Result<*mut ThuribleOperator, ThuribleResult> {
    let kind = scene.kind().map_err(ConfigError::result)?;
    let room = (memory, bytes);
    // SAFETY: the caller's promises.
    let simulator = unsafe {
        config.with(scene, |problem, chosen| match chosen {
            Chosen::Implicit(params) => typed!(kind, T, S, Wrap => {
                of_implicit::<T, S>(room, problem, params).map(|one| AnySimulator::Implicit(Wrap(one)))
            }),
            Chosen::Fluids(params, slots) => typed!(kind, T, S, Wrap => {
                made::<ThuribleOperator, T, S>(room, problem, params, (*slots, scene.ceiling()))
                    .map(|one| AnySimulator::Fluids(Wrap(one)))
            }),
        })
    };
    let simulator = simulator.map_err(ConfigError::result)??;
    let (precision, _) = kind;
    let lens = simulator!(&simulator, one => lens(one));
    let body = Body {
        simulator,
        lens,
        number: precision as usize,
        steps: scene.steps,
        emitters: scene.emitter_count,
        threads: scene.threads,
        simulated: false,
        differentiated: false,
    };
    let handle: *mut ThuribleOperator = memory.cast();
    // SAFETY: the caller's promise; the bytes before the block are the place's.
    unsafe { instance::settle(handle, body) };
    Ok(handle)
}

/// # Safety
/// As [`make`].
#[inline(never)]
unsafe fn of_implicit<T: Real, S: Space>(
    (memory, bytes): (*mut u8, usize),
    problem: &Problem<'_>,
    params: &OperatorParams,
) -> Result<Operator<'static, T, S>, ThuribleResult> {
    let needed = implicit::<T, S>(problem, params)
        .map_err(ConfigError::result)?
        .bytes;
    // SAFETY: the caller's promise.
    let block = unsafe { instance::behind::<ThuribleOperator>(memory, bytes, needed) }?;
    Ok(Operator::new(problem, params, block)?)
}
