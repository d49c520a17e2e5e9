//! The steps of a known flow in turn, in one block of memory.

use super::known::{Known, refuse};
use super::page::{self, Record, StepRecord};
use super::place::{Job, problem, solid};
use super::request::Request;
use super::walk::Walk;
use crate::bytes::{self, grouped, rounded};
use crate::destination::Destination;
use crate::exit::{Failure, code_of_result};
use crate::interrupt::Interrupt;
use crate::output::{OutputError, Precision as Written, Store, write_whole};
use crate::plan::size_in_words;
use crate::problem::Precision;
use crate::progress::{Clock, Display, in_words};
use crate::region::{MARGIN, Region, touch};
use crate::report::{ARCHIVE, count};
use crate::{console, run, threads};
use serde_json::json;
use std::path::PathBuf;
use std::time::Instant;
use thurible_core::{Named, Real, Refined, Status};

/// Does what `request` asks for and writes the result folder; the answer is the exit code.
pub(crate) fn run(request: &Request) -> Result<u8, Failure> {
    let clock = Clock::start();
    let mut known = Known::open(&request.from)?;
    if request.at >= known.steps() {
        let last = known.steps().saturating_sub(1);
        let why = format!(
            "has no flow of step {}; --at is a step from 0 to {last}",
            request.at
        );
        return Err(refuse(&request.from, &why));
    }
    let solid = solid(request, &known)?;
    let problem = problem(&known, request, solid.is_some());
    let refinement = request.deed.refinement(request.threads);
    let job = Job {
        request,
        problem,
        refinement,
        solid,
        clock,
    };
    match request.precision.unwrap_or(known.precision) {
        Precision::F32 => job.run::<f32>(&mut known),
        Precision::F64 => job.run::<f64>(&mut known),
    }
}

