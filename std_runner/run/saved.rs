//! The state of a solve as a checkpoint has it: what the runner remembers, and the solver's own.

use super::earlier::Origin;
use super::inputs::set_obstacles;
use super::job::Job;
use super::request::{Request, RunOptions};
use crate::checkpoint::{
    Begin, Cut, Every, Found, Inputs, Keeper, Needs, Options, PartFiles, Place, Saving, Unsealed, Words,
    damaged, inputs_of, read, report_sum, sums_of,
};
use crate::destination::Destination;
use crate::exit::Failure;
use crate::output::Gallery;
use crate::problem::{OwnedProblem, Precision};
use crate::progress::{Clock, Spent, Watch};
use crate::report::{Facts, IterationRecord, ObjectiveRecord};
use core::time::Duration;
use std::io;
use std::path::Path;
use thurible_core::checkpoint::{Damaged, Refused, Resumable, restore_from, save_to};
use thurible_core::exec::Ranks;
use thurible_core::progress::MAX_FACTS;
use thurible_core::{Fact, Kind, Named, Objective, Real, SavedError, Solver, Space, Status};

/// What is remembered of a solve as a whole, beside its solver.
#[derive(Debug, Default)]
pub(crate) struct Progressed {
    /// By how much each keyframe was scaled to the mass of the source.
    pub mass_factors: Vec<f64>,
    /// How the iterations ended, if they did.
    pub ended: Option<Ended>,
}

/// How iterations ended.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ended(pub Status);

impl Default for Ended {
    fn default() -> Self {
        Self(Status::Converged)
    }
}

impl Progressed {
    /// Passes over it and over what `watch` has seen.
    pub fn record(&mut self, words: &mut Words, watch: &mut Watch) -> Result<(), Damaged> {
        words.reals(&mut self.mass_factors)?;
        words.option(&mut self.ended, |words, ended| words.named(&mut ended.0))?;
        seen(words, watch)
    }
}

/// Passes over what was seen of a solve: the seconds, all iterations, and the window.
fn seen(words: &mut Words, watch: &mut Watch) -> Result<(), Damaged> {
    clock(words, &mut watch.clock)?;
    let empty = IterationRecord {
        iteration: 0,
        window: None,
        seconds: 0.0,
        seconds_left: None,
        objective: Objective::default().into(),
        level: None,
        facts: Facts::default(),
    };
    words.list(&mut watch.history, empty, iteration)?;
    let all = watch.history.len();
    words.option(watch.window(), |words, (number, before)| {
        words.count(number)?;
        words.count(before)?;
        if *before > all { Err(Damaged) } else { Ok(()) }
    })
}

/// Passes over the seconds; the clock goes on from there.
fn clock(words: &mut Words, clock: &mut Clock) -> Result<(), Damaged> {
    let mut total = clock.total();
    words.real(&mut total)?;
    words.real(&mut clock.begun)?;
    words.real(&mut clock.nested)?;
    let reads = words.reads();
    let now = clock.total();
    let (phases, before) = clock.state();
    if reads {
        *before += total - now;
    }
    words.list(phases, ("", Spent::default()), |words, (name, spent)| {
        words.name(name)?;
        let mut seconds = spent.seconds();
        words.real(&mut seconds)?;
        words.count(&mut spent.calls)?;
        if reads {
            spent.time = Duration::try_from_secs_f64(seconds).map_err(|_| Damaged)?;
        }
        Ok(())
    })
}

/// Passes over an iteration.
fn iteration(words: &mut Words, record: &mut IterationRecord) -> Result<(), Damaged> {
    words.count(&mut record.iteration)?;
    words.option(&mut record.window, Words::count)?;
    words.real(&mut record.seconds)?;
    words.option(&mut record.seconds_left, Words::real)?;
    objective(words, &mut record.objective)?;
    words.option(&mut record.level, Words::counts)?;
    let empty = (Fact::new("", Kind::Number, ""), Vec::new());
    words.list(&mut record.facts.0, empty, |words, (fact, values)| {
        words.name(&mut fact.name)?;
        words.name(&mut fact.words)?;
        kind(words, &mut fact.kind)?;
        words.option(&mut fact.chart, |words, chart| words.name(chart))?;
        words.reals(values)
    })?;
    if record.facts.0.len() > MAX_FACTS {
        return Err(Damaged);
    }
    Ok(())
}

