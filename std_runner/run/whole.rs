//! A scene that is solved as a whole, from its beginning or from a state that was kept.

use super::earlier::Origin;
use super::found::Found;
use super::frames::SolverFrames;
use super::inputs::{Inputs, set_inputs};
use super::job::{Job, Solved, iterate, show};
use super::masses;
use super::messages;
use super::outcome::Facts;
use super::request::Request;
use super::saved::{self, Ended, Progressed, Reading};
use super::settled::Settled;
use super::stages::Stage;
use crate::checkpoint::{Inputs as Files, Keeper, Words};
use crate::console::quoted_path;
use crate::destination::Destination;
use crate::devices::Searching;
use crate::exit::Failure;
use crate::output::Sample;
use crate::progress::Watch;
use crate::report::{self, RunRecord};
use core::mem::MaybeUninit;
use std::time::Instant;
use thurible_core::method::registry::simulates;
use thurible_core::{Exec, Real, Solver, Space, Status};

impl Job {
    /// Solves the scene in `block`, and writes the arrays and the report.
    pub(super) fn solve_whole<T: Real + Sample, S: Space>(
        &self,
        exec: &dyn Exec,
        block: &mut [MaybeUninit<u8>],
    ) -> Result<Solved, Failure> {
        let began_with = self.request.began_with();
        let masses = match self.request.found {
            Some(_) => None,
            None => masses::of_a_free_flow::<T, S>(self, exec, block)?,
        };
        let (mut solver, _) = self.lead::<T, S>(Stage::Whole, block)?;
        self.solve_by(&mut solver, exec, masses.as_deref(), began_with)
    }

    /// Solves the scene, which `began_with` these files, by `solver`, which is new.
    fn solve_by<T: Real + Sample, S: Space>(
        &self,
        solver: &mut Solver<'_, T, S>,
        exec: &dyn Exec,
        masses: Option<&[f64]>,
        began_with: Option<Files>,
    ) -> Result<Solved, Failure> {
        let found = self.request.found.as_ref();
        let reading = found.map(Reading::new).transpose()?;
        let inputs = match &reading {
            Some(_) => Inputs::default(),
            None => self.set_inputs(solver, masses)?,
        };
        let files = report::files(self.planned.problem.steps, self.options.outputs.images);
        let mut destination = Destination::check(&self.request.folder, files)?;
        let mut watch = self.watch()?;
        messages::plan(&watch.display, &self.request.scene, &self.planned);
        if self.request.checkpoint.is_asked_for() && simulates(&self.planned.params) {
            messages::keeps_none(&watch.display, self.planned.params.method);
        }
        inputs.notes.iter().for_each(|note| watch.display.file_note(note));
        let mut so_far = Progressed {
            mass_factors: inputs.mass_factors,
            ended: None,
        };
        match reading {
            Some(mut reading) => self.go_on(&mut reading, solver, &mut so_far, &mut watch)?,
            None => self.prepare(solver, exec, &watch)?,
        }
        // States of an earlier solve make way when nothing can be refused any more.
        let mut keeper = self.keeper(&destination, began_with)?;
        if found.is_none() {
            watch.clock.begin();
        }
        let ended = self.search(exec, solver, &mut so_far, (&mut watch, &mut keeper))?;
        let mut words = Words::default();
        let remembered = so_far.record(&mut words, &mut watch);
        let record = self.record(solver, &so_far, (ended, &mut watch), &destination);
        let mut frames = SolverFrames::new(solver, exec, &self.planned.problem);
        let result = destination.folder().to_path_buf();
        let filled = destination.fill(|folder| report::write_numbers(folder, &result, &mut frames, &record));
        if let Err(failure) = filled {
            watch.display.close();
            let how = (ended == Status::Cancelled, true);
            let kept = remembered.ok().and_then(|()| {
                keeper.keep_end(how, &words, &mut |saving| saved::write_shared(solver, saving))
            });
            return Err(messages::unwritten(failure, kept.as_deref()));
        }
        Ok(Solved {
            destination,
            record,
            watch,
            keeper: Some(keeper),
        })
    }

    /// What went wrong on the device, if there is one and anything did.
    fn device_failure(&self) -> Option<String> {
        self.options.device.and_then(Searching::failure)
    }

    /// Ends a solve whose device failed; what it left here is not the flow that was found.
    fn refuse_failed(&self, watch: &mut Watch, keeper: &Keeper) -> Result<(), Failure> {
        let Some(why) = self.device_failure() else {
            return Ok(());
        };
        watch.display.close();
        let goes_on = keeper.kept().map_or(String::new(), |states| {
            format!(
                "; `thurible resume {}` goes on from the last state, on the processors too",
                quoted_path(states)
            )
        });
        Err(Failure::Memory(format!("the device failed: {why}{goes_on}")))
    }

