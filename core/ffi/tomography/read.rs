//! The way through a frame, and what is read of it.

use super::body::{Body, ThuribleTomography};
use crate::each;
use crate::instance;
use crate::pointer::{array, put, writable};
use crate::result::{ThuribleResult, ThuribleStatus};
use core::ffi::c_void;

/// How far a frame is.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default)]
pub struct ThuribleWalked {
    /// `THURIBLE_STATUS_GOES`; `THURIBLE_STATUS_CONVERGED` where it got hardly better, `THURIBLE_STATUS_MAX_ITERATIONS` where its budget is spent.
    pub status: ThuribleStatus,
    /// The frame.
    pub frame: u64,
    /// Mutations so far; of SART its sweeps.
    pub mutations: u64,
    /// How many of them were recorded.
    pub recorded: u64,
    /// Mutations of the frame at most.
    pub budget: u64,
    /// Mass of a sample.
    pub eps: f64,
    /// 1/2 |q - F p|^2.
    pub data: f64,
    /// gamma times the prior.
    pub prior: f64,
    /// |q - F p| / |q|.
    pub residual: f64,
}

/// A body in which a frame was begun.
fn begun(body: &Body) -> Result<&Body, ThuribleResult> {
    if body.begun {
        Ok(body)
    } else {
        Err(ThuribleResult::NoFrame)
    }
}

/// Goes on by at most `most` mutations, or one sweep of SART; refused where pictures of the next frame were given. `walked` says how far that is; it
/// may be null, which saves a pass over all pixels and cells.
///
/// # Safety
/// `tomography` as in `thurible_tomography_close`; `walked` is null or may be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn thurible_tomography_advance(
    tomography: *mut ThuribleTomography,
    most: usize,
    walked: *mut ThuribleWalked,
) -> ThuribleResult {
    // SAFETY: the caller's promises.
    unsafe {
        instance::enter(tomography, |body| {
            writable(walked)?;
            begun(body)?;
            // The frame still reads what was measured.
            if body.measured != 0 {
                return Err(ThuribleResult::NoFrame.into());
            }
            each!(&mut body.reconstruction, one => {
                let over = one.advance(most as u64);
                if !walked.is_null() {
                    let (energy, so_far) = (one.energy(), one.walked());
                    put(walked, ThuribleWalked {
                        status: match (over, one.settled()) {
                            (false, _) => ThuribleStatus::Goes,
                            (_, true) => ThuribleStatus::Converged,
                            _ => ThuribleStatus::MaxIterations,
                        },
                        frame: one.frame(),
                        mutations: so_far.mutations,
                        recorded: so_far.recorded,
                        budget: one.budget(),
                        eps: one.eps(),
                        data: energy.data,
                        prior: energy.prior,
                        residual: one.residual_relative(),
                    });
                }
            });
            Ok(())
        })
    }
}

/// Copies the density into `out` of exactly `bytes` bytes: a number of the precision for each cell, x fastest. Refused before a frame was begun, and
/// where it is not kept.
///
/// # Safety
/// `tomography` as in `thurible_tomography_close`; `out` is null or points to `bytes` bytes to write.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn thurible_tomography_density(
    tomography: *const ThuribleTomography,
    out: *mut c_void,
    bytes: usize,
) -> ThuribleResult {
    // SAFETY: the caller's promises.
    unsafe {
        instance::enter(tomography, |body| {
            if !begun(body)?.volume {
                return Err(ThuribleResult::NoResult.into());
            }
            each!(&body.reconstruction, one => {
                let density = one.density();
                array(out, bytes, density.len())?.copy_from_slice(density);
            });
            Ok(())
        })
    }
}

/// Copies what camera `camera` would see of the density into `out` of exactly `bytes` bytes, as pictures are given.
///
/// # Safety
/// As `thurible_tomography_density`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn thurible_tomography_picture(
    tomography: *const ThuribleTomography,
    camera: usize,
    out: *mut c_void,
    bytes: usize,
) -> ThuribleResult {
    // SAFETY: the caller's promises.
    unsafe {
        instance::enter(tomography, |body| {
            if camera >= begun(body)?.cameras {
                return Err(ThuribleResult::Index.into());
            }
            if body.measured != 0 {
                // Pictures of the next frame were given already.
                return Err(ThuribleResult::NoResult.into());
            }
            each!(&body.reconstruction, one => {
                let (measured, residual) = (one.measured(camera), one.residual(camera));
                let pixels = array(out, bytes, measured.len())?.iter_mut();
                let seen = measured.iter().zip(residual).map(|(&q, &r)| q - r);
                pixels.zip(seen).for_each(|(pixel, seen)| *pixel = seen);
            });
            Ok(())
        })
    }
}

/// Copies what novel view `view` shows, as `thurible_tomography_picture`.
///
/// # Safety
/// As `thurible_tomography_density`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn thurible_tomography_novel(
    tomography: *const ThuribleTomography,
    view: usize,
    out: *mut c_void,
    bytes: usize,
) -> ThuribleResult {
    // SAFETY: the caller's promises.
    unsafe {
        instance::enter(tomography, |body| {
            if view >= begun(body)?.novel {
                return Err(ThuribleResult::Index.into());
            }
            each!(&body.reconstruction, one => {
                let picture = one.novel(view);
                array(out, bytes, picture.len())?.copy_from_slice(picture);
            });
            Ok(())
        })
    }
}
