//! A planned run in its block of memory: set up or gone on with, written, reported.

use super::inputs::{self, Inputs};
use super::plan::Planned;
use super::record::{self, Known};
use super::written;
use crate::bytes::{grouped, rounded};
use crate::checkpoint::{Inputs as Files, Keeper, Words};
use crate::destination::Destination;
use crate::exit::Failure;
use crate::output::{Sample, Store};
use crate::plan::size_in_words;
use crate::problem::Precision;
use crate::progress::{Display, Watch};
use crate::region::{Region, touch};
use crate::report::{self, RunRecord, count};
use crate::run::inputs::solver_refusal;
use crate::run::job::Solved;
use crate::run::messages::{self, no_memory, not_finite};
use crate::run::saved::{self, Ended, KeptSolve, Progressed, Reading};
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
pub(super) struct Run {
    options: RunOptions,
    request: Request,
    pub planned: Planned,
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
        let began_with = self.request.began_with();
        let reading = self.request.found.as_ref().map(Reading::new).transpose()?;
        let inputs = match &reading {
            Some(_) => Inputs::default(),
            None => inputs::set(scene, &mut fluids)?,
        };
        let files = report::files(self.planned.problem.steps, self.options.outputs.images);
        let mut destination = Destination::check(&self.request.folder, files)?;
        let mut keeper = self.keeper(&destination, began_with)?;
        let store = Store::new(&destination)?;
        let mut watch = self.watch()?;
        self.announce(&watch.display);
        inputs.notes.iter().for_each(|note| watch.display.file_note(note));
        let mut so_far = Progressed {
            mass_factors: inputs.mass_factors,
            ended: None,
        };
        match reading {
            Some(mut reading) => {
                reading.remember(&mut so_far, &mut watch)?;
                reading.restore(&mut fluids)?;
                messages::goes_on(&watch.display, reading.folder(), &watch);
            }
            None => watch.clock.begin(),
        }
        let ended = self.search(exec, &mut fluids, &mut so_far, (&mut watch, &mut keeper));
        watch.clock.solved();
        if ended == Status::NotFinite && watch.history.is_empty() {
            watch.display.close();
            keeper.forget();
            return Err(not_finite(scene));
        }
        // What was cut off goes on.
        so_far.ended = (ended != Status::Cancelled).then_some(Ended(ended));
        let mut words = Words::default();
        let remembered = so_far.record(&mut words, &mut watch);
        let written = self.write(
            exec,
            &mut fluids,
            (&so_far.mass_factors, ended),
            &mut watch,
            (store, &mut destination),
        );
        match written {
            Ok(record) => Ok(Solved {
                destination,
                record,
                watch,
                keeper: Some(keeper),
            }),
            Err(failure) => {
                watch.display.close();
                let how = (ended == Status::Cancelled, true);
                let kept = remembered
                    .ok()
                    .and_then(|()| keeper.keep_end(how, &words, &mut |file| saved::write(&mut fluids, file)));
                Err(messages::unwritten(failure, kept.as_deref()))
            }
        }
    }

    /// Writes the result, by one run forward, and its record.
    fn write<T: Real + Sample, S: Space>(
        &self,
        exec: &dyn Exec,
        fluids: &mut Fluids<'_, T, S>,
        (mass_factors, ended): (&[f64], Status),
        watch: &mut Watch,
        (mut store, destination): (Store, &mut Destination),
    ) -> Result<RunRecord, Failure> {
        watch.display.detail(format_args!("writing the result"));
        let scene = &self.request.scene;
        let seen = written::write(fluids, exec, scene, mass_factors, &mut store)?;
        watch.clock.finished();
        let known = Known {
            scene,
            planned: &self.planned,
            footprint: self.footprint,
            mass_factors,
            folder: destination.folder(),
        };
        let record = record::of(&known, fluids, exec, &seen, ended, watch);
        let result = destination.folder().to_path_buf();
        destination.fill(|folder| written::pack(&store, (folder, &result), &record, T::PRECISION))?;
        Ok(record)
    }

    /// What keeps the states of the search, into `destination`. What is kept for the way back changes no bit, so that a state knows no ceiling.
    fn keeper(&self, destination: &Destination, began_with: Option<Files>) -> Result<Keeper, Failure> {
        let planned = &self.planned;
        let kept = KeptSolve {
            method: NAME,
            problem: &planned.problem,
            precision: planned.precision,
            ceiling: None,
            grows: false,
            state: planned.plan.saved_bytes(),
        };
        kept.keeper(&self.request, &self.options, destination, began_with)
    }

    fn watch(&self) -> Result<Watch, Failure> {
        let most = self.planned.params.iterations;
        self.request.watched(self.options.mode, [most, most])
    }

    /// Says what is going to be done, and in how many bytes.
    fn announce(&self, display: &Display) {
        let planned = &self.planned;
        display.event("plan", planned.fields());
        let kept = match planned.params.slots.states() {
            0 => String::new(),
            slots => format!(", {slots} states kept, {} steps repeated", planned.repeated()),
        };
        display.note(&format!(
            "{} by {NAME}: {} cells, {} steps, {} bytes ({}) in {}, {}{kept}",
            self.request.scene.document.path().display(),
            size_in_words(&planned.problem.cells),
            planned.problem.steps,
            grouped(planned.plan.bytes()),
            rounded(planned.plan.bytes()),
            planned.precision.name(),
            count(planned.params.threads, "thread")
        ));
    }
}
