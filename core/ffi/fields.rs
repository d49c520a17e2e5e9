//! Fields of the result by a code: densities, targets and regions, velocities, forces, and what emitters added to density and force.

use crate::each;
use crate::instance::{self, Body, Thurible};
use crate::outputs::{Part, ThuribleView, all, bytes_of};
use crate::pointer::{array, required};
use crate::result::ThuribleResult;
use core::ffi::c_void;
use thurible_core::output::{DENSITY, FORCE, VELOCITY};
use thurible_core::{Output, Real, Serial, Solver, Space};

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
    /// The region of keyframe 0 .., in place of a step, where keyframes have regions.
    Region = 4,
    /// What emitters added to the density after step 0 .. N-1, where there are emitters. It lies nowhere, so that it cannot be viewed.
    Emission = 5,
    /// A component of what emitters with a velocity added beside the force at step 0 .. N-2, where there are any. It lies nowhere either.
    EmitterForce = 6,
}

/// What a code stands for.
#[derive(Clone, Copy)]
enum What {
    /// An output of the method.
    Output(Output),
    /// The targets of keyframes.
    Targets,
    /// Their regions.
    Regions,
    /// What emitters added.
    Emission,
    /// What emitters with a velocity added beside the force.
    EmitterForce,
}

/// What a code stands for, if the instance has it.
fn what(body: &Body, field: u32) -> Result<What, ThuribleResult> {
    let codes = [
        (ThuribleField::Density, What::Output(DENSITY)),
        (ThuribleField::Keyframe, What::Targets),
        (ThuribleField::Velocity, What::Output(VELOCITY)),
        (ThuribleField::Force, What::Output(FORCE)),
        (ThuribleField::Region, What::Regions),
        (ThuribleField::Emission, What::Emission),
        (ThuribleField::EmitterForce, What::EmitterForce),
    ];
    let found = codes.into_iter().find(|&(code, _)| code as u32 == field);
    found
        .map(|(_, what)| what)
        .filter(|what| match what {
            What::Output(output) => all(body).contains(output),
            What::Targets => true,
            What::Regions => body.sizes.regions > 0,
            What::Emission => body.sizes.emitters > 0,
            What::EmitterForce => each!(&body.solver, solver => solver.has_jets()),
        })
        .ok_or(ThuribleResult::Index)
}

/// One component of a field at one step, which exists and is known by now.
#[derive(Clone, Copy)]
enum Place {
    /// The target of a keyframe.
    Target(usize),
    /// The region of a keyframe.
    Region(usize),
    /// A component of an output.
    Part(Part),
    /// What was added after a step.
    Emission(usize),
    /// What was added beside the force of a step, along an axis.
    EmitterForce(usize, usize),
}

impl Place {
    fn new(body: &Body, field: u32, step: usize, axis: usize) -> Result<Self, ThuribleResult> {
        let sizes = body.sizes;
        match what(body, field)? {
            What::Output(output) => Part::new(body, output, step, axis).map(Self::Part),
            What::Targets if step < sizes.keyframes && axis == 0 => Ok(Self::Target(step)),
            What::Regions if step < sizes.regions && axis == 0 => Ok(Self::Region(step)),
            What::Emission if step < sizes.steps && axis == 0 => Self::Emission(step).of_result(body),
            What::EmitterForce if step + 1 < sizes.steps && axis < sizes.dims => {
                Self::EmitterForce(step, axis).of_result(body)
            }
            _ => Err(ThuribleResult::Index),
        }
    }

    /// A place that there is only in a result.
    fn of_result(self, body: &Body) -> Result<Self, ThuribleResult> {
        if each!(&body.solver, solver => solver.is_finished()) {
            Ok(self)
        } else {
            Err(ThuribleResult::NoResult)
        }
    }

    fn view<T: Real, S: Space>(self, solver: &Solver<'_, T, S>) -> Result<ThuribleView, ThuribleResult> {
        let cells = |stored| ThuribleView::of(solver.cells_in_place(stored));
        match self {
            Self::Target(index) => Ok(cells(solver.keyframe(index))),
            Self::Region(index) => Ok(cells(solver.keyframe_region(index))),
            Self::Part(part) => Ok(part.view(solver)),
            Self::Emission(_) | Self::EmitterForce(..) => Err(ThuribleResult::Index),
        }
    }

    /// # Safety
    /// `out` is null or points to `bytes` bytes to write.
    unsafe fn copy<T: Real, S: Space>(
        self,
        solver: &mut Solver<'_, T, S>,
        out: *mut c_void,
        bytes: usize,
    ) -> Result<(), ThuribleResult> {
        let given = match self {
            Self::Target(index) => solver.keyframe(index),
            Self::Region(index) => solver.keyframe_region(index),
            // SAFETY: the caller's promise.
            Self::Part(part) => return unsafe { part.copy(solver, out, bytes) },
            Self::Emission(step) => {
                // SAFETY: the caller's promise.
                let out = unsafe { array::<T>(out, bytes, solver.elements(&DENSITY, 0)) }?;
                solver.emission(&Serial, step, out);
                return Ok(());
            }
            Self::EmitterForce(step, axis) => {
                // SAFETY: the caller's promise.
                let out = unsafe { array::<T>(out, bytes, solver.faces(axis)) }?;
                solver.jet(step, axis, out);
                return Ok(());
            }
        };
        // SAFETY: the caller's promise.
        let out = unsafe { array::<T>(out, bytes, solver.cells()) }?;
        solver.read_cells(given, out);
        Ok(())
    }
}

/// Where a `ThuribleField` of the result lies, without copying: after `thurible_finish` or `thurible_solve`, and until the next call
/// that changes the instance; what was given, step 0 of densities and velocities, the keyframes and their regions, at any time. `axis` is 0 for
/// all but velocities, forces and those of emitters. A field that the method does not give is refused; `thurible_output` says which it gives.
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
            view.write(each!(&body.solver, solver => place.view(solver))?);
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
            let output = match what(body, field)? {
                What::Output(output) => output,
                // One element for each cell, as a density.
                What::Targets | What::Regions | What::Emission => DENSITY,
                What::EmitterForce => VELOCITY,
            };
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
            Ok(each!(&mut body.solver, solver => place.copy(solver, out, bytes))?)
        })
    }
}