impl Job<'_> {
    fn run<T: Real>(&self, known: &mut Known) -> Result<u8, Failure> {
        let bytes = self.bytes::<T>()?;
        let mut region = self.region(bytes)?;
        let files = [ARCHIVE, "report.json", "report.html"].map(PathBuf::from);
        let mut destination = Destination::check(&self.request.folder, files.to_vec())?;
        let mut store = Store::new(&destination)?;
        let display = Display::new(self.request.mode, self.problem.steps);
        let (interrupt, footprint) = (Interrupt::listen()?, region.footprint());
        self.announce::<T>(&display, bytes);
        let block = region.carve(bytes).ok_or_else(|| self.no_memory(bytes))?;
        touch(block);
        let mut history = Vec::new();
        let status = threads::with(self.refinement.threads, || -> Result<Status, Failure> {
            let mut walk = Walk::<T>::begin(self, known, block, &mut store)?;
            let begun = Instant::now();
            for step in 0..self.problem.steps {
                if interrupt.asked() {
                    return Ok(Status::Cancelled);
                }
                let Some(record) = walk.step(step)? else {
                    return Ok(Status::NotFinite);
                };
                history.push(record);
                let done = step + 1;
                let left = (self.problem.steps - done) as f64 * begun.elapsed().as_secs_f64() / done as f64;
                display.piece(done, &format!("step {done}, {} left", in_words(left)));
            }
            Ok(Status::Converged)
        })??;
        drop(region);
        let record = self.record::<T>(status, (bytes, footprint), history);
        store.flush()?;
        self.write::<T>(&mut destination, &store, &record)?;
        display.close();
        Ok(ended(&display, &destination, &record))
    }

    /// Takes so many bytes from the system, where the ceiling leaves room for what a region takes beside them.
    fn region(&self, bytes: usize) -> Result<Region, Failure> {
        let limit = self.request.limit.or_else(bytes::of_machine);
        let region = Some(bytes).filter(|bytes| bytes.saturating_add(MARGIN) <= limit.unwrap_or(usize::MAX));
        region.and_then(Region::new).ok_or_else(|| self.no_memory(bytes))
    }

    fn no_memory(&self, bytes: usize) -> Failure {
        Failure::Memory(format!(
            "{} of {}: a step of {} cells takes {} bytes; raise --memory-limit to that, or give a result of fewer cells",
            self.request.deed.name(),
            self.request.from.display(),
            size_in_words(&self.problem.cells),
            grouped(bytes.saturating_add(MARGIN))
        ))
    }

    /// Writes the result folder.
    fn write<T: Real>(
        &self,
        destination: &mut Destination,
        store: &Store,
        record: &Record,
    ) -> Result<(), Failure> {
        let precision = if T::BYTES == size_of::<f64>() {
            Written::F64
        } else {
            Written::F32
        };
        let (steps, planes) = (record.steps, self.problem.cells.last().copied());
        destination.fill(|folder| {
            let count = |name: &str| match name {
                "density" => steps + 1,
                // Its entries are planes.
                "solid" => planes.unwrap_or(0),
                _ => steps,
            };
            store.pack(&folder.join(ARCHIVE), precision, count)?;
            let path = folder.join("report.json");
            write_whole(&path, |file| {
                serde_json::to_writer_pretty(file, record).map_err(OutputError::of(&path))
            })?;
            page::write(folder, record)
        })
    }

    /// Bytes of the block.
    fn bytes<T: Real>(&self) -> Result<usize, Failure> {
        let bytes = Refined::<T>::bytes(&self.problem.problem(), self.refinement);
        bytes.map_err(|error| {
            let name = self.request.deed.name();
            refuse(
                &self.request.from,
                &format!("cannot be taken further by {name}: {error}; give another result"),
            )
        })
    }

    fn announce<T: Real>(&self, display: &Display, bytes: usize) {
        let (name, cells) = (self.request.deed.name(), &self.problem.cells);
        let threads = self.refinement.threads;
        display.event(
            "plan",
            json!({ "command": name, "cells": cells, "steps": self.problem.steps, "bytes": bytes, "precision": T::NAME, "threads": threads }),
        );
        display.note(&format!(
            "{name} of {}: {} cells, {} steps, {} bytes ({}) in {}, whatever the number of steps, {}",
            self.request.from.display(),
            size_in_words(cells),
            self.problem.steps,
            grouped(bytes),
            rounded(bytes),
            T::NAME,
            count(threads, "thread")
        ));
    }

    /// Says in how many steps the flow had not come to rest when it was to give way no longer.
    fn unsettled(&self, history: &[StepRecord]) -> Option<String> {
        let most = self.refinement.weighted?.iterations;
        let steps = history.iter().filter(|step| step.iterations >= most).count();
        (steps > 0).then(|| {
            format!(
                "in {steps} of {} steps the flow gave way for {most} iterations and had not come to rest: it is free of divergence all the same, but changed otherwise than asked for; take a smaller --alpha",
                history.len()
            )
        })
    }

    fn record<T: Real>(&self, status: Status, memory: (usize, usize), history: Vec<StepRecord>) -> Record {
        let priced = self.refinement.weighted.map(|how| how.smoothness);
        Record {
            format: 1,
            kind: self.request.deed.name(),
            cells: self.problem.cells.clone(),
            boundary: self.problem.boundary.clone(),
            length: self.problem.length,
            dt: self.problem.dt,
            steps: history.len(),
            from: self.request.at,
            solid: self.solid.is_some(),
            turbulence: self.refinement.turbulence.map(|given| given.strength),
            seed: self.refinement.turbulence.map(|given| given.seed),
            smoothness: priced.filter(|&alpha| alpha > 0.0),
            advection: self.problem.advection.scheme,
            precision: T::NAME,
            threads: self.refinement.threads,
            version: env!("CARGO_PKG_VERSION"),
            status,
            seconds: self.clock.total(),
            planned_bytes: memory.0,
            used_bytes: memory.1,
            remarks: self.unsettled(&history).into_iter().collect(),
            history,
            keyframes: [],
            command: run::command_line(),
        }
    }
}

/// Says how it ended and where the result is; the exit code.
fn ended(display: &Display, destination: &Destination, record: &Record) -> u8 {
    let shown = destination.shown();
    record.remarks.iter().for_each(|remark| display.warning(remark));
    display.event(
        "result",
        json!({ "folder": shown, "steps": record.steps, "status": record.status.name() }),
    );
    display.note(&format!(
        "result in {}; open {}",
        shown.display(),
        shown.join("report.html").display()
    ));
    let diverted = destination.diverted();
    if let Some(why) = diverted {
        console::error(&format!("thurible: {why}"));
    } else if record.status == Status::NotFinite {
        console::error(&format!(
            "thurible: the flow of step {} is too fast or not finite, and the result ends before it; begin after it by --at, or give a slower flow",
            record.from + record.steps
        ));
    }
    code_of_result(record.status, diverted.is_some())
}
