//! The host's threads and observers.

use core::ffi::c_void;
use core::ops::ControlFlow;
use core::sync::atomic::{AtomicU32, AtomicUsize, Ordering};
use thurible_core::solver::MAX_THREADS;
use thurible_core::{Event, Exec, Observer, Phase};

/// A task: call it with the `argument` that came with it and an index below the number of tasks.
pub type ThuribleTask = Option<unsafe extern "C" fn(argument: *mut c_void, index: usize)>;

/// Runs `task(argument, i)` once for every `i < tasks`, on any threads and in any order, and returns when all are done. Neither
/// `task` nor `argument` may be used afterwards. An index that is called twice is ignored the second time; one that is not called
/// at all is run on the calling thread when this returns. It must return: no exception of C++ and no `longjmp` may leave it.
pub type ThuribleRun = Option<
    unsafe extern "C" fn(context: *mut c_void, tasks: usize, task: ThuribleTask, argument: *mut c_void),
>;

/// The host's threads. Results do not depend on them.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct ThuribleExecutor {
    /// How many tasks there may be at the same time, at most `threads` of the configuration.
    pub threads: usize,
    /// Runs tasks on them; null is refused.
    pub run: ThuribleRun,
    /// Passed to `run` as it is; the library never reads it.
    pub context: *mut c_void,
}

const WORDS: usize = MAX_THREADS.div_ceil(32);

/// One call of the host's `run`.
struct Call<'a> {
    tasks: usize,
    task: &'a (dyn Fn(usize) + Sync),
    /// A bit for every task that somebody has taken.
    taken: [AtomicU32; WORDS],
    done: AtomicUsize,
}

impl Call<'_> {
    /// Runs task `index`, if there is one and nobody has taken it.
    fn run(&self, index: usize) {
        let Some(word) = self.taken.get(index / 32).filter(|_| index < self.tasks) else {
            return;
        };
        let bit = 1 << (index % 32);
        if word.fetch_or(bit, Ordering::Relaxed) & bit == 0 {
            (self.task)(index);
            self.done.fetch_add(1, Ordering::Release);
        }
    }
}

/// What a host calls for every index.
unsafe extern "C" fn run_task(argument: *mut c_void, index: usize) {
    // SAFETY: `argument` is the call that `Threads::run` passed with this function, and `run` of the host has not returned.
    let call = unsafe { argument.cast::<Call<'_>>().as_ref() };
    if let Some(call) = call {
        call.run(index);
    }
}

/// An executor of the host, or the calling thread alone.
#[derive(Debug)]
pub struct Threads {
    threads: usize,
    run: Option<(
        unsafe extern "C" fn(*mut c_void, usize, ThuribleTask, *mut c_void),
        *mut c_void,
    )>,
}

// SAFETY: the context is only handed back to the host's own function, and by the thread that made the call alone: the core calls
// `run` on the thread that it was called on.
unsafe impl Sync for Threads {}

impl Threads {
    /// Checks an executor that may have at most `most` threads; null is the calling thread.
    ///
    /// # Safety
    /// `executor` is null or points to one that keeps to the contract of [`ThuribleRun`].
    #[must_use]
    pub unsafe fn new(executor: *const ThuribleExecutor, most: usize) -> Option<Self> {
        if executor.is_null() {
            return Some(Self {
                threads: 1,
                run: None,
            });
        }
        if !executor.is_aligned() {
            return None;
        }
        // SAFETY: not null, aligned, and the caller promises the rest.
        let ThuribleExecutor {
            threads,
            run,
            context,
        } = unsafe { executor.read() };
        let run = run.filter(|_| (1..=most.min(MAX_THREADS)).contains(&threads))?;
        Some(Self {
            threads,
            run: Some((run, context)),
        })
    }
}

impl Exec for Threads {
    fn threads(&self) -> usize {
        self.threads
    }

    fn run(&self, tasks: usize, task: &(dyn Fn(usize) + Sync)) {
        let Some((run, context)) = self.run.filter(|_| (2..=MAX_THREADS).contains(&tasks)) else {
            return (0..tasks).for_each(task);
        };
        let call = Call {
            tasks,
            task,
            taken: [const { AtomicU32::new(0) }; WORDS],
            done: AtomicUsize::new(0),
        };
        // SAFETY: the host's function with its context, by the contract of `ThuribleRun`; `call` outlives it.
        unsafe {
            run(
                context,
                tasks,
                Some(run_task),
                (&raw const call).cast_mut().cast(),
            )
        };
        (0..tasks).for_each(|index| call.run(index));
        while call.done.load(Ordering::Acquire) < tasks {
            core::hint::spin_loop();
        }
    }
}

/// What an event is about.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ThuribleEventKind {
    /// An iteration begins: `iteration`.
    Iteration = 0,
    /// The advection problem of ADMM begins.
    AoBegin = 1,
    /// An iteration of it is over: `iteration` counts them from 1, `value` is its objective, `step` its blending step.
    AoIteration = 2,
    /// The advection problem of ADMM is over.
    AoEnd = 3,
    /// The Navier-Stokes problem of ADMM begins.
    NsoBegin = 4,
    /// A cycle of it is over: `iteration` counts them from 1, `value` is the residual.
    NsoCycle = 5,
    /// The Navier-Stokes problem of ADMM is over.
    NsoEnd = 6,
    /// A piece of work well below a second at ordinary sizes is over.
    Work = 7,
}

