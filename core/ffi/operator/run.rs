//! A simulation, and its way back.

use super::body::{Body, ThuribleOperator, simulator};
use crate::host::{self, Threads, ThuribleExecutor, ThuribleObserver};
use crate::instance::{self, Refusal};
use crate::pointer::required;
use crate::result::{ThuribleResult, ThuribleStatus};
use crate::steps::{Steps, ThuribleSteps, Watch};
use core::cell::Cell;
use thurible_core::Real;
use thurible_core::operator::{Given, OperatorError, Simulator, Start, View};

/// How a simulation or its way back ended.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default)]
pub struct ThuribleRan {
    /// `THURIBLE_STATUS_CONVERGED` where it came to its end; `THURIBLE_STATUS_CANCELLED` where the observer or a `ThuribleOnStep` stopped it;
    /// `THURIBLE_STATUS_NOT_FINITE` where a flow was too fast or not finite.
    pub status: ThuribleStatus,
    /// Steps that were run again, beside the one for each step that was taken back.
    pub repeated: usize,
}

/// What every run has: threads, who watches, and whether a callback said stop.
struct Run<'a> {
    threads: Threads,
    watch: Watch<'a>,
}

impl<'a> Run<'a> {
    /// # Safety
    /// `executor` and `observer` are null or keep to their contracts.
    unsafe fn new(
        body: &Body,
        executor: *const ThuribleExecutor,
        observer: *const ThuribleObserver,
        stopped: &'a Cell<bool>,
    ) -> Result<Self, ThuribleResult> {
        // SAFETY: the caller's promises.
        unsafe {
            Ok(Self {
                threads: Threads::new(executor, body.threads).ok_or(ThuribleResult::Executor)?,
                watch: Watch {
                    observer: host::observer(observer).ok_or(ThuribleResult::Misaligned)?,
                    stopped,
                },
            })
        }
    }

    /// What is said of a run that ended.
    fn said(&self, done: Result<(), OperatorError>, repeated: usize) -> Result<ThuribleRan, Refusal> {
        let status = match done {
            Ok(()) if !self.watch.stopped.get() => ThuribleStatus::Converged,
            Ok(()) | Err(OperatorError::Cancelled) => ThuribleStatus::Cancelled,
            Err(OperatorError::TooFast { .. }) => ThuribleStatus::NotFinite,
            Err(error) => return Err(error.into()),
        };
        Ok(ThuribleRan { status, repeated })
    }
}

/// Simulates all steps: from the density of `start`, which may be any finite numbers, and its velocity, at rest where components are null; pushed by
/// `forces`, of the steps 0 .. N - 1, beside what the scene has. `states` are the N + 1 densities and velocities, that at the start first. `forces`,
/// `states`, `executor` and `observer` may be null. How it ends is in `ran`, which must not be null; this returns only refusals.
///
/// # Safety
/// `operator_` as in `thurible_operator_close`; `executor` and `observer` are null or keep to their contracts; the others are null or may be read and
/// written, and their arrays are null or have as many bytes as they say and overlap no other.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn thurible_operator_simulate(
    operator_: *mut ThuribleOperator,
    executor: *const ThuribleExecutor,
    observer: *const ThuribleObserver,
    start: *const ThuribleSteps,
    forces: *const ThuribleSteps,
    states: *const ThuribleSteps,
    ran: *mut ThuribleRan,
) -> ThuribleResult {
    let stopped = &Cell::new(false);
    // SAFETY: the caller's promises.
    unsafe {
        instance::enter(operator_, |body| {
            required(ran)?;
            let mut run = Run::new(body, executor, observer, stopped)?;
            let (count, fields) = (body.steps, (body.lens, body.number));
            let start = Steps::read(start, 1, fields, stopped)?;
            if !start.has(0) {
                return Err(ThuribleResult::Null.into());
            }
            let forces = Steps::read(forces, count, no_density(fields), stopped)?;
            let states = Steps::read(states, count + 1, fields, stopped)?;
            (body.simulated, body.differentiated) = (false, false);
            let (done, repeated) = simulator!(&mut body.simulator, one => {
                (simulate(one, &mut run, [&start, &forces, &states]), Simulator::repeated(one))
            });
            let said = run.said(done, repeated)?;
            body.simulated = said.status == ThuribleStatus::Converged;
            ran.write(said);
            Ok(())
        })
    }
}

