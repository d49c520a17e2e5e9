//! How many bytes an instance takes.

use super::body::Thurible;
use super::handle::block;
use crate::config::{ConfigError, ThuribleConfig, ThuriblePrecision, precision};
use crate::result::ThuribleResult;
use thurible_core::{D2, D3, Params, Plan, Problem, Real, Space};

/// Bytes of an instance, and of one that is saved.
#[derive(Clone, Copy, Debug)]
pub struct Planned {
    /// Bytes of memory that the caller must bring.
    pub bytes: usize,
    /// Bytes that a saved instance takes.
    pub saved: usize,
}

/// Plans an instance.
///
/// # Errors
/// [`ConfigError`].
///
/// # Safety
/// The lists of `config` have as many entries as it says.
pub unsafe fn plan(config: &ThuribleConfig) -> Result<Planned, ConfigError> {
    // SAFETY: the caller's promise.
    let planned = unsafe {
        config.with(|problem, params| match choose(config)? {
            (ThuriblePrecision::F32, 2) => sizes_of::<f32, D2>(problem, params),
            (ThuriblePrecision::F64, 2) => sizes_of::<f64, D2>(problem, params),
            (ThuriblePrecision::F32, _) => sizes_of::<f32, D3>(problem, params),
            (ThuriblePrecision::F64, _) => sizes_of::<f64, D3>(problem, params),
        })
    };
    planned.flatten()
}

/// Precision and dimension, which choose the type of the solver.
pub(super) fn choose(config: &ThuribleConfig) -> Result<(ThuriblePrecision, u32), ConfigError> {
    Ok((precision(config.precision)?, config.dimensions))
}

// Not inlined, as the functions in `body`.
#[inline(never)]
fn sizes_of<T: Real, S: Space>(problem: &Problem<'_>, params: &Params) -> Result<Planned, ConfigError> {
    let plan = Plan::new::<T, S>(problem, params)?;
    let bytes = plan
        .bytes()
        .checked_add(const { block::<Thurible>() })
        .ok_or(ConfigError::Result(ThuribleResult::TooLarge))?;
    Ok(Planned {
        bytes,
        saved: plan.saved_bytes(),
    })
}
