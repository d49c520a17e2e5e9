//! `thurible solve SCENE`: plan, allocate once, solve, make feasible, write.

use crate::cli::SolveArguments;
use crate::console;
use crate::destination::Destination;
use crate::exit::{Failure, code_of, status_name};
use crate::frames::SolverFrames;
use crate::inputs::{Inputs, solver_refusal};
use crate::interrupt::Interrupt;
use crate::job::Job;
use crate::output::{Gallery, Sample};
use crate::plan::{self, Wishes, plan_fields, size_in_words};
use crate::problem::Precision;
use crate::progress::{Clock, Display, Mode, Watch, in_words};
use crate::region::Region;
use crate::report::{Parts, RunRecord};
use crate::scene::{Scene, method_name};
use crate::{bytes, outcome, report, threads};
use core::mem::MaybeUninit;
use serde_json::json;
use std::path::Path;
use thurible_core::{D2, D3, Exec, Objective, Real, Solver, Space, Status};

/// A given v_0 that projection changes by more than this is worth a warning.
const DIVERGENT: f64 = 1e-6;

/// Runs `solve`.
pub fn run(arguments: &SolveArguments) -> Result<u8, Failure> {
    let common = &arguments.common;
    let clock = Clock::start();
    let scene = Scene::load(&common.scene, &common.options.set, common.method.as_deref())?;
    let mode = common.options.mode();
    let order = Order { wishes: common.options.wishes(), mode, parts: Parts { arrays: true, images: scene.output.frames } };
    let folder = arguments.output.clone().unwrap_or_else(|| scene.output.folder.clone());
    let interrupt = Interrupt::listen(mode != Mode::Human)?;
    order.solve(scene, &folder, clock, interrupt).map(|solved| code_of(solved.status))
}

/// How scenes are to be solved.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Order {
    /// Precision, threads and ceiling.
    pub wishes: Wishes,
    /// How progress is shown.
    pub mode: Mode,
    /// What is written beside the report.
    pub parts: Parts,
}

/// What came of a solve, beside its folder.
pub(crate) struct Solved {
    /// How it ended.
    pub status: Status,
    /// What `report.json` holds.
    pub record: RunRecord,
    /// The pictures of `report.html`.
    pub gallery: Gallery,
}

impl Order {
    /// Solves `scene` into `folder`; `clock` has run since the scene was read.
    pub(crate) fn solve(&self, scene: Scene, folder: &Path, clock: Clock, interrupt: Interrupt) -> Result<Solved, Failure> {
        let planned = plan::choose(&scene, &self.wishes)?;
        let inputs = Inputs::draw(&scene)?;
        let destination = Destination::check(folder)?;
        let bytes = planned.plan.bytes();
        let mut region = Region::new(bytes).ok_or_else(|| no_memory(bytes))?;
        let footprint = region.footprint();
        let block = region.carve(bytes).ok_or_else(|| no_memory(bytes))?;
        let watch = Watch::new(clock, self.mode, planned.params.iterations, interrupt);
        let job = Job { scene, planned, inputs, destination, footprint, mode: self.mode, parts: self.parts };
        job.announce(&watch.display);
        threads::with(job.planned.params.threads, |exec| job.dispatch(exec, block, watch))?
    }
}

fn no_memory(bytes: usize) -> Failure {
    Failure::Memory(format!(
        "the system has not {} bytes ({}) for the solve; close other programs, or make `grid.cells` or `time.steps` smaller",
        bytes::grouped(bytes),
        bytes::rounded(bytes)
    ))
}

impl Job {
    fn announce(&self, display: &Display) {
        let planned = &self.planned;
        display.event("plan", plan_fields(planned));
        display.note(&format!(
            "{} by {}: {} cells, {} steps, {} bytes ({}) in {}, {} threads",
            self.scene.document.path().display(),
            method_name(planned.params.method),
            size_in_words(&planned.problem.cells),
            planned.problem.steps,
            bytes::grouped(planned.plan.bytes()),
            bytes::rounded(planned.plan.bytes()),
            planned.precision.name(),
            planned.params.threads
        ));
    }

    fn dispatch(&self, exec: &dyn Exec, block: &mut [MaybeUninit<u8>], watch: Watch) -> Result<Solved, Failure> {
        match (self.planned.problem.cells.len(), self.planned.precision) {
            (2, Precision::F32) => self.solve::<f32, D2>(exec, block, watch),
            (2, Precision::F64) => self.solve::<f64, D2>(exec, block, watch),
            (_, Precision::F32) => self.solve::<f32, D3>(exec, block, watch),
            (_, Precision::F64) => self.solve::<f64, D3>(exec, block, watch),
        }
    }

    fn solve<T: Real + Sample, S: Space>(&self, exec: &dyn Exec, block: &mut [MaybeUninit<u8>], mut watch: Watch) -> Result<Solved, Failure> {
        let problem = self.planned.problem.problem();
        let mut solver = Solver::<T, S>::new(&problem, &self.planned.params, block).map_err(|error| solver_refusal(&error))?;
        let mass_factors = self.inputs.hand_over(&self.scene, &mut solver)?;
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
        let write = |folder: &Path| report::write_and_show(folder, &frames, &record, self.parts).map_err(|error| Failure::File(error.to_string()));
        let gallery = self.destination.fill(write)?;
        watch.display.close();
        self.tell(&watch, status, solver.objective());
        Ok(Solved { status, record, gallery })
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

    fn tell(&self, watch: &Watch, status: Status, objective: Objective) {
        let folder = self.destination.folder().display();
        watch.display.event(
            "result",
            json!({
                "status": status_name(status),
                "exit_code": code_of(status),
                "iterations": watch.history.len(),
                "seconds": watch.clock.seconds(),
                "objective": { "data": objective.data, "force": objective.force, "total": objective.total() },
                "folder": folder.to_string(),
            }),
        );
        if self.mode != Mode::Human {
            return;
        }
        console::print(&format!("{} after {} iterations and {}", in_sentence(status), watch.history.len(), in_words(watch.clock.seconds())));
        console::print(&format!("objective {:.5e} = keyframes {:.5e} + force {:.5e}", objective.total(), objective.data, objective.force));
        console::print(&format!("result in {folder}; open {}", self.destination.folder().join("report.html").display()));
    }
}

fn iterate<T: Real, S: Space>(solver: &mut Solver<'_, T, S>, exec: &dyn Exec, watch: &mut Watch) -> Status {
    loop {
        let progress = solver.step(exec, watch);
        watch.iteration(&progress);
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
        "{}: the solve left the finite numbers and nothing was written; try --precision f64, a larger `method.admm.penalty` or more `time.steps`",
        scene.document.path().display()
    ))
}
