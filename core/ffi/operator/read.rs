//! What is read of an operator: its sizes, and its gradient.

use super::body::{Body, ThuribleOperator, simulator};
use crate::instance;
use crate::pointer::{array, put, required, writable};
use crate::result::ThuribleResult;
use core::ffi::c_void;
use thurible_core::Real;
use thurible_core::operator::{EmitterGradient, Simulator, View};

/// What a scalar function gets by the numbers of an emitter.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default)]
pub struct ThuribleEmitterGradient {
    /// By its rate or target.
    pub supply: f64,
    /// By the velocity of its smoke along x, y and z; 0 where it has none.
    pub velocity: [f64; 3],
}

/// Bytes of the density of a step, part 0, or of component `part` - 1 of a velocity or force: faces as `thurible_copy` has them, of Stable Fluids centres
/// of cells.
///
/// # Safety
/// `operator_` as in `thurible_operator_close`; `bytes` is null or may be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn thurible_operator_bytes(
    operator_: *const ThuribleOperator,
    part: usize,
    bytes: *mut usize,
) -> ThuribleResult {
    // SAFETY: the caller's promises.
    unsafe {
        instance::enter(operator_, |body| {
            required(bytes)?;
            bytes.write(len(body, part)? * body.number);
            Ok(())
        })
    }
}

fn len(body: &Body, part: usize) -> Result<usize, ThuribleResult> {
    let found = body.lens.get(part).copied();
    found.filter(|&len| len > 0).ok_or(ThuribleResult::Index)
}

/// A body whose gradient is there.
fn differentiated(body: &Body) -> Result<&Body, ThuribleResult> {
    if body.differentiated {
        Ok(body)
    } else {
        Err(ThuribleResult::NoResult)
    }
}

/// Copies the gradient by the density at the start, part 0, or by component `part` - 1 of the velocity there, as it was given, into `out` of exactly
/// `bytes` bytes.
///
/// # Safety
/// `operator_` as in `thurible_operator_close`; `out` is null or points to `bytes` bytes to write.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn thurible_operator_gradient(
    operator_: *const ThuribleOperator,
    part: usize,
    out: *mut c_void,
    bytes: usize,
) -> ThuribleResult {
    // SAFETY: the caller's promises.
    unsafe {
        instance::enter(operator_, |body| {
            let len = len(body, part)?;
            let body = differentiated(body)?;
            simulator!(&body.simulator, one => read(&Simulator::gradient(one), part, array(out, bytes, len)?));
            Ok(())
        })
    }
}

#[inline(never)]
fn read<T: Real>(view: &View<'_, T>, part: usize, out: &mut [T]) {
    match part.checked_sub(1) {
        None => view.read_density(out),
        Some(axis) => view.read_vector(axis, out),
    }
}

/// Writes the gradient by the acceleration of buoyancy along x, y and z.
///
/// # Safety
/// `operator_` as in `thurible_operator_close`; `buoyancy` is null or points to three numbers to write.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn thurible_operator_buoyancy(
    operator_: *const ThuribleOperator,
    buoyancy: *mut f64,
) -> ThuribleResult {
    // SAFETY: the caller's promises.
    unsafe {
        instance::enter(operator_, |body| {
            required(buoyancy)?;
            let body = differentiated(body)?;
            let found = simulator!(&body.simulator, one => Simulator::buoyancy_gradient(one));
            buoyancy.cast::<[f64; 3]>().write(found);
            Ok(())
        })
    }
}

/// Writes the gradient by the numbers of emitter `index` to `numbers`, and copies that by its shape into `shape` of exactly `bytes` bytes; either may be null.
///
/// # Safety
/// `operator_` as in `thurible_operator_close`; `numbers` is null or may be written; `shape` is null or points to `bytes` bytes to write.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn thurible_operator_emitter(
    operator_: *const ThuribleOperator,
    index: usize,
    numbers: *mut ThuribleEmitterGradient,
    shape: *mut c_void,
    bytes: usize,
) -> ThuribleResult {
    // SAFETY: the caller's promises.
    unsafe {
        instance::enter(operator_, |body| {
            writable(numbers)?;
            if index >= body.emitters {
                return Err(ThuribleResult::Index.into());
            }
            let body = differentiated(body)?;
            let len = len(body, 0)?;
            let EmitterGradient { supply, velocity } = simulator!(&body.simulator, one => {
                if let (false, Some(view)) = (shape.is_null(), Simulator::shape_gradient(one, index)) {
                    read(&view, 0, array(shape, bytes, len)?);
                }
                Simulator::emitter_gradient(one, index)
            });
            put(numbers, ThuribleEmitterGradient { supply, velocity });
            Ok(())
        })
    }
}