    /// Iterates to the end, keeping states, and makes the result feasible; how it ended. What ended before is not searched again.
    fn search<T: Real + Sample, S: Space>(
        &self,
        exec: &dyn Exec,
        solver: &mut Solver<'_, T, S>,
        so_far: &mut Progressed,
        (watch, keeper): (&mut Watch, &mut Keeper),
    ) -> Result<Status, Failure> {
        let ended = match so_far.ended {
            Some(Ended(status)) => status,
            None => {
                let mut settled = self.request.settled.map(Settled::new);
                let mut each = |solver: &mut Solver<'_, T, S>, watch: &mut Watch| {
                    show(solver, exec, &self.planned.problem, watch, 0);
                    if keeper.is_due(watch) {
                        let mut words = Words::default();
                        if so_far.record(&mut words, watch).is_ok() {
                            // What a device hands over is a part of what keeping takes.
                            let begun = Instant::now();
                            solver.fetch_all(exec);
                            if self.device_failure().is_some() {
                                return;
                            }
                            keeper.keep(begun, watch, &words, &mut |saving| {
                                saved::write_shared(solver, saving)
                            });
                        }
                    }
                };
                iterate(solver, exec, watch, settled.as_mut(), &mut each)
            }
        };
        self.refuse_failed(watch, keeper)?;
        watch.clock.solved();
        watch
            .display
            .detail(format_args!("making the result feasible and writing it"));
        let is_unfinished = !solver.is_finished() && solver.finish(exec).is_err();
        // The last flow came from the device just now: where it did not, there is an earlier one in its place.
        self.refuse_failed(watch, keeper)?;
        if ended == Status::NotReady || is_unfinished {
            watch.display.close();
            return Err(messages::without_flow(&self.request.scene, ended, keeper));
        }
        watch.clock.finished();
        // What was cut off goes on.
        so_far.ended = (ended != Status::Cancelled).then_some(Ended(ended));
        Ok(ended)
    }

    /// What was found, beside an earlier result where there is one.
    fn record<T: Real, S: Space>(
        &self,
        solver: &Solver<'_, T, S>,
        so_far: &Progressed,
        (ended, watch): (Status, &mut Watch),
        destination: &Destination,
    ) -> RunRecord {
        let facts = Facts {
            scene: &self.request.scene,
            planned: &self.planned,
            problem: &self.planned.problem,
            footprint: self.footprint,
            mass_factors: &so_far.mass_factors,
            folder: destination.folder(),
        };
        let found = Found::of(solver, &self.planned.problem);
        let mut record = facts.record(found, ended, watch);
        let Request { from, reference, .. } = &self.request;
        let is_by_step = |from: &&Origin| from.by_step(&self.request.scene) == 1.0;
        if let Some(truth) = reference.as_ref().or_else(|| from.as_ref().filter(is_by_step)) {
            // A density that cannot be read is no reason to lose what was found.
            match truth.compare(&self.request.scene, solver) {
                Ok(frames) => record.frames = frames,
                Err(failure) => record.remarks.push(format!("It is not compared: {failure}.")),
            }
        }
        let (step, steps) = (watch.simulated(), self.planned.problem.steps);
        if ended == Status::Cancelled && simulates(&self.planned.params) && step < steps {
            record.simulated_steps = Some(step);
            record.remarks.push(messages::stopped_after(step, steps));
        }
        record
    }

    /// Hands the solver the state that it goes on from, and the watch what was seen until then.
    fn go_on<T: Real, S: Space>(
        &self,
        reading: &mut Reading<'_>,
        solver: &mut Solver<'_, T, S>,
        so_far: &mut Progressed,
        watch: &mut Watch,
    ) -> Result<(), Failure> {
        reading.remember(so_far, watch)?;
        self.restore(reading, solver)?;
        messages::goes_on(&watch.display, reading.folder(), watch);
        Ok(())
    }

    /// Hands the solver what it starts from.
    fn set_inputs<T: Real, S: Space>(
        &self,
        solver: &mut Solver<'_, T, S>,
        masses: Option<&[f64]>,
    ) -> Result<Inputs, Failure> {
        let scene = &self.request.scene;
        // Where a flow is guided it begins with the reference's, which is taken step by step.
        let reference = self.request.reference.as_ref();
        let scale = reference.map_or(1.0, |reference| reference.by_step(scene));
        let inputs = match &self.request.from {
            Some(from) => from.begin(scene, solver, None, scale)?,
            None => set_inputs(scene, solver, masses)?,
        };
        if let Some(reference) = reference {
            reference.guide(scene, solver, scale)?;
        }
        Ok(inputs)
    }
}
