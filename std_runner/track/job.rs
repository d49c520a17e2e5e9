//! A planned capture in its block of memory: track, write, report.

use super::errors::Measure;
use super::page;
use super::plan::Planned;
use super::record::{Ended, PairRecord, TrackRecord};
use super::scene::CaptureScene;
use super::store::Store;
use crate::bytes::{grouped, rounded};
use crate::console;
use crate::destination::Destination;
use crate::exit::{DONE, FILE, Failure, INTERRUPTED, NOT_FINITE};
use crate::interrupt::Interrupt;
use crate::output::{OutputError, Precision, write_whole};
use crate::plan::size_in_words;
use crate::progress::{Clock, Display, Mode, in_words};
use crate::region::{Region, touch};
use crate::{problem, threads};
use core::mem::MaybeUninit;
use core::ops::ControlFlow;
use serde_json::json;
use std::path::{Path, PathBuf};
use thurible_core::transport::Stop;
use thurible_core::{D2, D3, Event, Exec, Named, Observer, Real, Space, Status, Tracker};

/// The names of components' ends.
const AXES: [&str; 3] = ["x", "y", "z"];
/// The names of what a pair hands out, in its order.
const PARTS: [&str; 3] = ["predicted", "correction", "velocity"];

/// What is asked for.
pub(crate) struct Request {
    pub scene: CaptureScene,
    pub folder: PathBuf,
    pub mode: Mode,
    pub clock: Clock,
}

/// Tracks a planned capture and writes its result folder; the answer is the exit code.
pub(crate) fn run(request: &Request, planned: Planned) -> Result<u8, Failure> {
    let count = planned.params.threads;
    threads::with(count, || Job::run(request, planned))?
}

/// A capture that is being tracked.
struct Job<'a> {
    request: &'a Request,
    planned: Planned,
    display: Display,
    interrupt: Interrupt,
    history: Vec<PairRecord>,
}

/// Stops where the user asks for it.
struct Watch<'a> {
    interrupt: &'a Interrupt,
    display: &'a Display,
}

impl Observer for Watch<'_> {
    fn on(&mut self, _event: Event) -> ControlFlow<()> {
        self.display.tick();
        if self.interrupt.asked() {
            ControlFlow::Break(())
        } else {
            ControlFlow::Continue(())
        }
    }
}

