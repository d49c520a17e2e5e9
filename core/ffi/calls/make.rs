//! Plan, make and close an instance, and say why a call was refused.

use crate::config::{ConfigError, ThuribleConfig};
use crate::instance::{self, Planned, Thurible, asked};
use crate::result::ThuribleResult;
use core::ffi::{c_char, c_void};

/// Writes why a configuration is refused, or nothing where it is not, into `buffer` of `size` bytes, cut where it does not fit and
/// always ended by a zero byte; bytes of the whole text. A null `buffer` only counts.
///
/// # Safety
/// `config` is null or points to a configuration whose lists are there; `buffer` is null or points to `size` bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn thurible_explain(
    config: *const ThuribleConfig,
    buffer: *mut c_char,
    size: usize,
) -> usize {
    // SAFETY: the caller's promises.
    unsafe {
        let planned = ThuribleConfig::read(config).and_then(|config| instance::plan(&config));
        asked::explain(planned, buffer, size)
    }
}

/// How many bytes an instance takes, on which multiple of bytes they must begin, and how many bytes a saved one has. Nothing is
/// allocated or kept. Each pointer but `config` may be null.
///
/// # Safety
/// `config` is null or points to a configuration whose lists are there; the others are null or may be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn thurible_plan(
    config: *const ThuribleConfig,
    bytes: *mut usize,
    alignment: *mut usize,
    saved_bytes: *mut usize,
) -> ThuribleResult {
    // SAFETY: the caller's promises.
    unsafe {
        asked::plan([bytes, saved_bytes], alignment, || {
            let Planned { bytes, saved } =
                ThuribleConfig::read(config).and_then(|config| instance::plan(&config))?;
            Ok([bytes, saved])
        })
    }
}

/// Makes an instance in `memory` of `bytes` bytes, as many as `thurible_plan` says or more, and writes its handle to `out`. The
/// memory is the instance's until it is closed; it must not be moved. Nothing else is needed: no global state, no allocation.
///
/// # Safety
/// `memory` is null or points to `bytes` bytes that nobody else uses; `config` as in `thurible_plan`; `out` is null or may be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn thurible_init(
    memory: *mut c_void,
    bytes: usize,
    config: *const ThuribleConfig,
    out: *mut *mut Thurible,
) -> ThuribleResult {
    // SAFETY: the caller's promises.
    unsafe {
        asked::init(out, || {
            let config = ThuribleConfig::read(config).map_err(ConfigError::result)?;
            instance::make(memory.cast(), bytes, &config)
        })
    }
}

/// Ends an instance: its memory is the caller's again and the handle is refused from now on.
///
/// # Safety
/// `instance` is null or points to memory of an instance's size.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn thurible_close(instance: *mut Thurible) -> ThuribleResult {
    // SAFETY: the caller's promise.
    unsafe { instance::close(instance) }
}

/// Writes why the last call with this instance was refused, or nothing where it was not, as `thurible_explain` does.
///
/// # Safety
/// `instance` as in `thurible_close`; `buffer` is null or points to `size` bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn thurible_message(
    instance: *const Thurible,
    buffer: *mut c_char,
    size: usize,
) -> usize {
    // SAFETY: the caller's promises.
    unsafe { instance::message(instance, buffer, size) }
}
