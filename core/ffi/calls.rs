//! Make, fill, solve, save.

use crate::config::{ConfigError, ThuribleConfig};
use crate::each;
use crate::host::{self, Threads, ThuribleExecutor, ThuribleObserver};
use crate::instance::{self, ALIGN, Body, Planned, Refusal, Thurible, ThuribleProgress};
use crate::result::{ThuribleResult, ThuribleStatus};
use core::ffi::{c_char, c_void};
use thurible_core::Real;

/// Numbers of the caller.
///
/// # Safety
/// `values` is null or points to `bytes` bytes that live as long as the call.
unsafe fn numbers<'a, T: Real>(values: *const c_void, bytes: usize) -> Result<&'a [T], ThuribleResult> {
    let values: *const T = values.cast();
    match () {
        () if values.is_null() => Err(ThuribleResult::Null),
        () if !values.is_aligned() => Err(ThuribleResult::Misaligned),
        () if !bytes.is_multiple_of(T::BYTES) || bytes > isize::MAX as usize => Err(ThuribleResult::Length),
        // SAFETY: not null, aligned, and the caller promises the bytes; every pattern of bits is a number.
        () => Ok(unsafe { core::slice::from_raw_parts(values, bytes / T::BYTES) }),
    }
}

/// Refuses a place that may be null but is misaligned, before anything is done.
fn writable<V>(place: *mut V) -> Result<(), ThuribleResult> {
    if place.is_null() || place.is_aligned() {
        Ok(())
    } else {
        Err(ThuribleResult::Misaligned)
    }
}

/// Writes to a place of the caller that is null or [`writable`].
///
/// # Safety
/// `place` is null, or aligned and may be written.
unsafe fn put<V>(place: *mut V, value: V) {
    if !place.is_null() {
        // SAFETY: not null, and the caller promises the rest.
        unsafe { place.write(value) };
    }
}

/// How many bytes an instance takes, on which multiple of bytes they must begin, and how many bytes a saved one has. Nothing is
/// allocated or kept. Each pointer but `config` may be null.
///
/// # Safety
/// `config` is null or points to a configuration whose `keyframes` are there; the others are null or may be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn thurible_plan(
    config: *const ThuribleConfig,
    bytes: *mut usize,
    alignment: *mut usize,
    saved_bytes: *mut usize,
) -> ThuribleResult {
    let plan = || {
        [bytes, alignment, saved_bytes]
            .into_iter()
            .try_for_each(writable)?;
        // SAFETY: the caller's promises; the places were checked.
        unsafe {
            let Planned { bytes: needed, saved } = ThuribleConfig::read(config)
                .and_then(|config| instance::plan(&config))
                .map_err(ConfigError::result)?;
            put(bytes, needed);
            put(alignment, ALIGN);
            put(saved_bytes, saved);
        }
        Ok(())
    };
    plan().err().unwrap_or(ThuribleResult::Ok)
}

/// Makes an instance in `memory` of `bytes` bytes, as many as `thurible_plan` says or more, and writes its handle to `out`. The
/// memory is the instance's until it is closed; it must not be moved. Nothing else is needed: no global state, no allocation.
///
/// # Safety
/// `memory` is null or points to `bytes` bytes that nobody else uses; `config` as in `thurible_plan`; `out` is null or may be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn thurible_init(
    memory: *mut c_void,
    bytes: usize,
    config: *const ThuribleConfig,
    out: *mut *mut Thurible,
) -> ThuribleResult {
    if out.is_null() || !out.is_aligned() {
        return if out.is_null() {
            ThuribleResult::Null
        } else {
            ThuribleResult::Misaligned
        };
    }
    // SAFETY: the caller's promises; `out` was checked.
    unsafe {
        put(out, core::ptr::null_mut());
        let made = ThuribleConfig::read(config)
            .map_err(ConfigError::result)
            .and_then(|config| instance::make(memory.cast(), bytes, &config));
        match made {
            Ok(instance) => {
                put(out, instance);
                ThuribleResult::Ok
            }
            Err(result) => result,
        }
    }
}

/// Ends an instance: its memory is the caller's again and the handle is refused from now on.
///
/// # Safety
/// `instance` is null or points to memory of an instance's size.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn thurible_close(instance: *mut Thurible) -> ThuribleResult {
    // SAFETY: the caller's promise.
    unsafe { instance::close(instance) }
}

/// Writes why the last call with this instance was refused, or nothing where it was not, as `thurible_explain` does.
///
/// # Safety
/// `instance` as in `thurible_close`; `buffer` is null or points to `size` bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn thurible_message(
    instance: *const Thurible,
    buffer: *mut c_char,
    size: usize,
) -> usize {
    // SAFETY: the caller's promises.
    unsafe { instance::message(instance, buffer, size) }
}

/// Sets the density of step 0: one number of the instance's precision for each cell, x fastest; `bytes` of all.
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
            Ok(each!(&mut body.solver, solver => solver.set_source(numbers(density, bytes)?))?)
        })
    }
}

/// Sets the target of keyframe `index`, as `thurible_set_source`, which comes first. Where keyframes are scaled to the source's mass,
/// `factor` is by how much; it may be null.
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
                each!(&mut body.solver, solver => solver.set_keyframe(index, numbers(density, bytes)?))?,
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
            Ok(each!(&mut body.solver, solver => solver.set_initial_velocity(axis, numbers(faces, bytes)?))?)
        })
    }
}