fn kind(words: &mut Words, kind: &mut Kind) -> Result<(), Damaged> {
    const ALL: [Kind; 4] = [Kind::Number, Kind::Count, Kind::Flag, Kind::Series];
    let mut place = ALL.iter().position(|one| one == kind).unwrap_or(0);
    words.count(&mut place)?;
    *kind = *ALL.get(place).ok_or(Damaged)?;
    Ok(())
}

/// Passes over an objective.
pub(super) fn objective(words: &mut Words, record: &mut ObjectiveRecord) -> Result<(), Damaged> {
    words.real(&mut record.data)?;
    words.real(&mut record.force)?;
    words.real(&mut record.plain)?;
    words.option(&mut record.initial, Words::real)
}

/// Writes the state of `solver`, which one program has, into a checkpoint.
pub(crate) fn write(solver: &mut dyn Resumable, saving: &mut Saving<'_>) -> Result<(), Refused> {
    save_to(solver, saving.file).map_err(|_| Refused)
}

/// Writes that of a solver that ranks may share.
pub(crate) fn write_shared<T: Real, S: Space>(
    solver: &mut Solver<'_, T, S>,
    saving: &mut Saving<'_>,
) -> Result<(), Refused> {
    let Some(parts) = &mut saving.parts else {
        return write(solver, saving);
    };
    let saved = solver.save_parts(parts);
    if let Some(trouble) = parts.trouble.take() {
        saving.file.trouble = Some(io::Error::other(trouble));
    }
    saved
}

/// A state that is gone on from: what is left to read of it.
pub(crate) struct Reading<'a> {
    found: &'a Found,
    pub words: Words,
    pub file: Unsealed,
}

impl<'a> Reading<'a> {
    /// Opens it.
    pub fn new(found: &'a Found) -> Result<Self, Failure> {
        let (words, file) = read(&found.slot)?;
        Ok(Self { found, words, file })
    }

    /// The failure of a state that is whole and yet not what it should be.
    pub fn damaged(&self) -> Failure {
        damaged(&self.found.slot)
    }

    /// The folder of the state.
    pub fn folder(&self) -> &Path {
        &self.found.place
    }

    /// Hands what was remembered to `so_far` and `watch`, where that is all of it.
    pub fn remember(&mut self, so_far: &mut Progressed, watch: &mut Watch) -> Result<(), Failure> {
        let remembered = so_far.record(&mut self.words, watch);
        let whole = remembered.and_then(|()| self.words.end());
        whole.map_err(|Damaged| self.damaged())
    }

    /// Hands `solver`, which has nothing yet but its solid cells, its state.
    pub fn restore(&mut self, solver: &mut dyn Resumable) -> Result<(), Failure> {
        restore_from(solver, &mut self.file).map_err(|error| self.refusal(error))
    }

    /// The same of a solver that `ranks` may share, or of a state that some did.
    fn restore_shared<T: Real, S: Space>(
        &mut self,
        solver: &mut Solver<'_, T, S>,
        ranks: Option<&'static dyn Ranks>,
    ) -> Result<(), Failure> {
        let (found, solve) = (self.found, &self.found.solve);
        if ranks.is_none() && solve.cut.is_none() {
            return self.restore(solver);
        }
        let name = found.slot.file_name().unwrap_or_default();
        let place = Place {
            number: solve.number,
            slot: name.to_string_lossy().into_owned(),
            begin: self.file.place().map_err(|_| self.damaged())?,
            cut: solve.cut,
            sums: sums_of(found)?,
        };
        let mut parts = PartFiles::new(ranks, self.folder(), place);
        let taken = solver.restore_parts(&mut parts);
        taken.map_err(|error| parts.trouble.map_or_else(|| self.refusal(error), Failure::File))
    }

    fn refusal(&self, error: SavedError) -> Failure {
        match error {
            SavedError::OtherSolve => Failure::Input(format!(
                "the state in {} is of another scene, precision, method or choice than what was kept with it; this is a fault of thurible, please report it",
                self.found.place.display()
            )),
            _ => self.damaged(),
        }
    }
}

