//! A pair of frames: its flow, and what is carried by it.

use super::body::{Body, ThuriblePair, ThuribleTracker};
use super::calls::{faces_of, threads};
use crate::each;
use crate::host::{self, Threads, ThuribleExecutor, ThuribleObserver};
use crate::instance;
use crate::pointer::{array, put, writable};
use crate::result::{ThuribleResult, ThuribleStatus};
use core::ffi::c_void;
use thurible_core::track::{Faces, Part};
use thurible_core::transport::Stop;
use thurible_core::{Observer, Real, Space, Tracker};

/// Where a flow is written, component by component, in the layout of files and in the capture's units: x fastest, one more along a component's own
/// axis than there are cells where that ends in walls.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct ThuribleFaces {
    /// The components along x, y and z; null for one that is not wanted, as z in 2D.
    pub values: [*mut c_void; 3],
    /// Bytes of each, as `thurible_track_faces` says.
    pub bytes: [usize; 3],
}

/// Finds the flow that carries the frame before the last to the last. `velocity`, `predicted` (the flow before the frames were looked at) and
/// `correction` (what was added to that) say where they are to be written, `force` (what leads from the flow before to this one, in velocities a
/// time, where `forces` of the configuration is 1: of every pair but the first, and one before which frames were passed over; elsewhere nothing is
/// written), `pair` what is said of it; each of them may be null, as `executor` and `observer`. How it ends is in `pair`; this returns only
/// refusals, before anything is written.
///
/// # Safety
/// `tracker` as in `thurible_track_close`; `executor` and `observer` are null or keep to their contracts; the others are null or may be read and
/// written, and their pointers are null or point to as many bytes to write as they say, nowhere into another of them.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn thurible_track_step(
    tracker: *mut ThuribleTracker,
    executor: *const ThuribleExecutor,
    observer: *const ThuribleObserver,
    velocity: *const ThuribleFaces,
    predicted: *const ThuribleFaces,
    correction: *const ThuribleFaces,
    force: *const ThuribleFaces,
    pair: *mut ThuriblePair,
) -> ThuribleResult {
    // SAFETY: the caller's promises.
    unsafe {
        instance::enter(tracker, |body| {
            writable(pair)?;
            let exec = threads(body, executor)?;
            let mut observer = host::observer(observer).ok_or(ThuribleResult::Misaligned)?;
            if !force.is_null() && !body.forces {
                return Err(ThuribleResult::NoResult.into());
            }
            let out = Out([
                asked(body, predicted)?,
                asked(body, correction)?,
                asked(body, velocity)?,
                asked(body, force)?,
            ]);
            if !each!(&body.tracker, one => one.is_ready()) {
                return Err(ThuribleResult::NoFrame.into());
            }
            let found = each!(&mut body.tracker, one => step(one, &exec, &mut observer, &out));
            body.status = found.status_of_more();
            put(pair, found);
            Ok(())
        })
    }
}

impl ThuriblePair {
    /// Whether there may be more pairs.
    fn status_of_more(&self) -> ThuribleStatus {
        if self.status == ThuribleStatus::Converged {
            ThuribleStatus::Goes
        } else {
            self.status
        }
    }
}

/// Where what a pair hands out is to be written, by `Part`.
struct Out([Option<ThuribleFaces>; 4]);

/// What a host asks for, with every length checked.
///
/// # Safety
/// `faces` is null or points to a structure.
unsafe fn asked(body: &Body, faces: *const ThuribleFaces) -> Result<Option<ThuribleFaces>, ThuribleResult> {
    if faces.is_null() {
        return Ok(None);
    }
    if !faces.is_aligned() {
        return Err(ThuribleResult::Misaligned);
    }
    // SAFETY: not null, aligned, and the caller promises the rest.
    let faces = unsafe { faces.read() };
    for (axis, (values, &bytes)) in faces.values.iter().zip(&faces.bytes).enumerate() {
        if values.is_null() {
            continue;
        }
        if !values.addr().is_multiple_of(body.number) {
            return Err(ThuribleResult::Misaligned);
        }
        if faces_of(body, axis)?.checked_mul(body.number) != Some(bytes) {
            return Err(ThuribleResult::Length);
        }
    }
    Ok(Some(faces))
}

#[inline(never)]
fn step<T: Real, S: Space>(
    tracker: &mut Tracker<'static, T, S>,
    exec: &Threads,
    observer: &mut dyn Observer,
    out: &Out,
) -> ThuriblePair {
    let frame = tracker.pairs();
    let mut sink = |part: Part, faces: Faces<'_, T>| out.write(part, faces);
    match tracker.step(exec, observer, &mut sink) {
        Ok(pair) => ThuriblePair::of(frame, &pair),
        Err(stop) => ThuriblePair {
            status: match stop {
                Stop::Cancelled => ThuribleStatus::Cancelled,
                Stop::TooFast => ThuribleStatus::NotFinite,
            },
            frame,
            ..ThuriblePair::default()
        },
    }
}

impl Out {
    fn write<T: Real>(&self, part: Part, faces: Faces<'_, T>) {
        let Self(parts) = self;
        let Some(Some(wanted)) = parts.get(part as usize) else {
            return;
        };
        for (axis, (&values, &bytes)) in wanted.values.iter().zip(&wanted.bytes).enumerate() {
            if values.is_null() {
                continue;
            }
            // SAFETY: checked by `asked`, and the caller of `thurible_track_step` promises the bytes.
            if let Ok(out) = unsafe { array::<T>(values, bytes, faces.len(axis)) } {
                faces.read(axis, out);
            }
        }
    }
}

/// Copies the first frame, carried by the flow to the last pair's second frame, into `out` of exactly `bytes` bytes, as frames are given. Refused
/// where `readvect` of the configuration is 0, and before the first frame.
///
/// # Safety
/// `tracker` as in `thurible_track_close`; `out` is null or points to `bytes` bytes to write.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn thurible_track_density(
    tracker: *const ThuribleTracker,
    out: *mut c_void,
    bytes: usize,
) -> ThuribleResult {
    // SAFETY: the caller's promises.
    unsafe {
        instance::enter(tracker, |body| {
            if !body.readvect || body.frames == 0 {
                return Err(ThuribleResult::NoResult.into());
            }
            each!(&body.tracker, one => {
                let carried = one.carried();
                array(out, bytes, carried.len())?.copy_from_slice(carried);
            });
            Ok(())
        })
    }
}
