//! What was found: the flow, templates, the unknowns themselves.

use super::body::ThuribleFluids;
use crate::config::ThuribleTemplate;
use crate::each;
use crate::host::{self, Threads, ThuribleExecutor, ThuribleObserver};
use crate::instance::{self, Refusal};
use crate::pointer::{array, put, required, writable};
use crate::result::{ThuribleResult, ThuribleStatus};
use crate::steps::{Steps, ThuribleSteps, Watch, lens};
use core::cell::Cell;
use core::ffi::c_void;
use core::ops::ControlFlow;
use thurible_core::{Fluids, Real, Space, Status};

/// Simulates by what was found, a step at a time: `states` are the N + 1 densities and velocities at the centres of cells, that at the start first, `forces` those
/// of the steps 0 .. N - 1, each told of when the step was taken. Either may be null, as `executor` and `observer`. The search may go on afterwards. How it ends is in
/// `status`, which must not be null; this returns only refusals.
///
/// # Safety
/// `fluids` as in `thurible_fluids_close`; `executor` and `observer` are null or keep to their contracts; the others are null or may be read and written,
/// and their arrays are null or have as many bytes as they say and overlap no other.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn thurible_fluids_replay(
    fluids: *mut ThuribleFluids,
    executor: *const ThuribleExecutor,
    observer: *const ThuribleObserver,
    states: *const ThuribleSteps,
    forces: *const ThuribleSteps,
    status: *mut ThuribleStatus,
) -> ThuribleResult {
    let stopped = &Cell::new(false);
    // SAFETY: the caller's promises.
    unsafe {
        instance::enter(fluids, |body| {
            required(status)?;
            let threads = Threads::new(executor, body.threads).ok_or(ThuribleResult::Executor)?;
            let observer = host::observer(observer).ok_or(ThuribleResult::Misaligned)?;
            let ([cells, x, y, z], steps) = each!(&body.fluids, one => (lens(one), one.steps()));
            let states = Steps::read(states, steps + 1, ([cells, x, y, z], body.number), stopped)?;
            let forces = Steps::read(forces, steps, ([0, x, y, z], body.number), stopped)?;
            let mut watch = Watch { observer, stopped };
            let done = each!(&mut body.fluids, one => replay(one, &threads, &mut watch, [&states, &forces]));
            status.write(match done {
                Ok(()) if !stopped.get() => ThuribleStatus::Converged,
                Ok(()) => ThuribleStatus::Cancelled,
                Err(status) => Some(status).into(),
            });
            Ok(())
        })
    }
}

#[inline(never)]
fn replay<T: Real, S: Space>(
    fluids: &mut Fluids<'_, T, S>,
    threads: &Threads,
    watch: &mut Watch<'_>,
    [states, forces]: [&Steps<'_>; 2],
) -> Result<(), Status> {
    fluids.replay(threads, watch, &mut |mut moment| {
        let step = moment.step;
        if step > 0 {
            forces.take::<T>(step - 1, |part, out| {
                copy(out, moment.force(part.saturating_sub(1)).unwrap_or_default());
            });
        }
        states.take::<T>(step, |part, out| {
            let field = match part.checked_sub(1) {
                None => moment.density(),
                Some(axis) => moment.velocity(axis),
            };
            copy(out, field);
        });
        ControlFlow::Continue(())
    })
}

/// Copies as many numbers as both have.
fn copy<T: Real>(out: &mut [T], from: &[T]) {
    out.iter_mut().zip(from).for_each(|(out, &value)| *out = value);
}

/// Writes how many unknowns there are to `count` and copies them into `out` of exactly `bytes` bytes; either may be null. First is the velocity at the start, component after
/// component, then forces step after step, then the numbers of each template.
///
/// # Safety
/// `fluids` as in `thurible_fluids_close`; `count` is null or may be written; `out` is null or points to `bytes` bytes to write.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn thurible_fluids_unknowns(
    fluids: *mut ThuribleFluids,
    count: *mut usize,
    out: *mut c_void,
    bytes: usize,
) -> ThuribleResult {
    // SAFETY: the caller's promises.
    unsafe {
        instance::enter(fluids, |body| {
            writable(count)?;
            each!(&mut body.fluids, one => {
                let unknowns = one.unknowns();
                if !out.is_null() {
                    copy(array(out, bytes, unknowns.len())?, unknowns);
                }
                put(count, unknowns.len());
            });
            Ok::<(), Refusal>(())
        })
    }
}

/// Template `index` as it is now, from 0 on: its middle and radius, and its first amplitude.
///
/// # Safety
/// `fluids` as in `thurible_fluids_close`; `found` is null or may be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn thurible_fluids_template(
    fluids: *mut ThuribleFluids,
    index: usize,
    found: *mut ThuribleTemplate,
) -> ThuribleResult {
    // SAFETY: the caller's promises.
    unsafe {
        instance::enter(fluids, |body| {
            required(found)?;
            let (template, amplitude) =
                each!(&mut body.fluids, one => (one.template(index), one.template_amplitude(index, 0)));
            let mut template = template.ok_or(ThuribleResult::Index)?.template;
            template.amplitude = amplitude.unwrap_or(template.amplitude);
            found.write(template.into());
            Ok(())
        })
    }
}

/// The amplitude that template `index` has at step `step` now, from its `from` to before its `to`: three numbers, of which the template's kind says how many
/// count.
///
/// # Safety
/// `fluids` as in `thurible_fluids_close`; `amplitude` is null or points to three numbers to write.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn thurible_fluids_template_amplitude(
    fluids: *mut ThuribleFluids,
    index: usize,
    step: usize,
    amplitude: *mut f64,
) -> ThuribleResult {
    // SAFETY: the caller's promises.
    unsafe {
        instance::enter(fluids, |body| {
            required(amplitude)?;
            let found = each!(&mut body.fluids, one => one.template(index));
            let template = found.ok_or(ThuribleResult::Index)?.template;
            let interval = template
                .interval_at(step, template.to)
                .ok_or(ThuribleResult::Index)?;
            let found = each!(&mut body.fluids, one => one.template_amplitude(index, interval));
            amplitude
                .cast::<[f64; 3]>()
                .write(found.ok_or(ThuribleResult::Index)?);
            Ok(())
        })
    }
}
