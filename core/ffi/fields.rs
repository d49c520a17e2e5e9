//! Fields of the result by a code: densities, targets, velocities and forces.

use crate::each;
use crate::instance::{self, Body, Thurible};
use crate::outputs::{Part, ThuribleView, all, bytes_of};
use crate::pointer::{array, required};
use crate::result::ThuribleResult;
use core::ffi::c_void;
use thurible_core::output::{DENSITY, FORCE, VELOCITY};
use thurible_core::solver::Strided;
use thurible_core::{Output, Real, Solver, Space};

/// A field of the result.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ThuribleField {
    /// Density at step 0 .. N, one element for each cell.
    Density = 0,
    /// The target of keyframe 0 .., in place of a step, as it was scaled.
    Keyframe = 1,
    /// A component of the velocity at step 0 .. N-1.
    Velocity = 2,
    /// A component of the force at step 0 .. N-2, which turns the velocity of that step into the next one.
    Force = 3,
}

/// The output that a code stands for, if the method gives it; `None` stands for the targets of keyframes.
fn output_of(body: &Body, field: u32) -> Result<Option<Output>, ThuribleResult> {
    let codes = [
        (ThuribleField::Density, Some(DENSITY)),
        (ThuribleField::Keyframe, None),
        (ThuribleField::Velocity, Some(VELOCITY)),
        (ThuribleField::Force, Some(FORCE)),
    ];
    let found = codes.into_iter().find(|&(code, _)| code as u32 == field);
    found
        .map(|(_, output)| output)
        .filter(|output| output.is_none_or(|output| all(body).contains(&output)))
        .ok_or(ThuribleResult::Index)
}

/// One component of a field at one step, which exists and is known by now.
#[derive(Clone, Copy)]
enum Place {
    /// The target of a keyframe.
    Target(usize),
    /// A component of an output.
    Part(Part),
}

impl Place {
    fn new(body: &Body, field: u32, step: usize, axis: usize) -> Result<Self, ThuribleResult> {
        match output_of(body, field)? {
            Some(output) => Part::new(body, output, step, axis).map(Self::Part),
            None if step < body.sizes.keyframes && axis == 0 => Ok(Self::Target(step)),
            None => Err(ThuribleResult::Index),
        }
    }

    fn view<T: Real, S: Space>(self, solver: &Solver<'_, T, S>) -> ThuribleView {
        match self {
            Self::Target(index) => ThuribleView::of(Strided {
                numbers: solver.keyframe(index),
                ..solver.in_place(&DENSITY, 0, 0)
            }),
            Self::Part(part) => part.view(solver),
        }
    }

    /// # Safety
    /// `out` is null or points to `bytes` bytes to write.
    unsafe fn copy<T: Real, S: Space>(
        self,
        solver: &Solver<'_, T, S>,
        out: *mut c_void,
        bytes: usize,
    ) -> Result<(), ThuribleResult> {
        match self {
            Self::Target(index) => {
                let target = solver.keyframe(index);
                // SAFETY: the caller's promise.
                let out = unsafe { array::<T>(out, bytes, target.len()) }?;
                out.iter_mut()
                    .zip(target)
                    .for_each(|(out, &density)| *out = density);
                Ok(())
            }
            // SAFETY: the caller's promise.
            Self::Part(part) => unsafe { part.copy(solver, out, bytes) },
        }
    }
}

/// Where a `ThuribleField` of the result lies, without copying: after `thurible_finish` or `thurible_solve`, and until the next call
/// that changes the instance; what was given, step 0 of densities and velocities and the keyframes, at any time. `axis` is 0 for
/// densities and keyframes. A field that the method does not give is refused; `thurible_output` says which it gives.
///
/// # Safety
/// `instance` as in `thurible_close`; `view` is null or may be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn thurible_view(
    instance: *const Thurible,
    field: u32,
    step: usize,
    axis: usize,
    view: *mut ThuribleView,
) -> ThuribleResult {
    // SAFETY: the caller's promises.
    unsafe {
        instance::enter(instance, |body| {
            required(view)?;
            let place = Place::new(body, field, step, axis)?;
            view.write(each!(&body.solver, solver => place.view(solver)));
            Ok(())
        })
    }
}

/// Bytes that `thurible_copy` writes for a `ThuribleField`.
///
/// # Safety
/// `instance` as in `thurible_close`; `bytes` is null or may be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn thurible_copy_bytes(
    instance: *const Thurible,
    field: u32,
    axis: usize,
    bytes: *mut usize,
) -> ThuribleResult {
    // SAFETY: the caller's promises.
    unsafe {
        instance::enter(instance, |body| {
            required(bytes)?;
            // The target of a keyframe is a density.
            let output = output_of(body, field)?.unwrap_or(DENSITY);
            bytes.write(bytes_of(body, &output, axis)?);
            Ok(())
        })
    }
}

/// Copies a `ThuribleField` of the result into `out` of exactly `bytes` bytes, as files have it: z, y, x with x fastest; a component of a
/// velocity or force one more along its own axis than there are cells where that ends in walls; in the scene's units and the
/// instance's precision. When it can be had, see `thurible_view`.
///
/// # Safety
/// `instance` as in `thurible_close`; `out` is null or points to `bytes` bytes to write.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn thurible_copy(
    instance: *const Thurible,
    field: u32,
    step: usize,
    axis: usize,
    out: *mut c_void,
    bytes: usize,
) -> ThuribleResult {
    // SAFETY: the caller's promises.
    unsafe {
        instance::enter(instance, |body| {
            let place = Place::new(body, field, step, axis)?;
            Ok(each!(&body.solver, solver => place.copy(solver, out, bytes))?)
        })
    }
}
