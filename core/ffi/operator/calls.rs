//! Plan, make, fill and close an operator, and say why a call was refused.

use super::body::{Body, ThuribleOperator, make, plan, simulator};
use super::config::ThuribleOperatorConfig;
use crate::config::{ConfigError, ThuribleConfig, sized};
use crate::instance::{self, asked};
use crate::pointer::{elements, flags};
use crate::result::ThuribleResult;
use core::ffi::{c_char, c_void};
use thurible_core::operator::Simulator;

/// Scene and configuration, the defaults where that is null.
///
/// # Safety
/// They are null or point to configurations.
unsafe fn read(
    scene: *const ThuribleConfig,
    config: *const ThuribleOperatorConfig,
) -> Result<(ThuribleConfig, ThuribleOperatorConfig), ConfigError> {
    // SAFETY: the caller's promise.
    unsafe {
        let scene = sized::read(scene)?;
        let config = if config.is_null() {
            ThuribleOperatorConfig::default()
        } else {
            sized::read(config)?
        };
        Ok((scene, config))
    }
}

/// As `thurible_explain`, of an operator's scene and configuration.
///
/// # Safety
/// `scene` and `config` are null or point to configurations whose lists are there; `buffer` is null or points to `size` bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn thurible_operator_explain(
    scene: *const ThuribleConfig,
    config: *const ThuribleOperatorConfig,
    buffer: *mut c_char,
    size: usize,
) -> usize {
    // SAFETY: the caller's promises.
    unsafe {
        let planned = read(scene, config).and_then(|(scene, config)| plan(&scene, &config));
        asked::explain(planned, buffer, size)
    }
}

/// How many bytes an operator takes, on which multiple of bytes they must begin, how many states it keeps (0 where all that an adjoint reads is kept, or
/// nothing), and how many steps a gradient repeats. A null `config` stands for the defaults; each pointer but `scene` may be null.
///
/// # Safety
/// `scene` and `config` are null or point to configurations whose lists are there; the others are null or may be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn thurible_operator_plan(
    scene: *const ThuribleConfig,
    config: *const ThuribleOperatorConfig,
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

/// Makes an operator in `memory`, as `thurible_init` makes an instance.
///
/// # Safety
/// `memory` is null or points to `bytes` bytes that nobody else uses; `scene` and `config` as in `thurible_operator_plan`; `out` is null or may be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn thurible_operator_init(
    memory: *mut c_void,
    bytes: usize,
    scene: *const ThuribleConfig,
    config: *const ThuribleOperatorConfig,
    out: *mut *mut ThuribleOperator,
) -> ThuribleResult {
    // SAFETY: the caller's promises.
    unsafe {
        asked::init(out, || {
            let (scene, config) = read(scene, config).map_err(ConfigError::result)?;
            make(memory.cast(), bytes, &scene, &config)
        })
    }
}

/// Ends an operator: its memory is the caller's again.
///
/// # Safety
/// `operator_` is null or points to memory of an operator's size.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn thurible_operator_close(operator_: *mut ThuribleOperator) -> ThuribleResult {
    // SAFETY: the caller's promise.
    unsafe { instance::close(operator_) }
}

/// As `thurible_message`, of the last call with this operator.
///
/// # Safety
/// `operator_` as in `thurible_operator_close`; `buffer` is null or points to `size` bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn thurible_operator_message(
    operator_: *const ThuribleOperator,
    buffer: *mut c_char,
    size: usize,
) -> usize {
    // SAFETY: the caller's promises.
    unsafe { instance::message(operator_, buffer, size) }
}

/// Sets which cells are solid, before anything is simulated, as `thurible_set_solids`. Refused where `solids` of the scene is 0.
///
/// # Safety
/// `operator_` as in `thurible_operator_close`; `solid` is null or points to `bytes` bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn thurible_operator_set_solids(
    operator_: *mut ThuribleOperator,
    solid: *const u8,
    bytes: usize,
) -> ThuribleResult {
    // SAFETY: the caller's promises.
    unsafe {
        instance::enter(operator_, |body| {
            let solid = flags(solid, bytes)?;
            simulator!(&mut body.simulator, one => Simulator::set_solids(one, solid))?;
            forget(body);
            Ok(())
        })
    }
}

/// Sets the shape of emitter `index`, as `thurible_set_emitter`.
///
/// # Safety
/// `operator_` as in `thurible_operator_close`; `shape` is null or points to `bytes` bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn thurible_operator_set_emitter(
    operator_: *mut ThuribleOperator,
    index: usize,
    shape: *const c_void,
    bytes: usize,
) -> ThuribleResult {
    // SAFETY: the caller's promises.
    unsafe {
        instance::enter(operator_, |body| {
            simulator!(&mut body.simulator, one => Simulator::set_emitter(one, index, elements(shape, bytes)?))?;
            forget(body);
            Ok(())
        })
    }
}

/// What was simulated was another scene.
fn forget(body: &mut Body) {
    (body.simulated, body.differentiated) = (false, false);
}