impl Request {
    /// The files that the solve begins with, to be looked at before they are read, where states may be kept: it must not go on with others.
    pub fn began_with(&self) -> Option<Inputs> {
        let may_be_kept = self.checkpoint != Every::Off && self.found.is_none();
        let results = [&self.from, &self.reference].into_iter().flatten();
        may_be_kept.then(|| {
            let results: Vec<_> = results.map(Origin::arrays).collect();
            inputs_of(&self.scene.document, &results)
        })
    }
}

/// What is planned of a solve whose states are kept.
pub(crate) struct KeptSolve<'a> {
    /// The word of its method.
    pub method: &'a str,
    pub problem: &'a OwnedProblem,
    pub precision: Precision,
    /// The ceiling that choices were made under.
    pub ceiling: Option<usize>,
    /// Whether what is found grows in files beside the result.
    pub grows: bool,
    /// Bytes of a state.
    pub state: usize,
}

impl KeptSolve<'_> {
    /// What keeps the states of the solve of `request`, into `destination`, which `began_with` these files.
    pub fn keeper(
        &self,
        request: &Request,
        run: &RunOptions,
        destination: &Destination,
        began_with: Option<Inputs>,
    ) -> Result<Keeper, Failure> {
        let origin = |origin: &Origin| (origin.option.to_owned(), origin.folder.clone(), origin.step);
        let arrays = self.result_bytes();
        let (steps, keyframes) = (self.problem.steps, self.problem.keyframes.len());
        let pictures = Gallery::bytes(&self.problem.cells, steps, keyframes, run.outputs.images);
        let options = Options {
            free: request.free.then(|| self.method.to_owned()),
            precision: self.precision.name().into(),
            ceiling: self.ceiling,
            folder: destination.folder().to_owned(),
            shown: request.folder.clone(),
            over: report_sum(destination.folder()),
            images: run.outputs.images,
            from: request.from.as_ref().map(origin),
            reference: request.reference.as_ref().map(origin),
        };
        let shared = run.several().zip(self.problem.share);
        let state = self.state as u64;
        let needs = Needs {
            result: arrays.saturating_add(pictures as u64),
            growing: if self.grows { arrays } else { 0 },
            state: shared.map_or(state, |(_, share)| {
                Cut::from(share).parts_bytes(state, &self.problem.cells)
            }),
        };
        let document = request.scene.document.clone();
        Keeper::new(
            request.checkpoint,
            destination,
            needs,
            (document, options),
            match &request.found {
                Some(found) => Begin::From(found),
                None => Begin::Anew {
                    inputs: began_with,
                    forced: request.forced,
                },
            },
            shared,
        )
    }

    /// About the bytes of `result.npz`: a density, a velocity and a force for each step, and the keyframes.
    fn result_bytes(&self) -> u64 {
        let problem = self.problem;
        let cells: u64 = problem.cells.iter().map(|&count| count as u64).product();
        let fields = (problem.steps + 1 + problem.keyframes.len()) + 2 * problem.cells.len() * problem.steps;
        let number = if self.precision == Precision::F64 { 8 } else { 4 };
        cells.saturating_mul(fields as u64).saturating_mul(number)
    }
}

impl Job {
    /// What keeps the states of the solve, into `destination`, which `began_with` these files.
    pub fn keeper(&self, destination: &Destination, began_with: Option<Inputs>) -> Result<Keeper, Failure> {
        let planned = &self.planned;
        let kept = KeptSolve {
            method: planned.params.method.name(),
            problem: &planned.problem,
            precision: planned.precision,
            ceiling: planned.choosing_ceiling(),
            grows: planned.windows.is_some(),
            state: planned.plan.saved_bytes(),
        };
        kept.keeper(&self.request, &self.options, destination, began_with)
    }

    /// Hands `solver`, which has nothing yet, the state that is read.
    pub fn restore<T: Real, S: Space>(
        &self,
        reading: &mut Reading<'_>,
        solver: &mut Solver<'_, T, S>,
    ) -> Result<(), Failure> {
        set_obstacles(&self.request.scene, solver, &mut Vec::new())?;
        reading.restore_shared(solver, self.options.several())
    }
}