/// A point of the solve.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct ThuribleEvent {
    /// What it is about.
    pub kind: ThuribleEventKind,
    /// A count from 1, or 0.
    pub iteration: usize,
    /// What the kind says, or 0.
    pub value: f64,
    /// A step, or 0.
    pub step: f64,
}

impl From<Event> for ThuribleEvent {
    fn from(event: Event) -> Self {
        let of = |kind| Self {
            kind,
            iteration: 0,
            value: 0.0,
            step: 0.0,
        };
        match event {
            Event::IterationBegin { iteration } => Self {
                iteration,
                ..of(ThuribleEventKind::Iteration)
            },
            Event::PhaseBegin(Phase { name: "ao", .. }) => of(ThuribleEventKind::AoBegin),
            Event::PhaseBegin(Phase { name: "nso", .. }) => of(ThuribleEventKind::NsoBegin),
            Event::PhaseEnd(Phase { name: "ao", .. }) => of(ThuribleEventKind::AoEnd),
            Event::PhaseEnd(Phase { name: "nso", .. }) => of(ThuribleEventKind::NsoEnd),
            Event::PhaseStep {
                phase: Phase { name: "ao", .. },
                step,
                value,
                taken,
            } => Self {
                iteration: step,
                value,
                step: taken,
                ..of(ThuribleEventKind::AoIteration)
            },
            Event::PhaseStep {
                phase: Phase { name: "nso", .. },
                step,
                value,
                ..
            } => Self {
                iteration: step,
                value,
                ..of(ThuribleEventKind::NsoCycle)
            },
            // A phase that this interface has no kind for is work like any other.
            _ => of(ThuribleEventKind::Work),
        }
    }
}

/// Hears of an event; anything but 0 stops the solve within one sweep. It must return: no exception of C++ and no `longjmp` may leave it.
pub type ThuribleOn = Option<unsafe extern "C" fn(context: *mut c_void, event: *const ThuribleEvent) -> i32>;

/// What the host watches and stops.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct ThuribleObserver {
    /// Called at every event, on the thread that called the library; null hears nothing.
    pub on: ThuribleOn,
    /// Passed to `on` as it is; the library never reads it.
    pub context: *mut c_void,
}

impl Observer for ThuribleObserver {
    fn on(&mut self, event: Event) -> ControlFlow<()> {
        let event = ThuribleEvent::from(event);
        // SAFETY: the host's function with its context; the event lives as long as the call.
        let stop = self
            .on
            .is_some_and(|on| unsafe { on(self.context, &raw const event) } != 0);
        if stop {
            ControlFlow::Break(())
        } else {
            ControlFlow::Continue(())
        }
    }
}

/// The observer, or one that hears nothing where it is null; `None` where it is misaligned.
///
/// # Safety
/// `observer` is null or points to one.
#[must_use]
pub unsafe fn observer(observer: *const ThuribleObserver) -> Option<ThuribleObserver> {
    if observer.is_null() {
        let context = core::ptr::null_mut();
        return Some(ThuribleObserver { on: None, context });
    }
    if !observer.is_aligned() {
        return None;
    }
    // SAFETY: not null, aligned, and the caller promises the rest.
    Some(unsafe { observer.read() })
}
