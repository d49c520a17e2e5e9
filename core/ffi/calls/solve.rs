//! Step, finish, and how far the instance is.

use crate::host::{self, Threads, ThuribleExecutor, ThuribleObserver};
use crate::instance::{self, Body, Thurible, ThuribleProgress};
use crate::pointer::{put, writable};
use crate::result::{ThuribleResult, ThuribleStatus};

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
/// can be read afterwards, until the next step. The progress holds the objective of the result. It is the end of a solve: a search that is on a coarser
/// grid goes to the finest at once, and steps after it are a new descent from there, which counts its iterations anew. To look at a result on the way,
/// `thurible_save` before and `thurible_restore` after.
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
