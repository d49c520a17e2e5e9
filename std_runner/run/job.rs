//! A planned solve in its block of memory: solve, make feasible, write, report.

use super::frames::SolverFrames;
use super::messages::{self, no_memory};
use super::outcome::Outcome;
use super::request::{Request, RunOptions};
use super::settled::Settled;
use crate::among::agreed;
use crate::checkpoint::Keeper;
use crate::destination::Destination;
use crate::exit::Failure;
use crate::live::Held;
use crate::output::{Gallery, Sample};
use crate::plan::Planned;
use crate::problem::{OwnedProblem, Precision};
use crate::progress::{Watch, history_bytes};
use crate::region::{Region, touch};
use crate::report::{self, RunRecord};
use crate::{bytes, threads};
use core::mem::MaybeUninit;
use std::path::Path;
use std::time::Instant;
use thurible_core::exec::Together;
use thurible_core::exec::ranks::Alone;
use thurible_core::{D2, D3, Exec, Named, Real, Solver, Space, Status};

/// A given v_0 that projection changes by more than this is worth a warning.
const DIVERGENT: f64 = 1e-6;

/// Estimated bytes beside the block: stack, buffers of files and the scene.
const BESIDE: usize = 256 << 10;
/// Fields in double precision that exist while a shape is drawn.
const FIELDS: usize = 2;

/// Bytes beside the block while a shape is drawn in a box of these cells, which one program does, or the first of the ranks.
pub(crate) fn drawing_bytes(cells: &[usize]) -> usize {
    FIELDS * size_of::<f64>() * cells.iter().product::<usize>()
}

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
    /// Keeps the states until all is written, where there are any.
    pub keeper: Option<Keeper>,
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
            keeper,
        } = self;
        messages::result(options.mode, &watch, &record, &destination);
        if let Some(live) = watch.live {
            let shown = destination.shown().display();
            live.end(&format!(
                "It is over ({}): the result is in {shown}.",
                record.status.name()
            ));
        }
        if let Some(mut keeper) = keeper {
            // What was interrupted goes on from the last state.
            match keeper.kept() {
                Some(states) if record.status == Status::Cancelled => {
                    messages::can_go_on(&watch.display, states);
                }
                _ => keeper.forget(),
            }
        }
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
            ..
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
        // A rank that follows draws nothing.
        let drawing = if options.follows() {
            0
        } else {
            drawing_bytes(&planned.problem.cells)
        };
        let beside = BESIDE
            + history_bytes(planned.most_iterations())
            + request.settled.map_or(0, |_| densities_bytes(&planned));
        // The ranks of a machine take theirs at once.
        let together = bytes
            .saturating_add(beside)
            .saturating_mul(options.plan.on_this_machine.max(1));
        // A region is of addresses alone: asked for is what will be written to.
        let region = bytes::are_free(together.saturating_add(drawing))
            .then(|| Region::new(bytes))
            .flatten()
            .ok_or_else(|| no_memory(bytes));
        // None of them writes to its own before all have asked.
        let region = agreed(options.several().unwrap_or(&Alone), region)?;
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
        let solved = threads::together(self.planned.params.threads, |exec| {
            self.among_ranks(exec, |exec| match self.options.device {
                Some(device) => self.dispatch(&Together::beside(exec, device), block),
                None => self.dispatch(exec, block),
            })
        })?;
        drop(region);
        solved.show(&self.options)
    }

    fn dispatch(&self, exec: &dyn Exec, block: &mut [MaybeUninit<u8>]) -> Result<Solved, Failure> {
        let solved = match (self.planned.problem.cells.len(), self.planned.precision) {
            (2, Precision::F32) => self.solve::<f32, D2>(exec, block),
            (2, Precision::F64) => self.solve::<f64, D2>(exec, block),
            (_, Precision::F32) => self.solve::<f32, D3>(exec, block),
            (_, Precision::F64) => self.solve::<f64, D3>(exec, block),
        }?;
        self.dismiss();
        Ok(solved)
    }

    fn solve<T: Real + Sample, S: Space>(
        &self,
        exec: &dyn Exec,
        block: &mut [MaybeUninit<u8>],
    ) -> Result<Solved, Failure> {
        if self.planned.windows.is_some() {
            self.solve_in_windows::<T, S>(exec, block)
        } else {
            self.solve_whole::<T, S>(exec, block)
        }
    }

    pub(super) fn watch(&self) -> Result<Watch, Failure> {
        let most = self.planned.most_iterations();
        let limits = [self.planned.params.iterations.min(most), most];
        self.request.watched(self.options.mode, limits)
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

/// Iterates to the end, and records what is heard of it; `each` comes after every iteration but the last.
pub(super) fn iterate<T: Real, S: Space>(
    solver: &mut Solver<'_, T, S>,
    exec: &dyn Exec,
    watch: &mut Watch,
    mut settled: Option<&mut Settled<T>>,
    each: &mut dyn FnMut(&mut Solver<'_, T, S>, &mut Watch),
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
        if let Some(rule) = &mut settled {
            solver.fetch(exec);
            if rule.after_iteration(solver) {
                return Status::Converged;
            }
        }
        each(solver, watch);
    }
}

/// Draws what is there on the page of the solve, if it has one and is on the finest grid; steps count on from `first`.
pub(super) fn show<T: Real + Sample, S: Space>(
    solver: &mut Solver<'_, T, S>,
    exec: &dyn Exec,
    problem: &OwnedProblem,
    watch: &mut Watch,
    first: usize,
) {
    if let Some(live) = watch.page() {
        // What comes after the release is simulated in the end.
        let steps = problem.release.unwrap_or(problem.steps);
        let begun = Instant::now();
        solver.fetch(exec);
        let mut frames = SolverFrames::new(solver, exec, problem);
        live.draw(begun, &mut Held(&mut frames), first, steps);
    }
}
