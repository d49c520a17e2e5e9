//! A search by Stable Fluids in the caller's memory.

use super::config::{ThuribleFluidsConfig, fitted};
use super::searched::ThuribleSearched;
use crate::config::{ConfigError, ThuribleConfig};
use crate::instance::{self, Any, Handle, with_place};
use crate::result::ThuribleResult;
use crate::typed;
use thurible_core::{D2, D3, Fluids, FluidsParams, Problem, Real, Space};

/// A search by Stable Fluids, in memory of the caller: a handle, whose inside is the library's.
pub struct ThuribleFluids {
    _inside: (),
}

impl Handle for ThuribleFluids {
    type Body = Body;
    const MARK: usize = 0x466c_7569;
}

/// Stable Fluids of either precision in either dimension.
pub type AnyFluids = Any<
    Fluids<'static, f32, D2>,
    Fluids<'static, f64, D2>,
    Fluids<'static, f32, D3>,
    Fluids<'static, f64, D3>,
>;

/// What is behind the handle.
#[derive(Debug)]
pub struct Body {
    /// The search, in the block behind the place.
    pub fluids: AnyFluids,
    /// Bytes of a number.
    pub number: usize,
    /// Threads that memory was planned for.
    pub threads: usize,
    /// How far it is.
    pub searched: ThuribleSearched,
}

/// What is planned of Stable Fluids.
#[derive(Clone, Copy, Debug)]
pub struct Planned {
    /// Bytes of memory that the caller must bring.
    pub bytes: usize,
    /// Bytes of a search that is saved.
    pub saved: usize,
    /// States that are kept for the way back.
    pub slots: usize,
    /// Steps that a gradient repeats.
    pub repeated: usize,
}

impl Planned {
    /// What is planned behind the place of an `H`; `slots` as the configuration has them.
    ///
    /// # Errors
    /// [`ConfigError`].
    // Not inlined: a plan takes much of a stack.
    #[inline(never)]
    pub fn behind<H: Handle, T: Real, S: Space>(
        problem: &Problem<'_>,
        chosen: &FluidsParams,
        (slots, ceiling): (u32, Option<usize>),
    ) -> Result<Self, ConfigError> {
        let (params, plan) = fitted::<T, S>(problem, chosen, slots, ceiling)?;
        Ok(Self {
            bytes: with_place::<H>(plan.bytes())?,
            saved: plan.saved_bytes(),
            slots: params.slots.states(),
            repeated: params.slots.repeated_steps(problem.steps),
        })
    }
}

/// Stable Fluids behind the place of an `H` in the first bytes of `memory`; `slots` as the configuration has them.
///
/// # Errors
/// [`ThuribleResult`].
///
/// # Safety
/// `memory` is null or points to `bytes` bytes that nobody else uses while they live.
#[inline(never)]
pub unsafe fn made<H: Handle, T: Real, S: Space>(
    (memory, bytes): (*mut u8, usize),
    problem: &Problem<'_>,
    chosen: &FluidsParams,
    (slots, ceiling): (u32, Option<usize>),
) -> Result<Fluids<'static, T, S>, ThuribleResult> {
    let (params, needed) = {
        let (params, plan) = fitted::<T, S>(problem, chosen, slots, ceiling)?;
        (params, with_place::<H>(plan.bytes())?)
    };
    // SAFETY: the caller's promise.
    let block = unsafe { instance::behind::<H>(memory, bytes, needed) }?;
    Ok(Fluids::new(problem, &params, block)?)
}

/// Plans a search.
///
/// # Errors
/// [`ConfigError`].
///
/// # Safety
/// The lists of the scene have as many entries as it says.
#[inline(never)]
pub unsafe fn plan(scene: &ThuribleConfig, config: &ThuribleFluidsConfig) -> Result<Planned, ConfigError> {
    let (kind, kept) = (scene.kind()?, (config.slots, scene.ceiling()));
    let chosen = config.params(scene.threads)?;
    // SAFETY: the caller's promise.
    let planned = unsafe {
        scene.with(|problem, _| {
            typed!(kind, T, S, _W => Planned::behind::<ThuribleFluids, T, S>(problem, &chosen, kept))
        })
    };
    planned.flatten()
}

/// Makes a search in the first bytes of `memory`.
///
/// # Errors
/// [`ThuribleResult`].
///
/// # Safety
/// `memory` is null or points to `bytes` bytes that nobody else uses while the search lives; otherwise as [`plan`].
pub unsafe fn make(
    memory: *mut u8,
    bytes: usize,
    scene: &ThuribleConfig,
    config: &ThuribleFluidsConfig,
) -> Result<*mut ThuribleFluids, ThuribleResult> {
    let kind = scene.kind().map_err(ConfigError::result)?;
    let chosen = config.params(scene.threads).map_err(ConfigError::result)?;
    let kept = (config.slots, scene.ceiling());
    // SAFETY: the caller's promises.
    let fluids = unsafe {
        scene.with(|problem, _| {
            typed!(kind, T, S, Wrap => {
                made::<ThuribleFluids, T, S>((memory, bytes), problem, &chosen, kept).map(Wrap)
            })
        })
    };
    let (precision, _) = kind;
    let body = Body {
        fluids: fluids.map_err(ConfigError::result)??,
        number: precision as usize,
        threads: scene.threads,
        searched: ThuribleSearched::default(),
    };
    let handle: *mut ThuribleFluids = memory.cast();
    // SAFETY: the caller's promise; the bytes before the block are the place's.
    unsafe { instance::settle(handle, body) };
    Ok(handle)
}
