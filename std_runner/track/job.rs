//! A planned capture in its block of memory: track, write, report.

use super::arrays::{Arrays, give_initial_velocity};
use super::ending;
use super::errors::Measure;
use super::plan::Planned;
use super::record::{Ended, PairRecord};
use super::scene::CaptureScene;
use crate::bytes::{grouped, rounded};
use crate::destination::Destination;
use crate::exit::Failure;
use crate::interrupt::Interrupt;
use crate::output::Store;
use crate::plan::size_in_words;
use crate::progress::{Clock, Display, Mode};
use crate::region::{Region, touch};
use crate::report::count;
use crate::{problem, threads};
use core::mem::MaybeUninit;
use core::ops::ControlFlow;
use serde_json::json;
use std::path::PathBuf;
use thurible_core::track::Part;
use thurible_core::transport::Stop;
use thurible_core::{D2, D3, Event, Exec, Named, Observer, Real, Space, Status, Tracker};

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
        job.display.close();
        let ended = Ended {
            status,
            seconds: request.clock.total(),
            footprint,
            history: job.history,
        };
        ending::finish(
            (&request.scene, &job.planned, &job.display),
            (&mut destination, &mut store),
            ended,
        )
    }

    /// Says what is going to be tracked, and what was found.
    fn announce(&self) {
        let Planned {
            given,
            plan,
            params,
            precision,
            ..
        } = &self.planned;
        self.display.event(
            "plan",
            json!({ "cells": given.cells, "pairs": given.pairs, "precision": precision.name(), "threads": params.threads,
                    "method": params.flow.minimiser.name(), "bytes": plan.bytes() }),
        );
        self.display.note(&format!(
            "{} by {}: {} cells, {} frames, {} bytes ({}) in {}, {}",
            self.request.scene.document.path().display(),
            params.flow.minimiser.name(),
            size_in_words(&given.cells),
            given.pairs + 1,
            grouped(plan.bytes()),
            rounded(plan.bytes()),
            precision.name(),
            count(params.threads, "thread")
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
        let refused =
            |error: &dyn core::fmt::Display| Failure::Input(format!("the capture is refused: {error}"));
        let mut tracker =
            Tracker::<T, S>::new(&capture, &self.planned.params, block).map_err(|error| refused(&error))?;
        give_initial_velocity(&self.request.scene, &mut tracker)?;
        let arrays = Arrays::begin::<S>(&self.planned, store)?;
        for index in 0..=self.planned.given.pairs {
            let frame = self.planned.given.frame(&self.request.scene, index)?;
            let frame: Vec<T> = frame.into_iter().map(T::from_f64).collect();
            store.push(arrays.captured, &frame)?;
            let made = match index.checked_sub(1) {
                Some(pair) => self.planned.given.emission(&self.request.scene, pair)?,
                None => None,
            };
            let made = made.map(|made| made.into_iter().map(T::from_f64).collect::<Vec<T>>());
            let taken = match &made {
                None => tracker.give(exec, &frame),
                Some(made) => {
                    store.push(arrays.emission, made)?;
                    tracker.give_with_emission(exec, &frame, made)
                }
            };
            taken.map_err(|error| refused(&error))?;
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
            for axis in 0..S::DIM {
                let mut values = vec![T::ZERO; faces.len(axis)];
                faces.read(axis, &mut values);
                let place = arrays.faces[part as usize][axis];
                failed = failed.take().or_else(|| store.push(place, &values).err());
                if part == Part::Velocity {
                    own.push(values);
                }
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
                store.push(arrays.truth[axis], &narrowed)?;
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
        ending::show(&self.display, &self.history, self.planned.given.pairs);
        Ok(())
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
