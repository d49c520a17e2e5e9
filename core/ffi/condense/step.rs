//! Steps of a body, and what is given to it before one.

use super::body::{Body, ThuribleCondenser};
use crate::host::{self, Threads, ThuribleExecutor, ThuribleObserver};
use crate::instance;
use crate::pointer::{elements, put, writable};
use crate::result::{ThuribleResult, ThuribleStatus};
use core::ffi::c_void;
use thurible_core::condense::{Iteration, Step};

/// How a step of a body went.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default)]
pub struct ThuribleCondensed {
    /// How it ended.
    pub status: ThuribleStatus,
    /// Its iterations.
    pub iterations: usize,
    /// Builds of the basis, or of the factor that stands for it, in it.
    pub builds: usize,
    /// States that were told of: before each iteration, and at the end.
    pub told: usize,
}

/// A state before an iteration, or at the end of a step.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default)]
pub struct ThuribleIteration {
    /// How many iterations of this step came before.
    pub iteration: usize,
    /// Builds so far.
    pub builds: usize,
    /// The energy.
    pub energy: f64,
    /// What is compared with the tolerance.
    pub residual: f64,
    /// Part of the last direction that was gone, 0 at the beginning.
    pub length: f64,
}

impl From<&Iteration> for ThuribleIteration {
    fn from(state: &Iteration) -> Self {
        Self {
            iteration: state.iteration,
            builds: state.builds,
            energy: state.energy,
            residual: state.residual,
            length: state.length,
        }
    }
}

/// A vector of every vertex, or nothing where that is null.
///
/// # Safety
/// `values` is null or points to `bytes` bytes.
unsafe fn vectors<'a>(
    body: &mut Body,
    values: *const f64,
    bytes: usize,
) -> Result<&'a [f64], ThuribleResult> {
    if values.is_null() && bytes == 0 {
        return Ok(&[]);
    }
    // SAFETY: the caller's promise.
    let given: &[f64] = unsafe { elements(values.cast::<c_void>(), bytes) }?;
    if given.len() != body.condenser.one().vertices() * body.dims {
        return Err(ThuribleResult::Length);
    }
    Ok(given)
}

/// The next step: every vertex, held or not, is moved by `shift`, `dimensions` numbers for each and `shift_bytes` in all (null and 0 for none), `gravity`, three
/// numbers or null, accelerates all, and the energy is minimised. The states before each iteration and at the end are written to the first `room` entries of
/// `states`. `executor`, `observer`, `states` and `stepped` may be null. How it ends is in `stepped`; this returns only refusals, before anything has changed.
///
/// # Safety
/// `condenser` as in `thurible_condense_close`; `executor` and `observer` are null or keep to their contracts; `shift` is null or points to `shift_bytes`
/// bytes, `gravity` to three numbers, `states` to `room` entries to write; `stepped` is null or may be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn thurible_condense_step(
    condenser: *mut ThuribleCondenser,
    executor: *const ThuribleExecutor,
    observer: *const ThuribleObserver,
    shift: *const f64,
    shift_bytes: usize,
    gravity: *const f64,
    states: *mut ThuribleIteration,
    room: usize,
    stepped: *mut ThuribleCondensed,
) -> ThuribleResult {
    // SAFETY: the caller's promises.
    unsafe {
        instance::enter(condenser, |body| {
            writable(stepped)?;
            writable(states)?;
            let threads = Threads::new(executor, body.threads).ok_or(ThuribleResult::Executor)?;
            let mut observer = host::observer(observer).ok_or(ThuribleResult::Misaligned)?;
            let shift = vectors(body, shift, shift_bytes)?;
            let mut step = Step {
                shift,
                ..Step::default()
            };
            if !gravity.is_null() {
                let given: &[f64] = elements(gravity.cast::<c_void>(), size_of::<[f64; 3]>())?;
                step.gravity.copy_from_slice(given);
            }
            let mut told = 0;
            let room = if states.is_null() { 0 } else { room };
            let mut tell = |state: &Iteration| {
                if told < room {
                    states.add(told).write(state.into());
                }
                told += 1;
            };
            let done = body
                .condenser
                .one()
                .step(&threads, &step, &mut observer, &mut tell)?;
            put(
                stepped,
                ThuribleCondensed {
                    status: Some(done.status).into(),
                    iterations: done.iterations,
                    builds: done.builds,
                    told,
                },
            );
            Ok(())
        })
    }
}

/// Adds `shift`, `dimensions` numbers for each vertex and `bytes` in all, to their displacements.
///
/// # Safety
/// `condenser` as in `thurible_condense_close`; `shift` is null or points to `bytes` bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn thurible_condense_shift(
    condenser: *mut ThuribleCondenser,
    shift: *const f64,
    bytes: usize,
) -> ThuribleResult {
    // SAFETY: the caller's promises.
    unsafe {
        instance::enter(condenser, |body| {
            let shift = vectors(body, shift, bytes)?;
            Ok(body.condenser.one().shift(shift)?)
        })
    }
}

/// Gives free vertices a velocity, `dimensions` numbers for each vertex and `bytes` in all, before an implicit step; refused where `dt` is 0.
///
/// # Safety
/// `condenser` as in `thurible_condense_close`; `velocity` is null or points to `bytes` bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn thurible_condense_set_velocity(
    condenser: *mut ThuribleCondenser,
    velocity: *const f64,
    bytes: usize,
) -> ThuribleResult {
    // SAFETY: the caller's promises.
    unsafe {
        instance::enter(condenser, |body| {
            if velocity.is_null() {
                return Err(ThuribleResult::Null.into());
            }
            if !body.implicit {
                return Err(ThuribleResult::Config.into());
            }
            let velocity = vectors(body, velocity, bytes)?;
            Ok(body.condenser.one().set_velocity(velocity)?)
        })
    }
}
