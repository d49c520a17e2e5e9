//! Plan, make, fill and close a reconstruction, and say why a call was refused.

use super::body::{ThuribleTomography, make, plan};
use super::config::ThuribleTomographyConfig;
use crate::config::{ConfigError, sized};
use crate::each;
use crate::instance::{self, asked};
use crate::pointer::elements;
use crate::result::ThuribleResult;
use core::ffi::{c_char, c_void};

/// As `thurible_explain`, of a reconstruction's configuration.
///
/// # Safety
/// `config` is null or points to a configuration whose lists are there; `buffer` is null or points to `size` bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn thurible_tomography_explain(
    config: *const ThuribleTomographyConfig,
    buffer: *mut c_char,
    size: usize,
) -> usize {
    // SAFETY: the caller's promises.
    unsafe {
        let planned = sized::read(config).and_then(|config| plan(&config));
        asked::explain(planned, buffer, size)
    }
}

/// How many bytes a reconstruction takes, and on which multiple of bytes they must begin. Each pointer but `config` may be null.
///
/// # Safety
/// `config` is null or points to a configuration whose lists are there; the others are null or may be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn thurible_tomography_plan(
    config: *const ThuribleTomographyConfig,
    bytes: *mut usize,
    alignment: *mut usize,
) -> ThuribleResult {
    // SAFETY: the caller's promises.
    unsafe {
        asked::plan([bytes], alignment, || {
            sized::read(config).and_then(|config| Ok([plan(&config)?]))
        })
    }
}

/// Makes a reconstruction in `memory`, as `thurible_init` makes an instance.
///
/// # Safety
/// `memory` is null or points to `bytes` bytes that nobody else uses; `config` as in `thurible_tomography_plan`; `out` is null or may be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn thurible_tomography_init(
    memory: *mut c_void,
    bytes: usize,
    config: *const ThuribleTomographyConfig,
    out: *mut *mut ThuribleTomography,
) -> ThuribleResult {
    // SAFETY: the caller's promises.
    unsafe {
        asked::init(out, || {
            let config = sized::read(config).map_err(ConfigError::result)?;
            make(memory.cast(), bytes, &config)
        })
    }
}

/// Ends a reconstruction: its memory is the caller's again.
///
/// # Safety
/// `tomography` is null or points to memory of a reconstruction's size.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn thurible_tomography_close(tomography: *mut ThuribleTomography) -> ThuribleResult {
    // SAFETY: the caller's promise.
    unsafe { instance::close(tomography) }
}

/// As `thurible_message`, of the last call with this reconstruction.
///
/// # Safety
/// `tomography` as in `thurible_tomography_close`; `buffer` is null or points to `size` bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn thurible_tomography_message(
    tomography: *const ThuribleTomography,
    buffer: *mut c_char,
    size: usize,
) -> usize {
    // SAFETY: the caller's promises.
    unsafe { instance::message(tomography, buffer, size) }
}

/// Gives what camera `camera` measured in the next frame: a number of the precision for each pixel, row by row, in density times cells; `bytes` of
/// all. Every camera is given anew for each frame.
///
/// # Safety
/// `tomography` as in `thurible_tomography_close`; `pixels` is null or points to `bytes` bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn thurible_tomography_measure(
    tomography: *mut ThuribleTomography,
    camera: usize,
    pixels: *const c_void,
    bytes: usize,
) -> ThuribleResult {
    // SAFETY: the caller's promises.
    unsafe {
        instance::enter(tomography, |body| {
            if camera >= body.cameras {
                return Err(ThuribleResult::Index.into());
            }
            each!(&mut body.reconstruction, one => one.measure(camera, elements(pixels, bytes)?)?);
            body.measured |= 1 << camera;
            Ok(())
        })
    }
}

/// Begins frame `frame` with the pictures that were given: from nothing, or, `warm` being 1, from the density of the frame before, with
/// `warm_budget` of the budget. The first frame, and one behind a dark frame, begin from nothing alone.
///
/// # Safety
/// `tomography` as in `thurible_tomography_close`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn thurible_tomography_begin(
    tomography: *mut ThuribleTomography,
    frame: usize,
    warm: u32,
) -> ThuribleResult {
    // SAFETY: the caller's promise.
    unsafe {
        instance::enter(tomography, |body| {
            let all = (0..body.cameras).all(|camera| body.measured >> camera & 1 == 1);
            if !all || (warm != 0 && !(body.begun && body.volume)) {
                return Err(ThuribleResult::NoFrame.into());
            }
            body.begun = false;
            each!(&mut body.reconstruction, one => one.begin(frame as u64, warm != 0))?;
            (body.begun, body.measured) = (true, 0);
            Ok(())
        })
    }
}
