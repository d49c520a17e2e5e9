//! A solve on a thread of its own, while the thread that called it listens: to Python's signals, and to what its callback says.

use crate::iterated::Iterated;
use crate::iteration::Iteration;
use crate::words::read;
use core::ops::ControlFlow;
use core::sync::atomic::{AtomicBool, Ordering};
use pyo3::exceptions::{PyMemoryError, PyRuntimeError};
use pyo3::prelude::*;
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::thread;
use std::time::{Duration, Instant};
use thurible::threads;
use thurible_core::{Event, Exec, Observer, Serial, Status};

/// How often signals, as that of Ctrl-C, are looked for.
const LISTEN: Duration = Duration::from_millis(50);

/// How a solve ended.
pub struct Ended {
    /// Why it stopped.
    pub status: Status,
    /// How its last step ended.
    pub last: Status,
    /// All its iterations.
    pub history: Vec<Iteration>,
}

/// Stops within a sweep once asked to.
struct Stop<'a>(&'a AtomicBool);

impl Observer for Stop<'_> {
    fn on(&mut self, _event: Event) -> ControlFlow<()> {
        if self.0.load(Ordering::Relaxed) {
            ControlFlow::Break(())
        } else {
            ControlFlow::Continue(())
        }
    }
}

/// What the thread that solves shares with the one that listens.
struct Line<'a> {
    /// Raised by a signal.
    stop: &'a AtomicBool,
    /// Iterations, to the listener.
    iterations: Sender<Iteration>,
    /// Whether to go on after each, from the listener.
    answers: Receiver<bool>,
}

/// Solves with the interpreter released; `callback` hears every iteration on the thread of the caller, and stops by returning `False`
/// or raising.
pub fn solve(
    py: Python<'_>,
    iterated: &mut dyn Iterated,
    count: usize,
    callback: Option<Py<PyAny>>,
) -> PyResult<Ended> {
    py.detach(|| {
        let stop = AtomicBool::new(false);
        let (iterations, heard) = channel();
        let (answer, answers) = channel();
        thread::scope(|scope| {
            let line = Line {
                stop: &stop,
                iterations,
                answers,
            };
            let work = move || on_threads(count, |exec| line.iterate(iterated, exec));
            let worker = spawn(scope, work)?;
            let listened = listen(&heard, &answer, callback);
            if listened.is_err() {
                stop.store(true, Ordering::Relaxed);
            }
            // Whoever waits for an answer hears that there will be none.
            drop(answer);
            let status = joined(worker)?;
            let history = listened?;
            let [status, last] = status?;
            Ok(Ended {
                status,
                last,
                history,
            })
        })
    })
}

/// Calls `work` with an [`Exec`] of `count` threads.
pub fn on_threads<R: Send>(count: usize, work: impl FnOnce(&dyn Exec) -> R + Send) -> PyResult<R> {
    if count == 1 {
        return Ok(work(&Serial));
    }
    threads::with(count, || threads::together(count, work))
        .map_err(|failure| PyMemoryError::new_err(failure.to_string()))
}

/// Runs `work` on `count` threads with the interpreter released; a signal stops it, and is raised.
pub fn interruptible<R: Send>(
    py: Python<'_>,
    count: usize,
    work: impl FnOnce(&dyn Exec, &mut dyn Observer) -> R + Send,
) -> PyResult<R> {
    py.detach(|| {
        let stop = AtomicBool::new(false);
        let (end, ended) = channel::<()>();
        thread::scope(|scope| {
            let raised = &stop;
            let worker = spawn(scope, move || {
                // Dropped at the end, of which the listener hears by that.
                let _end = end;
                on_threads(count, |exec| work(exec, &mut Stop(raised)))
            })?;
            let mut listened = Ok(());
            while listened.is_ok() && ended.recv_timeout(LISTEN) == Err(RecvTimeoutError::Timeout) {
                listened = Python::attach(|py| py.check_signals());
            }
            if listened.is_err() {
                stop.store(true, Ordering::Relaxed);
            }
            let done = joined(worker)?;
            listened?;
            done
        })
    })
}

/// A thread of its own within a scope.
fn spawn<'s, R: Send + 's>(
    scope: &'s thread::Scope<'s, '_>,
    work: impl FnOnce() -> R + Send + 's,
) -> PyResult<thread::ScopedJoinHandle<'s, R>> {
    let worker = thread::Builder::new()
        .name("thurible".into())
        .spawn_scoped(scope, work);
    worker.map_err(|error| PyMemoryError::new_err(format!("cannot start a thread: {error}")))
}

/// What a thread came to.
fn joined<R>(worker: thread::ScopedJoinHandle<'_, R>) -> PyResult<R> {
    worker.join().map_err(|_| {
        PyRuntimeError::new_err("the solver panicked; this is a fault of thurible, please report it")
    })
}

impl Line<'_> {
    /// Iterates to the end and makes the result feasible: how the solve ended, and how its last step did.
    fn iterate(self, iterated: &mut dyn Iterated, exec: &dyn Exec) -> [Status; 2] {
        let began = Instant::now();
        let status = loop {
            let progress = iterated.step(exec, &mut Stop(self.stop));
            // An iteration that was cut short, or was not finite, has no numbers.
            if !matches!(progress.status, Some(Status::Cancelled | Status::NotFinite)) {
                let iteration = Iteration::new(&progress, began.elapsed().as_secs_f64());
                let told = self.iterations.send(iteration).is_ok();
                if !(told && self.answers.recv().unwrap_or(false)) {
                    break progress.status.unwrap_or(Status::Cancelled);
                }
            }
            if let Some(status) = progress.status {
                break status;
            }
            iterated.after();
        };
        let usable = status != Status::NotReady && !self.stop.load(Ordering::Relaxed);
        if usable {
            [status.of_result(iterated.finish(exec)), status]
        } else {
            [status; 2]
        }
    }
}

/// Answers iterations until there are no more; an error is a signal's or the callback's.
fn listen(
    heard: &Receiver<Iteration>,
    answer: &Sender<bool>,
    callback: Option<Py<PyAny>>,
) -> PyResult<Vec<Iteration>> {
    let (mut history, mut listened) = (Vec::new(), Instant::now());
    loop {
        let iteration = match heard.recv_timeout(LISTEN) {
            Ok(iteration) => Some(iteration),
            Err(RecvTimeoutError::Timeout) => None,
            Err(RecvTimeoutError::Disconnected) => return Ok(history),
        };
        if listened.elapsed() >= LISTEN {
            Python::attach(|py| py.check_signals())?;
            listened = Instant::now();
        }
        if let Some(iteration) = iteration {
            history.push(iteration.clone());
            let goes_on = callback
                .as_ref()
                .map_or(Ok(true), |callback| ask(callback, iteration))?;
            // Nobody waits for an answer to the last one.
            let _ = answer.send(goes_on);
        }
    }
}

/// What `callback` says of an iteration: nothing, or whether to go on.
fn ask(callback: &Py<PyAny>, iteration: Iteration) -> PyResult<bool> {
    Python::attach(|py| {
        let said = callback.bind(py).call1((iteration,))?;
        if said.is_none() {
            Ok(true)
        } else {
            read("what progress returned", &said, "None, True or False")
        }
    })
}
