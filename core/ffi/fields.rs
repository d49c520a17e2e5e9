//! What was found: views without copying, and copies in the layout of files.

use crate::each;
use crate::instance::{self, Body, Thurible};
use crate::pointer::required;
use crate::result::ThuribleResult;
use core::ffi::c_void;
use thurible_core::output::{DENSITY, FORCE, VELOCITY};
use thurible_core::solver::Strided;
use thurible_core::{Real, Solver, Space};

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

/// A field as it lies in the instance. Element (x, y, z) is at `data` plus x `strides[0]` + y `strides[1]` + z `strides[2]` elements of the
/// instance's precision; times `unit` it is in the scene's units.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct ThuribleView {
    /// Element (0, 0, 0).
    pub data: *const c_void,
    /// Elements along x, y and z. A component of a velocity or force has the low face of every cell along its axis; on a wall axis the
    /// first is on the wall, where nothing flows, and the last wall is left out.
    pub extent: [usize; 3],
    /// Elements from one to the next along x, y and z.
    pub strides: [usize; 3],
    /// The scene's unit of these elements.
    pub unit: f64,
    /// Bytes of an element: 4 for `float`, 8 for `double`.
    pub bytes_per_number: usize,
}

/// One component of a field at one step, which exists.
#[derive(Clone, Copy)]
struct Place {
    field: ThuribleField,
    step: usize,
    axis: usize,
}

impl Place {
    /// Checks that there is such a field, and that it is known by now.
    fn new(body: &Body, field: u32, step: usize, axis: usize) -> Result<Self, ThuribleResult> {
        let sizes = body.sizes;
        let all = [
            ThuribleField::Density,
            ThuribleField::Keyframe,
            ThuribleField::Velocity,
            ThuribleField::Force,
        ];
        let field = all
            .into_iter()
            .find(|&known| known as u32 == field)
            .ok_or(ThuribleResult::Index)?;
        let steps = match field {
            ThuribleField::Density => sizes.steps + 1,
            ThuribleField::Keyframe => sizes.keyframes,
            ThuribleField::Velocity => sizes.steps,
            ThuribleField::Force => sizes.steps - 1,
        };
        let axes = if matches!(field, ThuribleField::Velocity | ThuribleField::Force) {
            sizes.dims
        } else {
            1
        };
        let given = field == ThuribleField::Keyframe || field != ThuribleField::Force && step == 0;
        if step >= steps || axis >= axes {
            return Err(ThuribleResult::Index);
        }
        if !given && !each!(&body.solver, solver => solver.is_finished()) {
            return Err(ThuribleResult::NoResult);
        }
        Ok(Self { field, step, axis })
    }

    /// Elements of the field in a file.
    fn count(self, body: &Body) -> usize {
        match self.field {
            ThuribleField::Density | ThuribleField::Keyframe => body.sizes.cells,
            _ => each!(&body.solver, solver => solver.faces(self.axis)),
        }
    }

    fn view<T: Real, S: Space>(self, solver: &Solver<'_, T, S>) -> ThuribleView {
        let Strided {
            numbers,
            extent,
            strides,
            unit,
        } = match self.field {
            ThuribleField::Density => solver.in_place(&DENSITY, self.step, 0),
            ThuribleField::Keyframe => Strided {
                numbers: solver.keyframe(self.step),
                ..solver.in_place(&DENSITY, 0, 0)
            },
            ThuribleField::Velocity => solver.in_place(&VELOCITY, self.step, self.axis),
            ThuribleField::Force => solver.in_place(&FORCE, self.step, self.axis),
        };
        ThuribleView {
            data: numbers.as_ptr().cast(),
            extent,
            strides,
            unit,
            bytes_per_number: T::BYTES,
        }
    }

    fn copy<T: Real, S: Space>(self, solver: &Solver<'_, T, S>, out: &mut [T]) {
        let cells = |out: &mut [T], density: &[T]| {
            out.iter_mut()
                .zip(density)
                .for_each(|(out, &density)| *out = density)
        };
        match self.field {
            ThuribleField::Density => cells(out, solver.density(self.step)),
            ThuribleField::Keyframe => cells(out, solver.keyframe(self.step)),
            ThuribleField::Velocity => solver.velocity(self.step, self.axis, out),
            ThuribleField::Force => solver.force(self.step, self.axis, out),
        }
    }
}

/// Where a `ThuribleField` of the result lies, without copying: after `thurible_finish` or `thurible_solve`, and until the next call
/// that changes the instance; what was given, step 0 of densities and velocities and the keyframes, at any time. `axis` is 0 for
/// densities and keyframes.
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
            let axes = if field == ThuribleField::Velocity as u32 || field == ThuribleField::Force as u32 {
                body.sizes.dims
            } else {
                1
            };
            if field > ThuribleField::Force as u32 || axis >= axes {
                return Err(ThuribleResult::Index.into());
            }
            let kind = if axes == 1 {
                ThuribleField::Density
            } else {
                ThuribleField::Velocity
            };
            bytes.write(
                Place {
                    field: kind,
                    step: 0,
                    axis,
                }
                .count(body)
                    * body.sizes.precision,
            );
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
            let count = place.count(body);
            if out.is_null() {
                return Err(ThuribleResult::Null.into());
            }
            if !out.addr().is_multiple_of(body.sizes.precision) {
                return Err(ThuribleResult::Misaligned.into());
            }
            if bytes != count * body.sizes.precision {
                return Err(ThuribleResult::Length.into());
            }
            out.cast::<u8>().write_bytes(0, bytes);
            each!(&body.solver, solver => place.copy(solver, core::slice::from_raw_parts_mut(out.cast(), count)));
            Ok(())
        })
    }
}
