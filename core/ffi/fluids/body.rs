//! A search by Stable Fluids in the caller's memory.

use super::config::{ThuribleFluidsConfig, fitted};
use super::searched::ThuribleSearched;
use crate::config::{ConfigError, ThuribleConfig};
use crate::instance::{self, Any, Handle, place_bytes};
use crate::result::ThuribleResult;
use crate::typed;
use thurible_core::{D2, D3, Fluids, SolverError};

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

/// Bytes of a search with its place, states that it keeps, and steps that a gradient repeats.
///
/// # Errors
/// [`ConfigError`].
///
/// # Safety
/// The lists of the scene have as many entries as it says.
#[inline(never)]
pub unsafe fn plan(scene: &ThuribleConfig, config: &ThuribleFluidsConfig) -> Result<[usize; 3], ConfigError> {
    let (kind, ceiling) = (scene.kind()?, scene.ceiling());
    let chosen = config.params(scene.threads)?;
    // SAFETY: the caller's promise.
    let planned = unsafe {
        scene.with(|problem, _| {
            let planned = typed!(kind, T, S, _W => fitted::<T, S>(problem, &chosen, config.slots, ceiling));
            planned.map(|(params, bytes)| {
                let repeated = params.slots.repeated_steps(problem.steps);
                [bytes, params.slots.states(), repeated]
            })
        })
    };
    let [bytes, slots, repeated] = planned?.map_err(ConfigError::Plan)?;
    let bytes = bytes.checked_add(const { place_bytes::<ThuribleFluids>() });
    let bytes = bytes.ok_or(ConfigError::Result(ThuribleResult::TooLarge))?;
    Ok([bytes, slots, repeated])
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
    // SAFETY: the caller's promises.
    let fluids = unsafe {
        let [needed, ..] = plan(scene, config).map_err(ConfigError::result)?;
        let (kind, ceiling) = (scene.kind().map_err(ConfigError::result)?, scene.ceiling());
        let chosen = config.params(scene.threads).map_err(ConfigError::result)?;
        let block = instance::behind::<ThuribleFluids>(memory, bytes, needed)?;
        scene.with(|problem, _| {
            typed!(kind, T, S, Wrap => {
                let (params, _) = fitted::<T, S>(problem, &chosen, config.slots, ceiling)?;
                Ok::<AnyFluids, SolverError>(Wrap(Fluids::<T, S>::new(problem, &params, block)?))
            })
        })
    };
    let fluids = fluids.map_err(ConfigError::result)??;
    let (precision, _) = scene.kind().map_err(ConfigError::result)?;
    let body = Body {
        fluids,
        number: precision as usize,
        threads: scene.threads,
        searched: ThuribleSearched::default(),
    };
    let handle: *mut ThuribleFluids = memory.cast();
    // SAFETY: the caller's promise; the bytes before the block are the place's.
    unsafe { instance::settle(handle, body) };
    Ok(handle)
}
