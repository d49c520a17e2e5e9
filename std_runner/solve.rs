//! `thurible solve SCENE`: plan, allocate once, solve, make feasible, write.

use crate::cli::SolveArguments;
use crate::console;
use crate::destination::Destination;
use crate::exit::{Failure, code_of};
use crate::frames::SolverFrames;
use crate::inputs::{hand_on, hand_over, solver_refusal};
use crate::interrupt::Interrupt;
use crate::job::Job;
use crate::output::{Gallery, Sample};
use crate::plan::{self, Wishes, plan_fields, size_in_words};
use crate::problem::Precision;
use crate::progress::{Clock, Display, Mode, Watch, history_bytes, in_words};
use crate::region::{Region, touch};
use crate::report::RunRecord;
use crate::scene::Scene;
use crate::{address_space, bytes, outcome, report, threads};
use core::mem::MaybeUninit;
use serde_json::json;
use std::fs;
use std::path::{Path, PathBuf};
use thurible_core::{D2, D3, Exec, Named, Real, Solver, Space, Status};

/// A given v_0 that projection changes by more than this is worth a warning.
const DIVERGENT: f64 = 1e-6;

/// Bytes that the runner needs beside the block, about: its stack, buffers of files and the scene,
const BESIDE: usize = 256 << 10;
/// and fields of shapes in double precision while they are drawn.
const FIELDS: usize = 2;

/// Runs `solve`.
pub fn run(arguments: &SolveArguments) -> Result<u8, Failure> {
    let common = &arguments.common;
    let clock = Clock::start();
    let scene = Scene::load(&common.scene, &common.options.set, common.method.as_deref())?;
    let parts = Parts {
        arrays: true,
        images: scene.output.frames,
    };
    let order = Order {
        wishes: common.options.wishes(),
        mode: common.options.mode(),
        parts,
    };
    let folder = arguments.output.as_ref().unwrap_or(&scene.output.folder).clone();
    order
        .solve(scene, folder, clock, Start::default())
        .map(|finished| code_of(finished.status))
}

/// How scenes are to be solved.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Order {
    /// Precision, threads and ceiling.
    pub wishes: Wishes,
    /// How progress is shown.
    pub mode: Mode,
    /// What stays in the result folder beside the report.
    pub parts: Parts,
}

/// Which of the large parts of a result folder are wanted.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Parts {
    /// `result.npz`.
    pub arrays: bool,
    /// The frames and the animation.
    pub images: bool,
}

/// What a solve finds when it begins.
#[derive(Default)]
pub(crate) struct Start {
    /// A result from whose last step it goes on, in the place of the scene's source.
    pub from: Option<PathBuf>,
    /// Who listens for Ctrl-C already, if somebody does.
    pub interrupt: Option<Interrupt>,
}

/// What came of a solve, beside its folder.
pub(crate) struct Finished {
    /// How it ended.
    pub status: Status,
    /// What `report.json` holds.
    pub record: RunRecord,
    /// The pictures of `report.html`, none if the system had not the memory.
    pub gallery: Gallery,
}

impl Order {
    /// Solves `scene` into `folder`; `clock` has run since the scene was read.
    pub fn solve(
        &self,
        scene: Scene,
        folder: PathBuf,
        clock: Clock,
        start: Start,
    ) -> Result<Finished, Failure> {
        let planned = plan::choose(&scene, &self.wishes)?;
        let bytes = planned.plan.bytes();
        let beside = BESIDE
            + FIELDS * size_of::<f64>() * planned.problem.cells.iter().product::<usize>()
            + history_bytes(planned.most_iterations());
        let region = Region::new(bytes)
            .filter(|_| bytes::are_free(beside))
            .ok_or_else(|| no_memory(bytes))?;
        address_space::check(planned.params.threads)?;
        let Start { from, interrupt } = start;
        let job = Job {
            scene,
            planned,
            from,
            folder,
            footprint: region.footprint(),
            mode: self.mode,
            parts: self.parts,
            interrupt,
        };
        threads::with(job.planned.params.threads, || job.run(region, clock))?
    }
}

/// A solve that is over, its numbers written.
struct Solved {
    destination: Destination,
    record: RunRecord,
    status: Status,
    watch: Watch,
}

fn no_memory(bytes: usize) -> Failure {
    Failure::Memory(format!(
        "the system has not {} bytes ({}) for the solve and a little more to read and write; close other programs, or make `grid.cells` or `time.steps` smaller",
        bytes::grouped(bytes),
        bytes::rounded(bytes)
    ))
}

impl Job {
    /// Solves in `region`, and draws pictures when it has been given back.
    fn run(&self, mut region: Region, clock: Clock) -> Result<Finished, Failure> {
        let bytes = self.planned.plan.bytes();
        let block = region.carve(bytes).ok_or_else(|| no_memory(bytes))?;
        touch(block);
        let solved = threads::together(self.planned.params.threads, |exec| {
            self.dispatch(exec, block, clock)
        })?;
        drop(region);
        let draw = |folder: &Path| report::draw(&self.folder, folder, &solved.record, self.parts.images);
        let left = |error| {
            Failure::File(format!(
                "{error}; result.npz and report.json are in {}",
                self.folder.display()
            ))
        };
        let drawn = solved.destination.add(|folder| draw(folder).map_err(left));
        solved.watch.display.close();
        let gallery = drawn?;
        if gallery.is_none() {
            solved.watch.display.warning("the system has not the memory to draw pictures, so there are none; result.npz, report.json and the page are there");
        }
        if !self.parts.arrays {
            let path = self.folder.join(report::ARCHIVE);
            fs::remove_file(&path).map_err(|error| {
                Failure::File(format!(
                    "cannot remove {}: {error}; remove it yourself",
                    path.display()
                ))
            })?;
        }
        self.tell(&solved);
        Ok(Finished {
            status: solved.status,
            record: solved.record,
            gallery: gallery.unwrap_or_default(),
        })
    }

