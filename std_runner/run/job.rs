//! A planned solve in its block of memory: solve, make feasible, write, report.

use super::found::Found;
use super::frames::SolverFrames;
use super::inputs::{Inputs, set_inputs, solver_refusal};
use super::masses;
use super::messages::{self, no_memory, not_finite};
use super::outcome::{Facts, Outcome};
use super::request::{Request, RunOptions};
use super::settled::Settled;
use crate::destination::Destination;
use crate::exit::Failure;
use crate::interrupt::Interrupt;
use crate::output::{Gallery, Sample};
use crate::plan::Planned;
use crate::problem::Precision;
use crate::progress::{Display, Watch, history_bytes};
use crate::region::{Region, touch};
use crate::report::{self, RunRecord};
use crate::{bytes, threads};
use core::mem::MaybeUninit;
use std::path::Path;
use thurible_core::{D2, D3, Exec, Real, Solver, Space, Status};

/// A given v_0 that projection changes by more than this is worth a warning.
const DIVERGENT: f64 = 1e-6;

/// Estimated bytes beside the block: stack, buffers of files and the scene.
const BESIDE: usize = 256 << 10;
/// Fields in double precision that exist while a shape is drawn.
const FIELDS: usize = 2;

/// Bytes of the densities of all steps.
fn densities_bytes(planned: &Planned) -> usize {
    let number = match planned.precision {
        Precision::F32 => size_of::<f32>(),
        Precision::F64 => size_of::<f64>(),
    };
    number * (planned.problem.steps + 1) * planned.problem.cells.iter().product::<usize>()
}

/// A solve that is ready to run.
pub(super) struct Job {
    pub options: RunOptions,
    pub request: Request,
    pub planned: Planned,
    /// Bytes that the block takes from the system.
    pub footprint: usize,
}

/// A solve that is over, its arrays and its report written.
pub(crate) struct Solved {
    pub destination: Destination,
    pub record: RunRecord,
    pub watch: Watch,
}

impl Solved {
    /// Draws the pictures and the page, and says how it ended.
    pub fn show(mut self, options: &RunOptions) -> Result<Outcome, Failure> {
        let gallery = self.draw(options)?;
        if !options.outputs.arrays {
            // Pictures are drawn from them; now they can go.
            self.destination.remove(report::ARCHIVE)?;
        }
        let Self {
            destination,
            record,
            watch,
        } = self;
        messages::result(options.mode, &watch, &record, &destination);
        Ok(Outcome {
            record,
            gallery,
            diverted: destination.diverted().is_some(),
        })
    }

    /// Draws the pictures and the page; the page alone if there is no memory for pictures.
    fn draw(&mut self, options: &RunOptions) -> Result<Gallery, Failure> {
        let Self {
            destination,
            record,
            watch,
        } = self;
        let result = destination.folder().to_path_buf();
        let draw = |aside: &Path| report::draw(&result, aside, record, options.outputs.images);
        let drawn = destination.add(draw);
        watch.display.close();
        let gallery = drawn.map_err(|error| {
            Failure::File(format!(
                "{error}; result.npz and report.json are in {}",
                destination.shown().display()
            ))
        })?;
        if gallery.is_none() {
            watch.display.warning("the system has not the memory to draw pictures, so there are none; result.npz, report.json and the page are there");
        }
        Ok(gallery.unwrap_or_default())
    }
}

impl Job {
    /// Takes the memory of a planned solve, and makes sure that there is enough beside it.
    pub fn new(options: RunOptions, request: Request, planned: Planned) -> Result<(Self, Region), Failure> {
        let bytes = planned.plan.bytes();
        let beside = BESIDE
            + FIELDS * size_of::<f64>() * planned.problem.cells.iter().product::<usize>()
            + history_bytes(planned.most_iterations())
            + request.settled.map_or(0, |_| densities_bytes(&planned));
        let region = Region::new(bytes)
            .filter(|_| bytes::are_free(beside))
            .ok_or_else(|| no_memory(bytes))?;
        let job = Self {
            options,
            request,
            planned,
            footprint: region.footprint(),
        };
        Ok((job, region))
    }

