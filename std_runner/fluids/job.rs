//! A planned run in its block of memory: search, write, report.

use super::inputs;
use super::plan::Planned;
use super::record::{self, Known};
use super::written;
use crate::bytes::{grouped, rounded};
use crate::checkpoint::make_way;
use crate::destination::Destination;
use crate::exit::Failure;
use crate::output::{Sample, Store};
use crate::plan::size_in_words;
use crate::problem::Precision;
use crate::progress::{Display, Watch};
use crate::region::{Region, touch};
use crate::report;
use crate::run::inputs::solver_refusal;
use crate::run::job::Solved;
use crate::run::messages::{no_memory, not_finite};
use crate::run::{Outcome, Request, RunOptions};
use crate::threads;
use core::mem::MaybeUninit;
use thurible_core::stable_fluids::NAME;
use thurible_core::{D2, D3, Exec, Fluids, Real, Space, Status};

/// A run that is ready.
pub(super) struct Job {
    options: RunOptions,
    request: Request,
    planned: Planned,
    region: Region,
}

impl Job {
    /// Takes the memory of a plan.
    pub fn new(options: RunOptions, request: Request, planned: Planned) -> Result<Self, Failure> {
        let bytes = planned.plan.bytes();
        let region = Region::new(bytes).ok_or_else(|| no_memory(bytes))?;
        Ok(Self {
            options,
            request,
            planned,
            region,
        })
    }

    /// Searches or simulates, writes, and draws pictures when the block has been given back.
    pub fn run(self) -> Result<Outcome, Failure> {
        let Self {
            options,
            request,
            planned,
            mut region,
        } = self;
        let (bytes, footprint) = (planned.plan.bytes(), region.footprint());
        let block = region.carve(bytes).ok_or_else(|| no_memory(bytes))?;
        touch(block);
        let run = Run {
            options,
            request,
            planned,
            footprint,
        };
        let threads = run.planned.params.threads;
        let solved = threads::together(threads, |exec| run.dispatch(exec, block))?;
        drop(region);
        solved.show(&options)
    }
}

/// What a run is made of, its block aside.
struct Run {
    options: RunOptions,
    request: Request,
    planned: Planned,
    footprint: usize,
}

impl Run {
    fn dispatch(&self, exec: &dyn Exec, block: &mut [MaybeUninit<u8>]) -> Result<Solved, Failure> {
        match (self.planned.problem.cells.len(), self.planned.precision) {
            (2, Precision::F32) => self.solve::<f32, D2>(exec, block),
            (2, Precision::F64) => self.solve::<f64, D2>(exec, block),
            (_, Precision::F32) => self.solve::<f32, D3>(exec, block),
            (_, Precision::F64) => self.solve::<f64, D3>(exec, block),
        }
    }

    fn solve<T: Real + Sample, S: Space>(
        &self,
        exec: &dyn Exec,
        block: &mut [MaybeUninit<u8>],
    ) -> Result<Solved, Failure> {
        let scene = &self.request.scene;
        let problem = self.planned.problem.problem();
        let mut fluids = Fluids::<T, S>::new(&problem, &self.planned.params, block)
            .map_err(|error| solver_refusal(&error))?;
        let inputs = inputs::set(scene, &mut fluids)?;
        let files = report::files(self.planned.problem.steps, self.options.outputs.images);
        let mut destination = Destination::check(&self.request.folder, files)?;
        make_way(destination.folder(), self.request.forced)?;
        let mut store = Store::new(&destination)?;
        let mut watch = self.watch()?;
        self.announce(&watch.display);
        inputs.notes.iter().for_each(|note| watch.display.file_note(note));
        watch.clock.begin();
        let ended = if self.planned.params.controls.is_empty() {
            Status::Converged
        } else {
            search(&mut fluids, exec, &mut watch)
        };
        watch.clock.solved();
        if ended == Status::NotFinite && watch.history.is_empty() {
            watch.display.close();
            return Err(not_finite(scene));
        }
        watch.display.detail(format_args!("writing the result"));
        let seen = written::write(&mut fluids, exec, scene, &inputs.mass_factors, &mut store)?;
        watch.clock.finished();
        let known = Known {
            scene,
            planned: &self.planned,
            footprint: self.footprint,
            mass_factors: &inputs.mass_factors,
            folder: destination.folder(),
        };
        let record = record::of(&known, &mut fluids, exec, &seen, ended, &mut watch);
        destination.fill(|folder| written::pack(&store, folder, &record, T::PRECISION))?;
        Ok(Solved {
            destination,
            record,
            watch,
            keeper: None,
        })
    }

    fn watch(&self) -> Result<Watch, Failure> {
        let most = self.planned.params.iterations;
        self.request.watched(self.options.mode, [most, most])
    }

    /// Says what is going to be done, and in how many bytes.
    fn announce(&self, display: &Display) {
        let planned = &self.planned;
        display.event("plan", planned.fields());
        let kept = match planned.slots() {
            0 => String::new(),
            slots => format!(", {slots} states kept, {} steps repeated", planned.repeated()),
        };
        display.note(&format!(
            "{} by {NAME}: {} cells, {} steps, {} bytes ({}) in {}, {} threads{kept}",
            self.request.scene.document.path().display(),
            size_in_words(&planned.problem.cells),
            planned.problem.steps,
            grouped(planned.plan.bytes()),
            rounded(planned.plan.bytes()),
            planned.precision.name(),
            planned.params.threads
        ));
    }
}

/// Iterates to the end, and records what is heard of it.
fn search<T: Real, S: Space>(fluids: &mut Fluids<'_, T, S>, exec: &dyn Exec, watch: &mut Watch) -> Status {
    loop {
        let progress = fluids.step(exec, watch);
        if !matches!(progress.status, Some(Status::Cancelled | Status::NotFinite)) {
            watch.iteration(&progress);
        }
        if let Some(status) = progress.status {
            return status;
        }
    }
}