    fn announce(&self, display: &Display) {
        let planned = &self.planned;
        display.event("plan", plan_fields(planned));
        display.note(&format!(
            "{} by {}: {} cells, {} steps, {} bytes ({}) in {}, {} threads",
            self.scene.document.path().display(),
            planned.params.method.name(),
            size_in_words(&planned.problem.cells),
            planned.problem.steps,
            bytes::grouped(planned.plan.bytes()),
            bytes::rounded(planned.plan.bytes()),
            planned.precision.name(),
            planned.params.threads
        ));
    }

    fn dispatch(
        &self,
        exec: &dyn Exec,
        block: &mut [MaybeUninit<u8>],
        clock: Clock,
    ) -> Result<Solved, Failure> {
        match (self.planned.problem.cells.len(), self.planned.precision) {
            (2, Precision::F32) => self.solve::<f32, D2>(exec, block, clock),
            (2, Precision::F64) => self.solve::<f64, D2>(exec, block, clock),
            (_, Precision::F32) => self.solve::<f32, D3>(exec, block, clock),
            (_, Precision::F64) => self.solve::<f64, D3>(exec, block, clock),
        }
    }

    fn solve<T: Real + Sample, S: Space>(
        &self,
        exec: &dyn Exec,
        block: &mut [MaybeUninit<u8>],
        clock: Clock,
    ) -> Result<Solved, Failure> {
        let problem = self.planned.problem.problem();
        let mut solver = Solver::<T, S>::new(&problem, &self.planned.params, block)
            .map_err(|error| solver_refusal(&error))?;
        let mass_factors = match &self.from {
            Some(folder) => hand_on(&self.scene, folder, &mut solver).map(|()| Vec::new())?,
            None => hand_over(&self.scene, &mut solver)?,
        };
        let destination = Destination::check(&self.folder)?;
        let interrupt = self.interrupt.clone().map_or_else(Interrupt::listen, Ok)?;
        let display = Display::new(self.mode, self.planned.params.iterations);
        let mut watch = Watch::new(clock, display, self.planned.most_iterations(), interrupt);
        self.announce(&watch.display);
        self.prepare(&mut solver, exec, &watch)?;
        watch.clock.begin();
        let status = iterate(&mut solver, exec, &mut watch);
        watch.clock.solved();
        watch
            .display
            .detail(format_args!("making the result feasible and writing it"));
        if matches!(status, Status::NotFinite | Status::NotReady) || solver.finish(exec).is_err() {
            watch.display.close();
            return Err(not_finite(&self.scene));
        }
        watch.clock.finished();
        let frames = SolverFrames::new(&solver, &self.planned.problem);
        let record = outcome::record(self, &solver, status, &mut watch, &mass_factors);
        destination.fill(|folder| {
            report::write_numbers(folder, &frames, &record).map_err(|error| Failure::File(error.to_string()))
        })?;
        Ok(Solved {
            destination,
            record,
            status,
            watch,
        })
    }

    /// Projects v_0 and warns if it needed that.
    fn prepare<T: Real, S: Space>(
        &self,
        solver: &mut Solver<'_, T, S>,
        exec: &dyn Exec,
        watch: &Watch,
    ) -> Result<(), Failure> {
        let changed = solver.prepare(exec).map_err(|error| {
            self.scene.document.refuse(
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

    fn tell(&self, solved: &Solved) {
        let Solved {
            record,
            status,
            watch,
            ..
        } = solved;
        let (folder, objective) = (self.folder.display(), record.objective);
        watch.display.event(
            "result",
            json!({
                "status": status.name(),
                "exit_code": code_of(*status),
                "iterations": record.history.len(),
                "seconds": watch.clock.seconds(),
                "objective": objective,
                "folder": folder.to_string(),
            }),
        );
        if self.mode != Mode::Human {
            return;
        }
        console::print(&format!(
            "{} after {} iterations and {}",
            in_sentence(*status),
            record.history.len(),
            in_words(watch.clock.seconds())
        ));
        console::print(&format!(
            "objective {:.5e} = keyframes {:.5e} + force {:.5e}",
            objective.total(),
            objective.data,
            objective.force
        ));
        console::print(&format!(
            "result in {folder}; open {}",
            self.folder.join("report.html").display()
        ));
    }
}

fn iterate<T: Real, S: Space>(solver: &mut Solver<'_, T, S>, exec: &dyn Exec, watch: &mut Watch) -> Status {
    loop {
        let progress = solver.step(exec, watch);
        // An iteration that was cut short has no numbers yet.
        if progress.status != Some(Status::Cancelled) {
            watch.iteration(&progress);
        }
        if let Some(status) = progress.status {
            return status;
        }
    }
}

fn in_sentence(status: Status) -> &'static str {
    match status {
        Status::Converged => "converged",
        Status::MaxIterations => "stopped at its limit",
        Status::Stalled => "stalled before its tolerance",
        Status::NotFinite => "left the finite numbers",
        Status::Cancelled => "interrupted",
        Status::NotReady => "lacked its densities",
    }
}

fn not_finite(scene: &Scene) -> Failure {
    Failure::NotFinite(format!(
        "{}: the solve left the finite numbers, or a flow was too fast to follow, and nothing was written; try --precision f64, more `time.steps` or weaker control",
        scene.document.path().display()
    ))
}
