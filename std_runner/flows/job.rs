//! The steps of a known flow in turn, in one block of memory.

use super::importance::{distances, importance};
use super::known::{Known, refuse};
use super::measure::{apart, changes};
use super::page::{self, Record, StepRecord};
use super::place::{problem, solid};
use super::request::{Deed, Request};
use crate::bytes::{self, rounded};
use crate::destination::Destination;
use crate::exit::{DONE, Failure, INTERRUPTED, NOT_FINITE};
use crate::interrupt::Interrupt;
use crate::output::{Precision as Written, Store, write_whole};
use crate::owned::OwnedProblem;
use crate::plan::size_in_words;
use crate::problem::Precision;
use crate::progress::{Clock, Display};
use crate::region::{MARGIN, Region, touch};
use crate::{run, threads};
use core::mem::MaybeUninit;
use serde_json::json;
use std::path::PathBuf;
use thurible_core::{Boundary, Named, Real, Refined, Refinement, Silent, Status};

const AXES: [&str; 3] = ["x", "y", "z"];

/// Does what `request` asks for and writes the result folder; the answer is the exit code.
pub(crate) fn run(request: &Request) -> Result<u8, Failure> {
    let clock = Clock::start();
    let mut known = Known::open(&request.from)?;
    if request.at >= known.steps {
        let last = known.steps.saturating_sub(1);
        let why = format!(
            "has no flow of step {}; --at is a step from 0 to {last}",
            request.at
        );
        return Err(refuse(&request.from, &why));
    }
    let scale = request.deed.scale();
    if scale > 1 && known.emits() {
        let why = format!(
            "has emitters, which are drawn again by `thurible render --scale {scale}`; leave --scale out"
        );
        return Err(refuse(&request.from, &why));
    }
    let solid = solid(request, &mut known)?;
    let problem = problem(&known, request, solid.is_some());
    let refinement = Refinement {
        doublings: scale.checked_ilog2().map_or(0, |doublings| doublings as usize),
        weighted: matches!(request.deed, Deed::Remap { weighted: true, .. }),
        threads: request.threads,
    };
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

/// What is going to be done.
struct Job<'a> {
    request: &'a Request,
    problem: OwnedProblem,
    refinement: Refinement,
    solid: Option<Vec<bool>>,
    clock: Clock,
}

/// The numbers of the arrays of a store.
struct Arrays {
    density: usize,
    velocity: Vec<usize>,
}

