//! A condenser in the caller's memory: place, lists of the body, the core's block.

use super::any::{AnyCondenser, bytes};
use super::config::ThuribleCondenseConfig;
use crate::config::ConfigError;
use crate::instance::{self, Handle, with_place};
use crate::pointer::required;
use crate::result::ThuribleResult;
use core::ffi::c_void;
use core::mem::MaybeUninit;

/// An elastic body whose energy is minimised step by step, in memory of the caller: a handle, whose inside is the library's.
pub struct ThuribleCondenser {
    _inside: (),
}

impl Handle for ThuribleCondenser {
    type Body = Body;
    const MARK: usize = 0x436f_6e64;
}

/// What is behind the handle.
#[derive(Debug)]
pub struct Body {
    /// The condenser, in the block behind the place.
    pub condenser: AnyCondenser,
    /// Components of a vector.
    pub dims: usize,
    /// Threads that memory was planned for.
    pub threads: usize,
    /// Whether steps are implicit.
    pub implicit: bool,
}

/// Bytes of a condenser with its place; its lists are put into `scratch` of `size` bytes for a while.
///
/// # Errors
/// [`ConfigError`].
///
/// # Safety
/// The lists of `config` have as many entries as it says; `scratch` is null or points to `size` bytes to write that overlap none of them.
pub unsafe fn plan(
    config: &ThuribleCondenseConfig,
    scratch: *mut c_void,
    size: usize,
) -> Result<usize, ConfigError> {
    if size < config.lists_bytes()? {
        return Err(ThuribleResult::TooSmall.into());
    }
    required(scratch.cast::<f64>())?;
    let scratch: *mut MaybeUninit<u8> = scratch.cast();
    // SAFETY: not null, and the caller promises the bytes, of which nothing is used after this call.
    let own = unsafe {
        bytes(
            config,
            core::slice::from_raw_parts_mut(scratch, size.min(isize::MAX as usize)),
        )
    }?;
    Ok(with_place::<ThuribleCondenser>(own)?)
}

/// Makes a condenser in the first bytes of `memory`.
///
/// # Errors
/// [`ThuribleResult`].
///
/// # Safety
/// `memory` is null or points to `size` bytes that nobody else uses while the condenser lives; otherwise as [`plan`].
pub unsafe fn make(
    memory: *mut u8,
    size: usize,
    config: &ThuribleCondenseConfig,
) -> Result<*mut ThuribleCondenser, ThuribleResult> {
    let kind = config.kind().map_err(ConfigError::result)?;
    let params = config.params().map_err(ConfigError::result)?;
    let lists = config.lists_bytes().map_err(ConfigError::result)?;
    // How many bytes there must be is known when the lists are in the first of them.
    let enough = with_place::<ThuribleCondenser>(lists)?.max(size);
    if enough > isize::MAX as usize {
        return Err(ThuribleResult::TooLarge);
    }
    // SAFETY: the caller's promises.
    let condenser = unsafe {
        let block = instance::behind::<ThuribleCondenser>(memory, size, enough)?;
        let (own, block) = block
            .split_at_mut_checked(lists)
            .ok_or(ThuribleResult::TooSmall)?;
        let (mesh, topology) = config.body(own).map_err(ConfigError::result)?;
        AnyCondenser::new(kind, mesh, topology, params, block)?
    };
    let body = Body {
        condenser,
        dims: kind.1,
        threads: config.threads,
        implicit: params.dt.is_some(),
    };
    let handle: *mut ThuribleCondenser = memory.cast();
    // SAFETY: the caller's promise; the bytes before the lists are the place's.
    unsafe { instance::settle(handle, body) };
    Ok(handle)
}