impl Job<'_> {
    fn run(request: &Request, planned: Planned) -> Result<u8, Failure> {
        let bytes = planned.plan.bytes();
        let no_memory = || {
            Failure::Memory(format!(
                "the system has not the {} bytes that tracking needs; close other programs, or give frames of fewer cells",
                grouped(bytes)
            ))
        };
        let mut region = Region::new(bytes).ok_or_else(no_memory)?;
        let files = ["result.npz", "report.json", "report.html"].map(PathBuf::from);
        let mut destination = Destination::check(&request.folder, files.to_vec())?;
        let mut store = Store::new(&destination)?;
        let mut job = Job {
            request,
            display: Display::new(request.mode, planned.given.pairs),
            planned,
            interrupt: Interrupt::listen()?,
            history: Vec::new(),
        };
        job.announce();
        let footprint = region.footprint();
        let block = region.carve(bytes).ok_or_else(no_memory)?;
        touch(block);
        let threads = job.planned.params.threads;
        let status = threads::together(threads, |exec| job.dispatch(exec, block, &mut store))?;
        drop(region);
        job.finish(&mut destination, &mut store, status, footprint)
    }

    /// Says what is going to be tracked, and what was found.
    fn announce(&self) {
        let Planned { given, plan, params, precision, .. } = &self.planned;
        self.display.event(
            "plan",
            json!({ "cells": given.cells, "pairs": given.pairs, "precision": precision.name(), "threads": params.threads,
                    "method": params.flow.minimiser.name(), "bytes": plan.bytes() }),
        );
        self.display.note(&format!(
            "{} by {}: {} cells, {} frames, {} bytes ({}) in {}, {} threads",
            self.request.scene.document.path().display(),
            params.flow.minimiser.name(),
            size_in_words(&given.cells),
            given.pairs + 1,
            grouped(plan.bytes()),
            rounded(plan.bytes()),
            precision.name(),
            params.threads
        ));
        for remark in &given.remarks {
            self.display.warning(remark);
        }
    }

    fn dispatch(
        &mut self,
        exec: &dyn Exec,
        block: &mut [MaybeUninit<u8>],
        store: &mut Store,
    ) -> Result<Status, Failure> {
        match (self.planned.given.cells.len(), self.planned.precision) {
            (2, problem::Precision::F32) => self.track::<f32, D2>(exec, block, store),
            (2, problem::Precision::F64) => self.track::<f64, D2>(exec, block, store),
            (_, problem::Precision::F32) => self.track::<f32, D3>(exec, block, store),
            (_, problem::Precision::F64) => self.track::<f64, D3>(exec, block, store),
        }
    }

    fn track<T: Real, S: Space>(
        &mut self,
        exec: &dyn Exec,
        block: &mut [MaybeUninit<u8>],
        store: &mut Store,
    ) -> Result<Status, Failure> {
        let boundary = self.planned.given.boundary.clone();
        let cells = self.planned.given.cells.clone();
        let capture = thurible_core::Capture {
            cells: &cells,
            boundary: &boundary,
            ..self.planned.given.capture(self.planned.buoyancy)
        };
        let refused = |error: &dyn core::fmt::Display| Failure::Input(format!("the capture is refused: {error}"));
        let mut tracker =
            Tracker::<T, S>::new(&capture, &self.planned.params, block).map_err(|error| refused(&error))?;
        self.begin(&mut tracker)?;
        let arrays = self.arrays::<S>(store)?;
        for index in 0..=self.planned.given.pairs {
            let frame = self.planned.given.frame(&self.request.scene, index)?;
            let frame: Vec<T> = frame.into_iter().map(T::from_f64).collect();
            store.push(arrays.captured, &frame)?;
            tracker.give(exec, &frame).map_err(|error| refused(&error))?;
            if index == 0 {
                store.push(arrays.density, tracker.carried())?;
                continue;
            }
            match self.pair(exec, &mut tracker, &arrays, store) {
                Ok(()) => {}
                Err(Ending::Stopped(Stop::Cancelled)) => return Ok(Status::Cancelled),
                Err(Ending::Stopped(Stop::TooFast)) => return Ok(Status::NotFinite),
                Err(Ending::Failed(failure)) => return Err(failure),
            }
        }
        Ok(Status::Converged)
    }

    /// Gives the velocity of the first pair, where one is given.
    fn begin<T: Real, S: Space>(&self, tracker: &mut Tracker<'_, T, S>) -> Result<(), Failure> {
        let scene = &self.request.scene;
        let Some(path) = &scene.initial_velocity else {
            return Ok(());
        };
        let key = "track.initial_velocity";
        for (axis, name) in AXES.iter().enumerate().take(S::DIM) {
            let name = format!("velocity_{name}");
            let refuse = |why: String| {
                Failure::Input(format!("{}: `{key}` file `{}` {why}", scene.document.place(key), path.display()))
            };
            let mut series = crate::keyframes::Series::open(path, Some(&name), key)
                .map_err(|error| Failure::Input(format!("{}: {error}", scene.document.place(key))))?;
            let faces = series.read(0).map_err(|error| refuse(error.to_string()))?;
            let faces: Vec<T> = faces.into_iter().map(T::from_f64).collect();
            let taken = tracker.set_initial_velocity(axis, &faces);
            taken.map_err(|error| refuse(format!("has {name} that is refused: {error}; give that of the same cells and boundary")))?;
        }
        Ok(())
    }

    /// Begins the arrays of the result.
    fn arrays<S: Space>(&self, store: &mut Store) -> Result<Arrays, Failure> {
        let given = &self.planned.given;
        let cells: Vec<usize> = given.cells.iter().rev().copied().collect();
        let captured = store.begin("captured", cells.clone())?;
        let density = if self.planned.params.readvect {
            store.begin("density", cells)?
        } else {
            usize::MAX
        };
        let mut faces = [[usize::MAX; 3]; 4];
        let names = PARTS.iter().copied().chain(given.has_truth().then_some("truth"));
        for (name, places) in names.zip(&mut faces) {
            for (axis, place) in places.iter_mut().enumerate().take(S::DIM) {
                *place = store.begin(&format!("{name}_{}", AXES[axis]), given.faces(axis))?;
            }
        }
        Ok(Arrays {
            captured,
            density,
            faces,
        })
    }

    /// One pair of frames.
    fn pair<T: Real, S: Space>(
        &mut self,
        exec: &dyn Exec,
        tracker: &mut Tracker<'_, T, S>,
        arrays: &Arrays,
        store: &mut Store,
    ) -> Result<(), Ending> {
        let clock = Clock::start();
        let index = self.history.len();
        let (mut own, mut failed): (Vec<Vec<T>>, Option<Failure>) = (Vec::new(), None);
        let mut watch = Watch {
            interrupt: &self.interrupt,
            display: &self.display,
        };
        let pair = tracker.step(exec, &mut watch, &mut |part, faces| {
            own.clear();
            for axis in 0..S::DIM {
                let mut values = vec![T::ZERO; faces.len(axis)];
                faces.read(axis, &mut values);
                let place = arrays.faces[part as usize][axis];
                failed = failed.take().or_else(|| store.push(place, &values).err());
                own.push(values);
            }
        });
        let pair = pair.map_err(Ending::Stopped)?;
        failed.map_or(Ok(()), |failure| Err(Ending::Failed(failure)))?;
        store.push(arrays.density, tracker.carried())?;
        let mut truth: Vec<Vec<f64>> = Vec::new();
        if self.planned.given.has_truth() {
            for axis in 0..S::DIM {
                let values = self.planned.given.truth(&self.request.scene, index, axis)?;
                let narrowed: Vec<T> = values.iter().map(|&value| T::from_f64(value)).collect();
                store.push(arrays.faces[3][axis], &narrowed)?;
                truth.push(values);
            }
        }
        let given = &self.planned.given;
        let measure = Measure {
            cells: &given.cells,
            boundary: &given.boundary,
            scale: 1.0 / given.capture([0.0; 3]).velocity_unit(),
        };
        let errors = (!truth.is_empty()).then(|| measure.errors(&own, &truth));
        let record = PairRecord::new(index, clock.total(), &pair, self.planned.params.readvect, errors);
        self.history.push(record);
        self.show();
        Ok(())
    }

    /// Shows the pair that is done, and the time that is left.
    fn show(&self) {
        let Some(record) = self.history.last() else { return };
        if self.display.mode() == Mode::Json {
            let fields = serde_json::to_value(record).unwrap_or_default();
            return self.display.event("pair", fields);
        }
        let (done, all) = (self.history.len(), self.planned.given.pairs);
        let seconds: f64 = self.history.iter().map(|record| record.seconds).sum();
        let left = (all - done) as f64 * seconds / done as f64;
        let kept = record.misfit / record.misfit_predicted.max(f64::MIN_POSITIVE);
        let mut text = format!(
            "{} left, up to {:.2} cells a frame, {:.0} % of the misfit left",
            in_words(left),
            record.fastest,
            100.0 * kept
        );
        if let Some(error) = record.velocity_relative_error {
            text += &format!(", error {error:.3}");
        }
        self.display.piece(done, &text);
    }

    /// Writes the result folder.
    fn finish(
        self,
        destination: &mut Destination,
        store: &mut Store,
        status: Status,
        footprint: usize,
    ) -> Result<u8, Failure> {
        self.display.close();
        let pairs = self.history.len();
        if pairs == 0 {
            return match status {
                Status::Cancelled => {
                    self.display.note("thurible: interrupted before the first pair was done, so there is no result");
                    Ok(INTERRUPTED)
                }
                _ => Err(not_finite(0)),
            };
        }
        store.flush()?;
        let precision = match self.planned.precision {
            problem::Precision::F32 => Precision::F32,
            problem::Precision::F64 => Precision::F64,
        };
        let ended = Ended {
            status,
            seconds: self.request.clock.total(),
            footprint,
            history: self.history,
        };
        let record = TrackRecord::new(&self.request.scene, &self.planned, ended);
        destination.fill(|folder| {
            let count = |name: &str| pairs + usize::from(matches!(name, "captured" | "density"));
            store.pack(&folder.join("result.npz"), precision, count)?;
            write_report(folder, &record)
        })?;
        let result = destination.folder().to_path_buf();
        destination.add(|folder| page::write(&result, folder, &record))?;
        let diverted = destination.diverted().map(str::to_owned);
        announce_end(&self.display, &record, destination);
        if let Some(why) = &diverted {
            console::error(&format!("thurible: {why}"));
        }
        match status {
            _ if diverted.is_some() => Ok(FILE),
            Status::Cancelled => Ok(INTERRUPTED),
            Status::NotFinite => {
                console::error(&format!("thurible: {}", not_finite(pairs)));
                Ok(NOT_FINITE)
            }
            _ => Ok(DONE),
        }
    }
}

