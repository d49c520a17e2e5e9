//! Densities and velocities of the caller.

use crate::each;
use crate::instance::{self, Thurible};
use crate::pointer::{elements, flags, put, writable};
use crate::result::ThuribleResult;
use core::ffi::c_void;

/// Sets the density of step 0: one element of the instance's precision for each cell, x fastest; `bytes` of all. It may be left out where
/// there are emitters.
///
/// # Safety
/// `instance` as in `thurible_close`; `density` is null or points to `bytes` bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn thurible_set_source(
    instance: *mut Thurible,
    density: *const c_void,
    bytes: usize,
) -> ThuribleResult {
    // SAFETY: the caller's promises.
    unsafe {
        instance::enter(instance, |body| {
            Ok(each!(&mut body.solver, solver => solver.set_source(elements(density, bytes)?))?)
        })
    }
}

/// Sets which cells are solid, before anything else is set: one byte for each cell, x fastest, 1 where it is solid and 0 where it is not. Refused
/// where `solids` of the configuration is 0, and as too late after a source or a keyframe. Densities are 0 in solid cells, whatever is given.
///
/// # Safety
/// `instance` as in `thurible_close`; `solid` is null or points to `bytes` bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn thurible_set_solids(
    instance: *mut Thurible,
    solid: *const u8,
    bytes: usize,
) -> ThuribleResult {
    // SAFETY: the caller's promises.
    unsafe {
        instance::enter(instance, |body| {
            let solid = flags(solid, bytes)?;
            Ok(each!(&mut body.solver, solver => solver.set_solids(solid))?)
        })
    }
}

/// Sets the shape of emitter `index`, as `thurible_set_source`: where it adds smoke, and how much of its rate or target there.
///
/// # Safety
/// As `thurible_set_source`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn thurible_set_emitter(
    instance: *mut Thurible,
    index: usize,
    shape: *const c_void,
    bytes: usize,
) -> ThuribleResult {
    // SAFETY: the caller's promises.
    unsafe {
        instance::enter(instance, |body| {
            Ok(each!(&mut body.solver, solver => solver.set_emitter(index, elements(shape, bytes)?))?)
        })
    }
}

/// Sets the region of keyframe `index`, as `thurible_set_source`: what its error is multiplied by in each cell, from 0 to 1. Refused where
/// `keyframe_regions` of the configuration is 0; 1 everywhere where it is not set.
///
/// # Safety
/// As `thurible_set_source`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn thurible_set_region(
    instance: *mut Thurible,
    index: usize,
    region: *const c_void,
    bytes: usize,
) -> ThuribleResult {
    // SAFETY: the caller's promises.
    unsafe {
        instance::enter(instance, |body| {
            Ok(each!(&mut body.solver, solver => solver.set_region(index, elements(region, bytes)?))?)
        })
    }
}

/// Sets where force may act, as `thurible_set_source`: in each cell 1 everywhere and 0 as good as nowhere, in between at 1 / mask^2 times the
/// price. Refused where `mask` of the configuration is 0; 1 everywhere where it is not set.
///
/// # Safety
/// As `thurible_set_source`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn thurible_set_mask(
    instance: *mut Thurible,
    mask: *const c_void,
    bytes: usize,
) -> ThuribleResult {
    // SAFETY: the caller's promises.
    unsafe {
        instance::enter(instance, |body| {
            Ok(each!(&mut body.solver, solver => solver.set_mask(elements(mask, bytes)?))?)
        })
    }
}

/// Sets the target of keyframe `index`, as `thurible_set_source`; the source, where there is one, and the shapes of all emitters come
/// first. Where keyframes are scaled to the mass of the smoke at their steps, `factor` is by how much; it may be null.
///
/// # Safety
/// As `thurible_set_source`; `factor` is null or may be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn thurible_set_keyframe(
    instance: *mut Thurible,
    index: usize,
    density: *const c_void,
    bytes: usize,
    factor: *mut f64,
) -> ThuribleResult {
    // SAFETY: the caller's promises.
    unsafe {
        instance::enter(instance, |body| {
            writable(factor)?;
            put(
                factor,
                each!(&mut body.solver, solver => solver.set_keyframe(index, elements(density, bytes)?))?,
            );
            Ok(())
        })
    }
}

/// Sets component `axis` of the velocity at step 0, in the layout of `thurible_copy` and the scene's units; 0 where it is not set.
///
/// # Safety
/// As `thurible_set_source`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn thurible_set_initial_velocity(
    instance: *mut Thurible,
    axis: usize,
    faces: *const c_void,
    bytes: usize,
) -> ThuribleResult {
    // SAFETY: the caller's promises.
    unsafe {
        instance::enter(instance, |body| {
            Ok(each!(&mut body.solver, solver => solver.set_initial_velocity(axis, elements(faces, bytes)?))?)
        })
    }
}

/// Sets component `axis` of the flow of step `step` that the method of guidance follows, from 1 to steps - 1, as `thurible_set_initial_velocity`; a
/// step that is not set is at rest. A solve, whole or stopped, goes over this flow and puts what it finds in its place: before another one it is given
/// anew, or the solve answers `THURIBLE_RESULT_NO_REFERENCE`.
///
/// # Safety
/// As `thurible_set_source`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn thurible_set_reference(
    instance: *mut Thurible,
    axis: usize,
    step: usize,
    faces: *const c_void,
    bytes: usize,
) -> ThuribleResult {
    // SAFETY: the caller's promises.
    unsafe {
        instance::enter(instance, |body| {
            Ok(each!(&mut body.solver, solver => solver.set_reference(axis, step, elements(faces, bytes)?))?)
        })
    }
}