    /// Solves in `region`, and draws pictures when it has been given back.
    pub fn run(&self, mut region: Region) -> Result<Outcome, Failure> {
        let bytes = self.planned.plan.bytes();
        let block = region.carve(bytes).ok_or_else(|| no_memory(bytes))?;
        touch(block);
        let solved = threads::together(self.planned.params.threads, |exec| self.dispatch(exec, block))?;
        drop(region);
        solved.show(&self.options)
    }

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
        if self.planned.windows.is_some() {
            return self.solve_in_windows::<T, S>(exec, block);
        }
        let masses = masses::of_a_free_flow::<T, S>(&self.request.scene, &self.planned, exec, block)?;
        let problem = self.planned.problem.problem();
        let mut solver = Solver::<T, S>::new(&problem, &self.planned.params, block)
            .map_err(|error| solver_refusal(&error))?;
        let inputs = self.set_inputs(&mut solver, masses.as_deref())?;
        let files = report::files(self.planned.problem.steps, self.options.outputs.images);
        let mut destination = Destination::check(&self.request.folder, files)?;
        let mut watch = self.watch()?;
        messages::plan(&watch.display, &self.request.scene, &self.planned);
        inputs.notes.iter().for_each(|note| watch.display.file_note(note));
        self.prepare(&mut solver, exec, &watch)?;
        watch.clock.begin();
        let mut settled = self.request.settled.map(Settled::new);
        let ended = iterate(&mut solver, exec, &mut watch, settled.as_mut());
        watch.clock.solved();
        watch
            .display
            .detail(format_args!("making the result feasible and writing it"));
        if ended == Status::NotReady || solver.finish(exec).is_err() {
            watch.display.close();
            return Err(not_finite(&self.request.scene));
        }
        watch.clock.finished();
        let facts = Facts {
            scene: &self.request.scene,
            planned: &self.planned,
            problem: &self.planned.problem,
            footprint: self.footprint,
            mass_factors: &inputs.mass_factors,
            folder: destination.folder(),
        };
        let found = Found::of(&solver, &self.planned.problem);
        let mut record = facts.record(found, ended, &mut watch);
        if let Some(truth) = self.request.reference.as_ref().or(self.request.from.as_ref()) {
            // A density that cannot be read is no reason to lose what was found.
            match truth.compare(&self.request.scene, &solver) {
                Ok(frames) => record.frames = frames,
                Err(failure) => record.remarks.push(format!("It is not compared: {failure}.")),
            }
        }
        let mut frames = SolverFrames::new(&mut solver, exec, &self.planned.problem);
        destination.fill(|folder| report::write_numbers(folder, &mut frames, &record))?;
        Ok(Solved {
            destination,
            record,
            watch,
        })
    }

    /// Hands the solver what it starts from.
    fn set_inputs<T: Real, S: Space>(
        &self,
        solver: &mut Solver<'_, T, S>,
        masses: Option<&[f64]>,
    ) -> Result<Inputs, Failure> {
        let scene = &self.request.scene;
        let inputs = match &self.request.from {
            Some(from) => from.begin(scene, solver, None)?,
            None => set_inputs(scene, solver, masses)?,
        };
        if let Some(reference) = &self.request.reference {
            reference.guide(scene, solver)?;
        }
        Ok(inputs)
    }

    pub(super) fn watch(&self) -> Result<Watch, Failure> {
        let interrupt = self
            .request
            .interrupt
            .clone()
            .map_or_else(Interrupt::listen, Ok)?;
        let display = Display::new(self.options.mode, self.planned.params.iterations);
        let most = self.planned.most_iterations();
        Ok(Watch::new(self.request.clock.clone(), display, most, interrupt))
    }

    /// Projects v_0 and warns if it needed that.
    pub(super) fn prepare<T: Real, S: Space>(
        &self,
        solver: &mut Solver<'_, T, S>,
        exec: &dyn Exec,
        watch: &Watch,
    ) -> Result<(), Failure> {
        let changed = solver.prepare(exec).map_err(|error| {
            self.request.scene.document.refuse(
                "source",
                format!("or a keyframe cannot be used: {error}; change it"),
            )
        })?;
        if changed > DIVERGENT {
            let text = format!(
                "the initial velocity was not divergence-free; projecting it changed it by {changed:.1e} of its largest value"
            );
            watch.display.warning(&text);
        }
        Ok(())
    }
}

/// Iterates to the end, and records what is heard of it.
pub(super) fn iterate<T: Real, S: Space>(
    solver: &mut Solver<'_, T, S>,
    exec: &dyn Exec,
    watch: &mut Watch,
    mut settled: Option<&mut Settled<T>>,
) -> Status {
    loop {
        let progress = solver.step(exec, watch);
        // An iteration that was interrupted, or left the finite numbers, has no objective.
        if !matches!(progress.status, Some(Status::Cancelled | Status::NotFinite)) {
            watch.iteration(&progress);
        }
        if let Some(status) = progress.status {
            return status;
        }
        if settled.as_mut().is_some_and(|rule| rule.after_iteration(solver)) {
            return Status::Converged;
        }
    }
}
