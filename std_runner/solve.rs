//! `thurible solve SCENE`: plan, allocate once, solve, make feasible, write.

use crate::cli::{SceneArguments, SolveArguments};
use crate::console;
use crate::destination::Destination;
use crate::exit::{Failure, code_of, status_name};
use crate::frames::SolverFrames;
use crate::inputs::{hand_on, hand_over, solver_refusal};
use crate::interrupt::Interrupt;
use crate::job::Job;
use crate::output::Sample;
use crate::plan::{self, Planned, plan_fields, size_in_words};
use crate::problem::Precision;
use crate::progress::{Clock, Display, Mode, Watch, history_bytes, in_words};
use crate::region::Region;
use crate::report::RunRecord;
use crate::scene::Scene;
use crate::{bytes, outcome, report, threads};
use core::mem::MaybeUninit;
use serde_json::json;
use std::path::{Path, PathBuf};
use thurible_core::{D2, D3, Exec, Real, Solver, Space, Status};

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
    let scene = Scene::load(&common.scene, &common.set, common.method.as_deref())?;
    let planned = plan::choose(&scene, &common.wishes())?;
    let folder = arguments.output.as_ref().unwrap_or(&scene.output.folder).clone();
    carry_out(common, clock, scene, planned, None, folder)
}

/// Solves what was planned, from the end of another result perhaps, and writes the result to `folder`.
pub fn carry_out(common: &SceneArguments, clock: Clock, scene: Scene, planned: Planned, from: Option<PathBuf>, folder: PathBuf) -> Result<u8, Failure> {
    let bytes = planned.plan.bytes();
    let beside = BESIDE + FIELDS * size_of::<f64>() * planned.problem.cells.iter().product::<usize>() + 2 * history_bytes(planned.params.iterations);
    let region = Region::new(bytes).filter(|_| bytes::are_free(beside)).ok_or_else(|| no_memory(bytes))?;
    let job = Job { scene, planned, from, folder, footprint: region.footprint(), mode: common.mode() };
    threads::with(job.planned.params.threads, |exec| job.run(exec, region, clock))?
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
    fn run(&self, exec: &dyn Exec, mut region: Region, clock: Clock) -> Result<u8, Failure> {
        let bytes = self.planned.plan.bytes();
        let block = region.carve(bytes).ok_or_else(|| no_memory(bytes))?;
        let solved = self.dispatch(exec, block, clock)?;
        drop(region);
        let draw = |folder: &Path| report::write_pictures(&self.folder, folder, &solved.record, self.scene.output.frames);
        let left = |error| Failure::File(format!("{error}; result.npz and report.json are in {}", self.folder.display()));
        let drawn = solved.destination.add(|folder| draw(folder).map_err(left));
        solved.watch.display.close();
        if !drawn? {
            solved.watch.display.warning("the system has not the memory to draw pictures, so there are none; result.npz, report.json and the page are there");
        }
        self.tell(&solved);
        Ok(code_of(solved.status))
    }

    fn announce(&self, display: &Display) {
        let planned = &self.planned;
        display.event("plan", plan_fields(planned));
        display.note(&format!(
            "{}: {} cells, {} steps, {} bytes ({}) in {}, {} threads",
            self.scene.document.path().display(),
            size_in_words(&planned.problem.cells),
            planned.problem.steps,
            bytes::grouped(planned.plan.bytes()),
            bytes::rounded(planned.plan.bytes()),
            planned.precision.name(),
            planned.params.threads
        ));
    }

    fn dispatch(&self, exec: &dyn Exec, block: &mut [MaybeUninit<u8>], clock: Clock) -> Result<Solved, Failure> {
        match (self.planned.problem.cells.len(), self.planned.precision) {
            (2, Precision::F32) => self.solve::<f32, D2>(exec, block, clock),
            (2, Precision::F64) => self.solve::<f64, D2>(exec, block, clock),
            (_, Precision::F32) => self.solve::<f32, D3>(exec, block, clock),
            (_, Precision::F64) => self.solve::<f64, D3>(exec, block, clock),
        }
    }

    fn solve<T: Real + Sample, S: Space>(&self, exec: &dyn Exec, block: &mut [MaybeUninit<u8>], clock: Clock) -> Result<Solved, Failure> {
        let problem = self.planned.problem.problem();
        let mut solver = Solver::<T, S>::new(&problem, &self.planned.params, block).map_err(|error| solver_refusal(&error))?;
        let mass_factors = match &self.from {
            Some(folder) => hand_on(&self.scene, folder, &mut solver).map(|()| Vec::new())?,
            None => hand_over(&self.scene, &mut solver)?,
        };
        let destination = Destination::check(&self.folder)?;
        let mut watch = Watch::new(clock, self.mode, self.planned.params.iterations, Interrupt::listen()?);
        self.announce(&watch.display);
        self.prepare(&mut solver, exec, &watch)?;
        watch.clock.begin();
        let status = iterate(&mut solver, exec, &mut watch);
        watch.clock.solved();
        watch.display.detail(format_args!("making the result feasible and writing it"));
        if matches!(status, Status::NotFinite | Status::NotReady) || solver.finish(exec).is_err() {
            watch.display.close();
            return Err(not_finite(&self.scene));
        }
        watch.clock.finished();
        let frames = SolverFrames::new(&solver, &self.planned.problem);
        let record = outcome::record(self, &solver, status, &watch, &mass_factors);
        destination.fill(|folder| report::write_numbers(folder, &frames, &record).map_err(|error| Failure::File(error.to_string())))?;
        Ok(Solved { destination, record, status, watch })
    }

    /// Projects v_0 and warns if it needed that.
    fn prepare<T: Real, S: Space>(&self, solver: &mut Solver<'_, T, S>, exec: &dyn Exec, watch: &Watch) -> Result<(), Failure> {
        let changed =
            solver.prepare(exec).map_err(|error| self.scene.document.refuse("source", format!("or a keyframe cannot be used: {error}; change it")))?;
        if changed > DIVERGENT {
            let text = format!("the initial velocity was not divergence-free; projecting it changed it by {changed:.1e} of its largest value");
            watch.display.warning(&text);
        }
        Ok(())
    }

    fn tell(&self, solved: &Solved) {
        let Solved { record, status, watch, .. } = solved;
        let (folder, objective) = (self.folder.display(), record.objective);
        watch.display.event(
            "result",
            json!({
                "status": status_name(*status),
                "exit_code": code_of(*status),
                "iterations": watch.history.len(),
                "seconds": watch.clock.seconds(),
                "objective": objective,
                "folder": folder.to_string(),
            }),
        );
        if self.mode != Mode::Human {
            return;
        }
        console::print(&format!("{} after {} iterations and {}", in_sentence(*status), watch.history.len(), in_words(watch.clock.seconds())));
        console::print(&format!("objective {:.5e} = keyframes {:.5e} + force {:.5e}", objective.total(), objective.data, objective.force));
        console::print(&format!("result in {folder}; open {}", self.folder.join("report.html").display()));
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