/// Runs `work` with the host's threads and observer, once all densities are there.
///
/// # Safety
/// As `thurible_step`.
unsafe fn run(
    instance: *mut Thurible,
    executor: *const ThuribleExecutor,
    observer: *const ThuribleObserver,
    progress: *mut ThuribleProgress,
    work: impl FnOnce(&mut Body, &Threads, &mut ThuribleObserver),
) -> ThuribleResult {
    // SAFETY: the caller's promises.
    unsafe {
        instance::enter(instance, |body| {
            writable(progress)?;
            let threads = Threads::new(executor, body.sizes.threads).ok_or(ThuribleResult::Executor)?;
            let mut observer = host::observer(observer).ok_or(ThuribleResult::Misaligned)?;
            body.prepare(&threads)?;
            work(body, &threads, &mut observer);
            put(progress, body.progress);
            Ok(())
        })
    }
}

/// One iteration. `executor`, `observer` and `progress` may be null: one thread, nobody who watches, and see `thurible_progress`. How
/// a solve ends is in the progress; this returns only refusals.
///
/// # Safety
/// `instance` as in `thurible_close`; `executor` and `observer` are null or keep to their contracts; `progress` is null or may be
/// written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn thurible_step(
    instance: *mut Thurible,
    executor: *const ThuribleExecutor,
    observer: *const ThuribleObserver,
    progress: *mut ThuribleProgress,
) -> ThuribleResult {
    // SAFETY: the caller's promises.
    unsafe {
        run(
            instance,
            executor,
            observer,
            progress,
            |body, threads, observer| body.step(threads, observer),
        )
    }
}

/// Makes the result feasible: the flow free of divergence, the forces those that make it, the densities those that it carries. Results
/// can be read afterwards, until the next step. The progress holds the objective of the result.
///
/// # Safety
/// As `thurible_step`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn thurible_finish(
    instance: *mut Thurible,
    executor: *const ThuribleExecutor,
    progress: *mut ThuribleProgress,
) -> ThuribleResult {
    // SAFETY: the caller's promises.
    unsafe {
        run(
            instance,
            executor,
            core::ptr::null(),
            progress,
            |body, threads, _| body.finish(threads),
        )
    }
}

/// Steps to the end and finishes. `progress` says how it ended.
///
/// # Safety
/// As `thurible_step`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn thurible_solve(
    instance: *mut Thurible,
    executor: *const ThuribleExecutor,
    observer: *const ThuribleObserver,
    progress: *mut ThuribleProgress,
) -> ThuribleResult {
    let solve = |body: &mut Body, threads: &Threads, observer: &mut ThuribleObserver| {
        body.step(threads, observer);
        while body.progress.status == ThuribleStatus::Goes {
            body.step(threads, observer);
        }
        body.finish(threads);
    };
    // SAFETY: the caller's promises.
    unsafe { run(instance, executor, observer, progress, solve) }
}

/// How far the instance is: what the last step or finish said.
///
/// # Safety
/// `instance` as in `thurible_close`; `progress` is null or may be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn thurible_progress(
    instance: *const Thurible,
    progress: *mut ThuribleProgress,
) -> ThuribleResult {
    // SAFETY: the caller's promises.
    unsafe {
        instance::enter(instance, |body| {
            writable(progress)?;
            put(progress, body.progress);
            Ok(())
        })
    }
}

/// Saves the whole state, densities included, into `bytes` of `size` bytes, `saved_bytes` of `thurible_plan` or more: plain bytes, the
/// same on every machine.
///
/// # Safety
/// `instance` as in `thurible_close`; `bytes` is null or points to `size` bytes to write.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn thurible_save(
    instance: *mut Thurible,
    bytes: *mut c_void,
    size: usize,
) -> ThuribleResult {
    // SAFETY: the caller's promises.
    unsafe {
        instance::enter(instance, |body| {
            if bytes.is_null() {
                return Err(ThuribleResult::Null.into());
            }
            let needed = each!(&body.solver, solver => solver.saved_bytes());
            if size < needed {
                return Err(ThuribleResult::Length.into());
            }
            // No byte is read before it is written, but a slice must not hold what was never written.
            bytes.cast::<u8>().write_bytes(0, needed);
            let bytes = core::slice::from_raw_parts_mut(bytes.cast::<u8>(), needed);
            Ok(each!(&mut body.solver, solver => solver.save(bytes))?)
        })
    }
}

/// Goes on from what `thurible_save` wrote, of exactly `saved_bytes`, here or in another instance, process or machine, whose
/// configuration may differ in threads, ceiling and iterations alone: every later step gives the same bits. Damaged bytes and those of
/// another configuration are refused and change nothing.
///
/// # Safety
/// `instance` as in `thurible_close`; `bytes` is null or points to `size` bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn thurible_restore(
    instance: *mut Thurible,
    bytes: *const c_void,
    size: usize,
) -> ThuribleResult {
    // SAFETY: the caller's promises.
    unsafe {
        instance::enter(instance, |body| {
            if bytes.is_null() {
                return Err(ThuribleResult::Null.into());
            }
            if size > isize::MAX as usize {
                return Err(ThuribleResult::Length.into());
            }
            let bytes = core::slice::from_raw_parts(bytes.cast::<u8>(), size);
            each!(&mut body.solver, solver => solver.restore(bytes))?;
            body.progress = each!(&body.solver, solver => {
                let objective = solver.objective();
                ThuribleProgress { data: objective.data, force: objective.force, ..ThuribleProgress::default() }
            });
            Ok::<(), Refusal>(())
        })
    }
}
