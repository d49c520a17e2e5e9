//! Plan, make, fill and close a search, and say why a call was refused.

use super::body::{ThuribleFluids, make, plan};
use super::config::ThuribleFluidsConfig;
use crate::config::{ConfigError, ThuribleConfig, sized};
use crate::each;
use crate::instance::{self, asked};
use crate::pointer::{elements, put, writable};
use crate::result::ThuribleResult;
use core::ffi::{c_char, c_void};

/// Scene and configuration.
///
/// # Safety
/// They are null or point to configurations.
pub unsafe fn read(
    scene: *const ThuribleConfig,
    config: *const ThuribleFluidsConfig,
) -> Result<(ThuribleConfig, ThuribleFluidsConfig), ConfigError> {
    // SAFETY: the caller's promise.
    unsafe { Ok((sized::read(scene)?, sized::read(config)?)) }
}

/// As `thurible_explain`, of the scene and the configuration of a search.
///
/// # Safety
/// `scene` and `config` are null or point to configurations whose lists are there; `buffer` is null or points to `size` bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn thurible_fluids_explain(
    scene: *const ThuribleConfig,
    config: *const ThuribleFluidsConfig,
    buffer: *mut c_char,
    size: usize,
) -> usize {
    // SAFETY: the caller's promises.
    unsafe {
        let planned = read(scene, config).and_then(|(scene, config)| plan(&scene, &config));
        asked::explain(planned, buffer, size)
    }
}

/// As `thurible_operator_plan`, of a search by Stable Fluids.
///
/// # Safety
/// `scene` and `config` are null or point to configurations whose lists are there; the others are null or may be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn thurible_fluids_plan(
    scene: *const ThuribleConfig,
    config: *const ThuribleFluidsConfig,
    bytes: *mut usize,
    alignment: *mut usize,
    slots: *mut usize,
    repeated: *mut usize,
) -> ThuribleResult {
    // SAFETY: the caller's promises.
    unsafe {
        asked::plan([bytes, slots, repeated], alignment, || {
            let planned = read(scene, config).and_then(|(scene, config)| plan(&scene, &config))?;
            Ok([planned.bytes, planned.slots, planned.repeated])
        })
    }
}

/// Makes a search in `memory`, as `thurible_init` makes an instance.
///
/// # Safety
/// `memory` is null or points to `bytes` bytes that nobody else uses; `scene` and `config` as in `thurible_fluids_plan`; `out` is null or may be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn thurible_fluids_init(
    memory: *mut c_void,
    bytes: usize,
    scene: *const ThuribleConfig,
    config: *const ThuribleFluidsConfig,
    out: *mut *mut ThuribleFluids,
) -> ThuribleResult {
    // SAFETY: the caller's promises.
    unsafe {
        asked::init(out, || {
            let (scene, config) = read(scene, config).map_err(ConfigError::result)?;
            make(memory.cast(), bytes, &scene, &config)
        })
    }
}

/// Ends a search: its memory is the caller's again.
///
/// # Safety
/// `fluids` is null or points to memory of a search's size.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn thurible_fluids_close(fluids: *mut ThuribleFluids) -> ThuribleResult {
    // SAFETY: the caller's promise.
    unsafe { instance::close(fluids) }
}

/// As `thurible_message`, of the last call with this search.
///
/// # Safety
/// `fluids` as in `thurible_fluids_close`; `buffer` is null or points to `size` bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn thurible_fluids_message(
    fluids: *const ThuribleFluids,
    buffer: *mut c_char,
    size: usize,
) -> usize {
    // SAFETY: the caller's promises.
    unsafe { instance::message(fluids, buffer, size) }
}

/// Sets the density at the start, as `thurible_set_source`.
///
/// # Safety
/// `fluids` as in `thurible_fluids_close`; `density` is null or points to `bytes` bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn thurible_fluids_set_source(
    fluids: *mut ThuribleFluids,
    density: *const c_void,
    bytes: usize,
) -> ThuribleResult {
    // SAFETY: the caller's promises.
    unsafe {
        instance::enter(fluids, |body| {
            Ok(each!(&mut body.fluids, one => one.set_source(elements(density, bytes)?))?)
        })
    }
}

/// Sets the target of keyframe `index`, after the source, as `thurible_set_keyframe`.
///
/// # Safety
/// As `thurible_fluids_set_source`; `factor` is null or may be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn thurible_fluids_set_keyframe(
    fluids: *mut ThuribleFluids,
    index: usize,
    density: *const c_void,
    bytes: usize,
    factor: *mut f64,
) -> ThuribleResult {
    // SAFETY: the caller's promises.
    unsafe {
        instance::enter(fluids, |body| {
            writable(factor)?;
            let found = each!(&mut body.fluids, one => one.set_keyframe(index, elements(density, bytes)?))?;
            put(factor, found);
            Ok(())
        })
    }
}

/// Sets component `axis` of the velocity at the start, at the centres of cells and in the scene's units, where `initial_velocity` of the configuration is 1.
///
/// # Safety
/// As `thurible_fluids_set_source`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn thurible_fluids_set_initial_velocity(
    fluids: *mut ThuribleFluids,
    axis: usize,
    velocity: *const c_void,
    bytes: usize,
) -> ThuribleResult {
    // SAFETY: the caller's promises.
    unsafe {
        instance::enter(fluids, |body| {
            Ok(each!(&mut body.fluids, one => one.set_initial_velocity(axis, elements(velocity, bytes)?))?)
        })
    }
}
