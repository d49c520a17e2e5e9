//! How an instance is made.

use super::body::{AnySolver, Body, Sizes, Thurible};
use super::handle::{ALIGN, Handle, Place, block, mark};
use super::plan::{Planned, plan};
use super::progress::ThuribleProgress;
use crate::config::{ConfigError, ThuribleConfig};
use crate::result::ThuribleResult;
use crate::typed;
use core::cell::UnsafeCell;
use core::mem::MaybeUninit;
use core::sync::atomic::{AtomicBool, AtomicUsize};
use thurible_core::{Params, Problem, Real, Report, Solver, Space};

/// The bytes behind the place of a handle, of `needed` bytes in all.
///
/// # Errors
/// [`ThuribleResult`]: null, misaligned, or too few.
///
/// # Safety
/// `memory` is null or points to `bytes` bytes that nobody else uses while the handle lives.
pub unsafe fn behind<H: Handle>(
    memory: *mut u8,
    bytes: usize,
    needed: usize,
) -> Result<&'static mut [MaybeUninit<u8>], ThuribleResult> {
    if memory.is_null() {
        return Err(ThuribleResult::Null);
    }
    if !memory.addr().is_multiple_of(ALIGN) {
        return Err(ThuribleResult::Misaligned);
    }
    let own = const { block::<H>() };
    if bytes < needed || needed < own {
        return Err(ThuribleResult::TooSmall);
    }
    // SAFETY: `needed` bytes are there and no more than the address space, the place takes `own` of them, and the rest is for what is
    // behind it alone: nothing else of this library points there.
    Ok(unsafe { core::slice::from_raw_parts_mut(memory.add(own).cast(), needed - own) })
}

/// Puts a body where its handle points to.
///
/// # Safety
/// `handle` is aligned and points to the bytes of its place.
pub unsafe fn settle<H: Handle>(handle: *mut H, body: H::Body) {
    let place: *mut Place<H::Body> = handle.cast();
    // SAFETY: the caller's promise.
    unsafe {
        place.write(Place {
            mark: AtomicUsize::new(mark::<H>(handle)),
            busy: AtomicBool::new(false),
            body: UnsafeCell::new(body),
            refusal: UnsafeCell::new(ThuribleResult::Ok.into()),
        });
    }
}

/// Makes an instance in the first bytes of `memory`.
///
/// # Errors
/// [`ThuribleResult`].
///
/// # Safety
/// `memory` is null or points to `bytes` bytes that nobody else uses while the instance lives; the lists of `config` have as
/// many entries as it says.
pub unsafe fn make(
    memory: *mut u8,
    bytes: usize,
    config: &ThuribleConfig,
) -> Result<*mut Thurible, ThuribleResult> {
    // SAFETY: the caller's promise.
    let Planned { bytes: needed, .. } = unsafe { plan(config) }.map_err(ConfigError::result)?;
    // SAFETY: the caller's promise.
    let block = unsafe { behind::<Thurible>(memory, bytes, needed) }?;
    let sizes = Sizes::of(config);
    let instance: *mut Thurible = memory.cast();
    // SAFETY: the caller's promise; `instance` is aligned, and the bytes before the solver's block are its own.
    let made = unsafe {
        config.with(|problem, params| {
            let kind = config.kind().map_err(ConfigError::result)?;
            typed!(kind, _T, _S, Wrap => place(instance, sizes, problem, params, block, Wrap))
        })
    };
    made.map_err(ConfigError::result)??;
    Ok(instance)
}

/// Makes a solver of one type in `block` and the instance where it belongs.
///
/// # Safety
/// `instance` is aligned and points to the bytes of an instance.
#[inline(never)]
unsafe fn place<T: Real, S: Space>(
    instance: *mut Thurible,
    sizes: Sizes,
    problem: &Problem<'_>,
    params: &Params,
    block: &'static mut [MaybeUninit<u8>],
    wrap: fn(Solver<'static, T, S>) -> AnySolver<'static>,
) -> Result<(), ThuribleResult> {
    let solver = wrap(Solver::new(problem, params, block)?);
    let body = Body {
        solver,
        sizes,
        progress: ThuribleProgress::default(),
        report: Report::default(),
    };
    // SAFETY: the caller's promise.
    unsafe { settle(instance, body) };
    Ok(())
}
