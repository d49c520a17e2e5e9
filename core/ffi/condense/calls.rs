//! Plan, make and close a condenser, and say why a call was refused.

use super::body::{ThuribleCondenser, make, plan};
use super::config::ThuribleCondenseConfig;
use crate::config::{ConfigError, sized};
use crate::instance::{self, asked};
use crate::result::ThuribleResult;
use core::ffi::{c_char, c_void};

/// How many bytes of memory, from a multiple of 8 on, `thurible_condense_plan` and `thurible_condense_explain` work in: who is joined to whom decides how many a
/// condenser takes.
///
/// # Safety
/// `config` is null or points to a configuration; `bytes` is null or may be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn thurible_condense_scratch(
    config: *const ThuribleCondenseConfig,
    bytes: *mut usize,
) -> ThuribleResult {
    // SAFETY: the caller's promises.
    unsafe {
        asked::plan([bytes], core::ptr::null_mut(), || {
            sized::read(config).and_then(|config| Ok([config.lists_bytes()?]))
        })
    }
}

/// As `thurible_explain`, of a body and how it is condensed.
///
/// # Safety
/// `config` and `scratch` as in `thurible_condense_plan`; `buffer` is null or points to `size` bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn thurible_condense_explain(
    config: *const ThuribleCondenseConfig,
    scratch: *mut c_void,
    scratch_bytes: usize,
    buffer: *mut c_char,
    size: usize,
) -> usize {
    // SAFETY: the caller's promises.
    unsafe {
        let planned = sized::read(config).and_then(|config| plan(&config, scratch, scratch_bytes));
        asked::explain(planned, buffer, size)
    }
}

/// How many bytes a condenser takes, with copies of its body's lists, and on which multiple of bytes they must begin. `scratch`, of `scratch_bytes` bytes,
/// `thurible_condense_scratch` or more, is written over and free again afterwards; `bytes` and `alignment` may be null.
///
/// # Safety
/// `config` is null or points to a configuration whose lists are there; `scratch` is null or points to as many bytes, which overlap nothing else;
/// the others are null or may be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn thurible_condense_plan(
    config: *const ThuribleCondenseConfig,
    scratch: *mut c_void,
    scratch_bytes: usize,
    bytes: *mut usize,
    alignment: *mut usize,
) -> ThuribleResult {
    // SAFETY: the caller's promises.
    unsafe {
        asked::plan([bytes], alignment, || {
            sized::read(config).and_then(|config| Ok([plan(&config, scratch, scratch_bytes)?]))
        })
    }
}

/// Makes a condenser in `memory`, as `thurible_init` makes an instance: a body at rest.
///
/// # Safety
/// `memory` is null or points to `bytes` bytes that nobody else uses; `config` as in `thurible_condense_plan`; `out` is null or may be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn thurible_condense_init(
    memory: *mut c_void,
    bytes: usize,
    config: *const ThuribleCondenseConfig,
    out: *mut *mut ThuribleCondenser,
) -> ThuribleResult {
    // SAFETY: the caller's promises.
    unsafe {
        asked::init(out, || {
            let config = sized::read(config).map_err(ConfigError::result)?;
            make(memory.cast(), bytes, &config)
        })
    }
}

/// Ends a condenser: its memory is the caller's again.
///
/// # Safety
/// `condenser` is null or points to memory of a condenser's size.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn thurible_condense_close(condenser: *mut ThuribleCondenser) -> ThuribleResult {
    // SAFETY: the caller's promise.
    unsafe { instance::close(condenser) }
}

/// As `thurible_message`, of the last call with this condenser.
///
/// # Safety
/// `condenser` as in `thurible_condense_close`; `buffer` is null or points to `size` bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn thurible_condense_message(
    condenser: *const ThuribleCondenser,
    buffer: *mut c_char,
    size: usize,
) -> usize {
    // SAFETY: the caller's promises.
    unsafe { instance::message(condenser, buffer, size) }
}
