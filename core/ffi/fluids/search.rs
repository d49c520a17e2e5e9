//! The search, an iteration at a time or to its end.

use super::body::{Body, ThuribleFluids};
use super::searched::ThuribleSearched;
use crate::each;
use crate::host::{self, Threads, ThuribleExecutor, ThuribleObserver};
use crate::instance;
use crate::pointer::{put, writable};
use crate::result::{ThuribleResult, ThuribleStatus};
use thurible_core::{Exec, Fluids, Observer, Real, Space};

/// Runs `work` with the host's threads and observer.
///
/// # Safety
/// As `thurible_fluids_step`.
unsafe fn run(
    fluids: *mut ThuribleFluids,
    executor: *const ThuribleExecutor,
    observer: *const ThuribleObserver,
    searched: *mut ThuribleSearched,
    goes_on: bool,
) -> ThuribleResult {
    // SAFETY: the caller's promises.
    unsafe {
        instance::enter(fluids, |body| {
            writable(searched)?;
            let threads = Threads::new(executor, body.threads).ok_or(ThuribleResult::Executor)?;
            let mut observer = host::observer(observer).ok_or(ThuribleResult::Misaligned)?;
            step(body, &threads, &mut observer);
            while goes_on && body.searched.status == ThuribleStatus::Goes {
                step(body, &threads, &mut observer);
            }
            put(searched, body.searched);
            Ok(())
        })
    }
}

fn step(body: &mut Body, exec: &dyn Exec, observer: &mut dyn Observer) {
    each!(&mut body.fluids, one => step_of(one, exec, observer, &mut body.searched));
}

// Not inlined, as the functions of an instance.
#[inline(never)]
fn step_of<T: Real, S: Space>(
    fluids: &mut Fluids<'_, T, S>,
    exec: &dyn Exec,
    observer: &mut dyn Observer,
    searched: &mut ThuribleSearched,
) {
    *searched = ThuribleSearched::from(&fluids.step(exec, observer));
}

/// One iteration. `executor`, `observer` and `searched` may be null. How a search ends is in `searched`, `THURIBLE_STATUS_NOT_READY` where source or keyframes
/// are missing or nothing is searched for; this returns only refusals.
///
/// # Safety
/// `fluids` as in `thurible_fluids_close`; `executor` and `observer` are null or keep to their contracts; `searched` is null or may be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn thurible_fluids_step(
    fluids: *mut ThuribleFluids,
    executor: *const ThuribleExecutor,
    observer: *const ThuribleObserver,
    searched: *mut ThuribleSearched,
) -> ThuribleResult {
    // SAFETY: the caller's promises.
    unsafe { run(fluids, executor, observer, searched, false) }
}

/// Iterates to the end; what is found is read by `thurible_fluids_replay`.
///
/// # Safety
/// As `thurible_fluids_step`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn thurible_fluids_solve(
    fluids: *mut ThuribleFluids,
    executor: *const ThuribleExecutor,
    observer: *const ThuribleObserver,
    searched: *mut ThuribleSearched,
) -> ThuribleResult {
    // SAFETY: the caller's promises.
    unsafe { run(fluids, executor, observer, searched, true) }
}
