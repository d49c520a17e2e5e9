//! A solve on a thread of its own, while the thread that called it listens: to Python's signals, and to what its callback says.

use crate::iterated::Iterated;
use crate::words::read;
use core::ops::ControlFlow;
use core::sync::atomic::{AtomicBool, Ordering};
use pyo3::exceptions::{PyMemoryError, PyRuntimeError};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::thread;
use std::time::{Duration, Instant};
use thurible::threads;
use thurible_core::{Event, Exec, Fact, Kind, Observer, Progress, Serial, Status};

/// How often signals, as that of Ctrl-C, are looked for.
const LISTEN: Duration = Duration::from_millis(50);

/// What one iteration did.
#[pyclass(frozen, module = "thurible_smoke", name = "Progress")]
#[derive(Clone, Debug)]
pub struct Iteration {
    /// Iteration, from 1, those on coarser grids included.
    #[pyo3(get)]
    iteration: usize,
    /// Seconds since the solve began.
    #[pyo3(get)]
    seconds: f64,
    /// The objective: `data + force`.
    #[pyo3(get)]
    objective: f64,
    /// Distance from the keyframes.
    #[pyo3(get)]
    data: f64,
    /// Price of the force.
    #[pyo3(get)]
    force: f64,
    /// Cells along x, y (and z) of the grid that it worked on, where the method tells.
    #[pyo3(get)]
    cells: Option<Vec<usize>>,
    /// Step along the direction, of the direct method and L-BFGS; blending step of ADMM.
    #[pyo3(get)]
    step: Option<f64>,
    /// ADMM: largest change of the densities, in parts of the source's largest.
    #[pyo3(get)]
    density_change: Option<f64>,
    /// ADMM: max |v - v*| over max |v|.
    #[pyo3(get)]
    gap: Option<f64>,
    /// ADMM: the largest violation of the conditions of an optimum.
    #[pyo3(get)]
    kkt: Option<f64>,
    /// What the method reported, each fact with its values.
    facts: Vec<(Fact, Vec<f64>)>,
}

impl Iteration {
    fn new(progress: &Progress, seconds: f64) -> Self {
        let fact = |name: &str| progress.report.get(name);
        Self {
            iteration: progress.iteration,
            seconds,
            objective: progress.objective.total(),
            data: progress.objective.data,
            force: progress.objective.force,
            cells: (progress.level_iteration > 0)
                .then(|| progress.cells.into_iter().filter(|&count| count > 1).collect()),
            step: fact("step").or(fact("ao_step")),
            density_change: fact("density_change"),
            gap: fact("gap"),
            kkt: fact("kkt"),
            facts: progress
                .report
                .iter()
                .map(|(fact, values)| (fact, values.to_vec()))
                .collect(),
        }
    }
}

impl Iteration {
    /// Whether it worked on the grid of these cells, where it says.
    pub fn is_on(&self, cells: &[usize]) -> bool {
        self.cells.as_deref().is_none_or(|own| own == cells)
    }

    /// The last value of a fact.
    pub fn fact(&self, name: &str) -> Option<f64> {
        let found = self.facts.iter().find(|(fact, _)| fact.name == name);
        found.and_then(|(_, values)| values.last().copied())
    }
}

#[pymethods]
impl Iteration {
    /// What the method reported, by name: a number, a count, a truth value, or a list of numbers.
    #[getter]
    fn facts<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let facts = PyDict::new(py);
        for (Fact { name, kind, .. }, values) in &self.facts {
            let value = values.first().copied().unwrap_or(f64::NAN);
            match kind {
                Kind::Number => facts.set_item(name, value)?,
                Kind::Count => facts.set_item(name, value as u64)?,
                Kind::Flag => facts.set_item(name, value != 0.0)?,
                Kind::Series => facts.set_item(name, values)?,
            }
        }
        Ok(facts)
    }

    /// What each of the facts is, in a few words, by name.
    #[getter]
    fn fact_words<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let words = PyDict::new(py);
        for (fact, _) in &self.facts {
            words.set_item(fact.name, fact.words)?;
        }
        Ok(words)
    }

    fn __repr__(&self) -> String {
        format!(
            "<thurible_smoke.Progress: iteration {}, objective {:.5e} = data {:.5e} + force {:.5e}>",
            self.iteration, self.objective, self.data, self.force
        )
    }
}

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
