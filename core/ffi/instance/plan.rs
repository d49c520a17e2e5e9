//! How many bytes an instance takes.

use super::body::Thurible;
use super::handle::with_place;
use crate::config::{ConfigError, ThuribleConfig};
use crate::typed;
use thurible_core::{Params, Plan, Problem, Real, Space};

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
#[inline(never)]
pub unsafe fn plan(config: &ThuribleConfig) -> Result<Planned, ConfigError> {
    // SAFETY: the caller's promise.
    let planned = unsafe {
        config.with(|problem, params| typed!(config.kind()?, T, S, _W => sizes_of::<T, S>(problem, params)))
    };
    planned.flatten()
}

// Not inlined, as the functions in `body`.
#[inline(never)]
fn sizes_of<T: Real, S: Space>(problem: &Problem<'_>, params: &Params) -> Result<Planned, ConfigError> {
    let plan = Plan::new::<T, S>(problem, params)?;
    Ok(Planned {
        bytes: with_place::<Thurible>(plan.bytes())?,
        saved: plan.saved_bytes(),
    })
}