/// The vector-Jacobian product of the last simulation: `cotangents` are what a scalar function gets by the N + 1 densities and velocities, asked for
/// from the last to the first; `gradients` what it gets by the forces of the steps N - 1 .. 0, in this order; `thurible_operator_gradient` and the others have the rest. `forces`
/// are those of the simulation. Each pointer but `operator_` and `ran` may be null. It may be called again.
///
/// # Safety
/// As `thurible_operator_simulate`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn thurible_operator_vjp(
    operator_: *mut ThuribleOperator,
    executor: *const ThuribleExecutor,
    observer: *const ThuribleObserver,
    forces: *const ThuribleSteps,
    cotangents: *const ThuribleSteps,
    gradients: *const ThuribleSteps,
    ran: *mut ThuribleRan,
) -> ThuribleResult {
    let stopped = &Cell::new(false);
    // SAFETY: the caller's promises.
    unsafe {
        instance::enter(operator_, |body| {
            required(ran)?;
            let mut run = Run::new(body, executor, observer, stopped)?;
            let (count, fields) = (body.steps, (body.lens, body.number));
            let forces = Steps::read(forces, count, no_density(fields), stopped)?;
            let cotangents = Steps::read(cotangents, count + 1, fields, stopped)?;
            let gradients = Steps::read(gradients, count, no_density(fields), stopped)?;
            body.differentiated = false;
            if !body.simulated {
                return Err(OperatorError::NotSimulated.into());
            }
            let (done, repeated) = simulator!(&mut body.simulator, one => {
                (vjp(one, &mut run, [&forces, &cotangents, &gradients]), Simulator::repeated(one))
            });
            let said = run.said(done, repeated)?;
            body.differentiated = said.status == ThuribleStatus::Converged;
            ran.write(said);
            Ok(())
        })
    }
}

/// Of fields without a density.
fn no_density<const P: usize>((mut lens, number): ([usize; P], usize)) -> ([usize; P], usize) {
    if let Some(density) = lens.first_mut() {
        *density = 0;
    }
    (lens, number)
}

/// Gives what there is of a step.
fn give<T: Real>(steps: &Steps<'_>) -> impl FnMut(usize, &mut Given<'_, T>) {
    move |step, given| {
        steps.give(step, |part, values| match part.checked_sub(1) {
            None => given.density(values),
            Some(axis) => given.vector(axis, values),
        });
    }
}

/// Hands out what there is of a step.
fn take<T: Real>(steps: &Steps<'_>) -> impl FnMut(usize, &View<'_, T>) {
    move |step, view| {
        steps.take(step, |part, out| match part.checked_sub(1) {
            None => view.read_density(out),
            Some(axis) => view.read_vector(axis, out),
        });
    }
}

// Not inlined, as the functions of an instance.
#[inline(never)]
fn simulate<T: Real>(
    one: &mut dyn Simulator<T>,
    run: &mut Run<'_>,
    [start, forces, states]: [&Steps<'_>; 3],
) -> Result<(), OperatorError> {
    let part = |part| start.part(part, 0).unwrap_or_default();
    let start = Start {
        density: part(0),
        velocity: [part(1), part(2), part(3)],
    };
    let (mut force, mut show) = (give(forces), take(states));
    one.simulate(&run.threads, &mut run.watch, &start, &mut force, &mut show)
}

#[inline(never)]
fn vjp<T: Real>(
    one: &mut dyn Simulator<T>,
    run: &mut Run<'_>,
    [forces, cotangents, gradients]: [&Steps<'_>; 3],
) -> Result<(), OperatorError> {
    let (mut force, mut cotangent, mut show) = (give(forces), give(cotangents), take(gradients));
    one.vjp(
        &run.threads,
        &mut run.watch,
        &mut force,
        &mut cotangent,
        &mut show,
    )
}