/// Why a pair was not done.
enum Ending {
    Stopped(Stop),
    Failed(Failure),
}

impl From<Failure> for Ending {
    fn from(failure: Failure) -> Self {
        Self::Failed(failure)
    }
}

/// The numbers of the arrays in the store; none of those that there are not.
struct Arrays {
    captured: usize,
    density: usize,
    /// Predicted, correction, velocity, truth, by axis.
    faces: [[usize; 3]; 4],
}

fn not_finite(pairs: usize) -> Failure {
    Failure::NotFinite(format!(
        "the flow between frames {pairs} and {} became too fast or not finite; raise track.beta or track.alpha, or track these frames with track.independent = true",
        pairs + 1
    ))
}

fn write_report(folder: &Path, record: &TrackRecord) -> Result<(), OutputError> {
    let path = folder.join("report.json");
    write_whole(&path, |file| {
        serde_json::to_writer_pretty(file, record).map_err(OutputError::of(&path))
    })
}

fn announce_end(display: &Display, record: &TrackRecord, destination: &Destination) {
    let folder = destination.shown();
    display.event(
        "result",
        json!({ "status": record.status.name(), "pairs": record.steps, "seconds": record.seconds,
                "folder": folder.display().to_string() }),
    );
    if display.mode() != Mode::Human {
        return;
    }
    let how = if record.status == Status::Cancelled { "interrupted after" } else { "tracked" };
    console::error(&format!(
        "{how} {} pairs in {}; the result is in {}",
        record.steps,
        in_words(record.seconds),
        folder.display()
    ));
}