impl Job<'_> {
    fn run<T: Real>(&self, known: &mut Known) -> Result<u8, Failure> {
        let bytes = self.bytes::<T>()?;
        let all = bytes.saturating_add(MARGIN);
        let no_memory = || {
            Failure::Memory(format!(
                "{} of {}: a step of {} cells takes {}; raise --memory-limit, or give a result of fewer cells",
                self.request.deed.name(),
                self.request.from.display(),
                size_in_words(&self.problem.cells),
                rounded(all)
            ))
        };
        let limit = self
            .request
            .limit
            .or_else(bytes::of_machine)
            .unwrap_or(usize::MAX);
        if all > limit {
            return Err(no_memory());
        }
        let mut region = Region::new(all).ok_or_else(no_memory)?;
        let files = ["result.npz", "report.json", "report.html"].map(PathBuf::from);
        let mut destination = Destination::check(&self.request.folder, files.to_vec())?;
        let mut store = Store::new(&destination)?;
        let mut display = Display::new(self.request.mode, self.problem.steps);
        let (interrupt, footprint) = (Interrupt::listen()?, region.footprint());
        self.announce::<T>(&display, bytes);
        let block = region.carve(bytes).ok_or_else(no_memory)?;
        touch(block);
        let mut history = Vec::new();
        let arrays = self.arrays::<T>(&mut store)?;
        let status = threads::with(self.refinement.threads, || {
            self.steps::<T>(
                known,
                block,
                (&arrays, &mut store),
                &mut history,
                (&mut display, &interrupt),
            )
        })??;
        drop(region);
        let record = self.record::<T>(status, (bytes, footprint), history);
        store.flush()?;
        let steps = record.steps;
        let precision = if T::BYTES == size_of::<f64>() {
            Written::F64
        } else {
            Written::F32
        };
        let planes = self.problem.cells.last().copied().unwrap_or(0);
        destination.fill(|folder| {
            let count = |name: &str| match name {
                "density" => steps + 1,
                "solid" => planes,
                _ => steps,
            };
            store.pack(&folder.join("result.npz"), precision, count)?;
            let path = folder.join("report.json");
            write_whole(&path, |file| {
                serde_json::to_writer_pretty(file, &record).map_err(crate::output::OutputError::of(&path))
            })?;
            page::write(folder, &record)
        })?;
        display.close();
        let shown = destination.shown();
        display.event(
            "result",
            json!({ "folder": shown, "steps": steps, "status": record.status.name() }),
        );
        display.note(&format!(
            "result in {}; open {}",
            shown.display(),
            shown.join("report.html").display()
        ));
        Ok(match status {
            Status::Cancelled => INTERRUPTED,
            Status::NotFinite => NOT_FINITE,
            _ => DONE,
        })
    }

    /// Whether the flow gets other solid cells.
    fn remaps(&self) -> bool {
        matches!(self.request.deed, Deed::Remap { .. })
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
            "{name} of {}: {} cells, {} steps, {} bytes ({}) in {}, whatever the number of steps, {threads} threads",
            self.request.from.display(),
            size_in_words(cells),
            self.problem.steps,
            bytes::grouped(bytes),
            rounded(bytes),
            T::NAME
        ));
    }

    /// Begins the arrays of the result, and writes that of the solid cells, whose entries are planes.
    fn arrays<T: Real>(&self, store: &mut Store) -> Result<Arrays, Failure> {
        let shape = |more: Option<usize>| {
            let mut shape = self.problem.cells.clone();
            if let Some(axis) = more {
                shape[axis] += usize::from(self.problem.boundary[axis] != Boundary::Periodic);
            }
            shape.reverse();
            shape
        };
        if let Some(solid) = &self.solid {
            let plane = shape(None).get(1..).unwrap_or(&[]).to_vec();
            let array = store.begin("solid", plane)?;
            let solid: Vec<T> = solid
                .iter()
                .map(|&solid| T::from_f64(f64::from(u8::from(solid))))
                .collect();
            store.push(array, &solid)?;
        }
        let density = store.begin("density", shape(None))?;
        let axes = AXES.iter().take(self.problem.cells.len()).enumerate();
        let velocity = axes.map(|(axis, name)| store.begin(&format!("velocity_{name}"), shape(Some(axis))));
        Ok(Arrays {
            density,
            velocity: velocity.collect::<Result<_, _>>()?,
        })
    }

    /// Takes every step; how it ended.
    fn steps<T: Real>(
        &self,
        known: &mut Known,
        block: &mut [MaybeUninit<u8>],
        (arrays, store): (&Arrays, &mut Store),
        history: &mut Vec<StepRecord>,
        (display, interrupt): (&mut Display, &Interrupt),
    ) -> Result<Status, Failure> {
        let unusable = |error: &dyn core::fmt::Display| {
            refuse(
                &self.request.from,
                &format!("has a step that cannot be used: {error}; make it again"),
            )
        };
        let refined = Refined::<T>::carve(&self.problem.problem(), self.refinement, block);
        let mut refined = refined.map_err(|error| unusable(&error))?;
        if let Some(solid) = &self.solid {
            refined.set_solids(solid).map_err(|error| unusable(&error))?;
        }
        let squared = self
            .solid
            .as_ref()
            .map(|solid| distances(&self.problem.cells, &self.problem.boundary, solid));
        refined
            .set_density(&self.source(known)?)
            .map_err(|error| unusable(&error))?;
        store.push(arrays.density, refined.density())?;
        let mut means = vec![T::ZERO; known.cells.iter().product()];
        for step in 0..self.problem.steps {
            if interrupt.asked() {
                return Ok(Status::Cancelled);
            }
            let begun = self.clock.total();
            let now = self.request.at + step;
            let smoke = known.smoke(now)?;
            if let (Some(squared), true) = (&squared, self.refinement.weighted) {
                let importance: Vec<T> = importance(&smoke, squared).into_iter().map(T::from_f64).collect();
                refined
                    .set_importance(&importance)
                    .map_err(|error| unusable(&error))?;
            }
            let mut given = Vec::new();
            for axis in 0..known.cells.len() {
                let faces: Vec<T> = known.flow(axis, now)?.into_iter().map(T::from_f64).collect();
                refined
                    .set_velocity(axis, &faces)
                    .map_err(|error| unusable(&error))?;
                given.push(faces);
            }
            let went = threads::together(self.refinement.threads, |exec| refined.advance(exec, &mut Silent));
            if went.is_err() {
                return Ok(Status::NotFinite);
            }
            if let Some(emission) = known.emission(now)? {
                let emission: Vec<T> = emission.into_iter().map(T::from_f64).collect();
                refined.add(&emission).map_err(|error| unusable(&error))?;
            }
            let mut flow = Vec::new();
            for (axis, &array) in arrays.velocity.iter().enumerate() {
                let mut faces = vec![T::ZERO; refined.faces(axis)];
                refined
                    .velocity(axis, &mut faces)
                    .map_err(|error| unusable(&error))?;
                store.push(array, &faces)?;
                flow.push(faces);
            }
            store.push(arrays.density, refined.density())?;
            threads::together(self.refinement.threads, |exec| refined.means(exec, &mut means));
            let truth = if now + 1 < known.density.count() {
                Some(known.smoke(now + 1)?)
            } else {
                None
            };
            history.push(StepRecord {
                step: step + 1,
                frame: now + 1,
                seconds: self.clock.total() - begun,
                relative_l2: truth.map(|truth| apart(&means, &truth)),
                changed: self
                    .remaps()
                    .then(|| changes(&self.problem, &given, &flow, &smoke)),
            });
            display.piece(step + 1, &format!("step {}", step + 1));
        }
        Ok(Status::Converged)
    }

    /// The density to begin with, on the cells that it goes to.
    fn source<T: Real>(&self, known: &mut Known) -> Result<Vec<T>, Failure> {
        let at = self.request.at;
        let scale = self.request.deed.scale();
        let smoke = known.smoke(at)?;
        let smoke = if scale == 1 {
            smoke
        } else {
            known.finer(&smoke, scale)
        };
        Ok(smoke.into_iter().map(T::from_f64).collect())
    }

    fn record<T: Real>(&self, status: Status, memory: (usize, usize), history: Vec<StepRecord>) -> Record {
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
            advection: self.problem.advection.scheme,
            precision: T::NAME,
            threads: self.refinement.threads,
            version: env!("CARGO_PKG_VERSION"),
            status,
            seconds: self.clock.total(),
            planned_bytes: memory.0,
            used_bytes: memory.1,
            history,
            keyframes: [],
            command: run::command_line(),
        }
    }
}
