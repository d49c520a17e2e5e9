//! The calls with a tracker.

use super::body::{Body, ThuribleTracker, make, plan};
use super::config::ThuribleTrackConfig;
use crate::config::{ConfigError, sized};
use crate::each;
use crate::host::{Threads, ThuribleExecutor};
use crate::instance::{self, asked};
use crate::pointer::{elements, required};
use crate::result::{ThuribleResult, ThuribleStatus};
use core::ffi::{c_char, c_void};

/// As `thurible_explain`, of a tracker's configuration.
///
/// # Safety
/// `config` is null or points to a configuration; `buffer` is null or points to `size` bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn thurible_track_explain(
    config: *const ThuribleTrackConfig,
    buffer: *mut c_char,
    size: usize,
) -> usize {
    // SAFETY: the caller's promises.
    unsafe {
        let planned = sized::read(config).and_then(|config| plan(&config));
        asked::explain(planned, buffer, size)
    }
}

/// How many bytes a tracker takes, however many frames there are, and on which multiple of bytes they must begin. Each pointer but `config` may
/// be null.
///
/// # Safety
/// `config` is null or points to a configuration; the others are null or may be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn thurible_track_plan(
    config: *const ThuribleTrackConfig,
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

/// Makes a tracker in `memory`, as `thurible_init` makes an instance.
///
/// # Safety
/// `memory` is null or points to `bytes` bytes that nobody else uses; `config` as in `thurible_track_plan`; `out` is null or may be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn thurible_track_init(
    memory: *mut c_void,
    bytes: usize,
    config: *const ThuribleTrackConfig,
    out: *mut *mut ThuribleTracker,
) -> ThuribleResult {
    // SAFETY: the caller's promises.
    unsafe {
        asked::init(out, || {
            let config = sized::read(config).map_err(ConfigError::result)?;
            make(memory.cast(), bytes, &config)
        })
    }
}

/// Ends a tracker: its memory is the caller's again.
///
/// # Safety
/// `tracker` is null or points to memory of a tracker's size.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn thurible_track_close(tracker: *mut ThuribleTracker) -> ThuribleResult {
    // SAFETY: the caller's promise.
    unsafe { instance::close(tracker) }
}

/// As `thurible_message`, of the last call with this tracker.
///
/// # Safety
/// `tracker` as in `thurible_track_close`; `buffer` is null or points to `size` bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn thurible_track_message(
    tracker: *const ThuribleTracker,
    buffer: *mut c_char,
    size: usize,
) -> usize {
    // SAFETY: the caller's promises.
    unsafe { instance::message(tracker, buffer, size) }
}

/// Sets component `axis` of the flow of the first pair, before any frame, in the layout and units of `ThuribleFaces`; at rest where it is not set.
///
/// # Safety
/// `tracker` as in `thurible_track_close`; `faces` is null or points to `bytes` bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn thurible_track_set_initial_velocity(
    tracker: *mut ThuribleTracker,
    axis: usize,
    faces: *const c_void,
    bytes: usize,
) -> ThuribleResult {
    // SAFETY: the caller's promises.
    unsafe {
        instance::enter(tracker, |body| {
            if body.frames > 0 {
                return Err(ThuribleResult::Late.into());
            }
            Ok(each!(&mut body.tracker, one => one.set_initial_velocity(axis, elements(faces, bytes)?))?)
        })
    }
}

/// Gives the next frame: one density for each cell, x fastest, `bytes` of all. `emission`, of as many, is what was made of it since the frame
/// before, where `emission` of the configuration is 1; else it is null, as with the first frame. `executor` may be null.
///
/// # Safety
/// `tracker` as in `thurible_track_close`; `executor` is null or keeps to its contract; `frame` and `emission` are null or point to `bytes` bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn thurible_track_give(
    tracker: *mut ThuribleTracker,
    executor: *const ThuribleExecutor,
    frame: *const c_void,
    emission: *const c_void,
    bytes: usize,
) -> ThuribleResult {
    // SAFETY: the caller's promises.
    unsafe {
        instance::enter(tracker, |body| {
            let exec = threads(body, executor)?;
            each!(&mut body.tracker, one => {
                let frame = elements(frame, bytes)?;
                if emission.is_null() {
                    one.give(&exec, frame)?;
                } else {
                    one.give_with_emission(&exec, frame, elements(emission, bytes)?)?;
                }
            });
            body.frames = body.frames.saturating_add(1);
            Ok(())
        })
    }
}

/// Threads of the host for a tracker that goes on.
///
/// # Errors
/// [`ThuribleResult`].
///
/// # Safety
/// `executor` is null or keeps to its contract.
pub unsafe fn threads(body: &Body, executor: *const ThuribleExecutor) -> Result<Threads, ThuribleResult> {
    if body.status != ThuribleStatus::Goes {
        return Err(ThuribleResult::Ended);
    }
    // SAFETY: the caller's promise.
    unsafe { Threads::new(executor, body.threads) }.ok_or(ThuribleResult::Executor)
}

/// Bytes of component `axis` of a flow.
///
/// # Safety
/// `tracker` as in `thurible_track_close`; `bytes` is null or may be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn thurible_track_faces(
    tracker: *const ThuribleTracker,
    axis: usize,
    bytes: *mut usize,
) -> ThuribleResult {
    // SAFETY: the caller's promises.
    unsafe {
        instance::enter(tracker, |body| {
            required(bytes)?;
            bytes.write(faces_of(body, axis)? * body.number);
            Ok(())
        })
    }
}

/// Numbers of component `axis` of a flow.
///
/// # Errors
/// [`ThuribleResult::Index`].
pub fn faces_of(body: &Body, axis: usize) -> Result<usize, ThuribleResult> {
    if axis >= body.dims {
        return Err(ThuribleResult::Index);
    }
    Ok(each!(&body.tracker, one => one.faces_len(axis)))
}
