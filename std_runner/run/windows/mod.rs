//! A scene that is solved window by window in the memory of one: see [`crate::windows`].

mod ahead;
mod enter;
mod kept;
mod left;
mod state;
mod sum;
mod walk;

use super::job::{Job, Solved};
use super::messages;
use super::outcome::Facts;
use super::saved::Reading;
use crate::destination::{Aside, Destination};
use crate::exit::Failure;
use crate::output::Sample;
use crate::report;
use crate::windows::{self, Window};
use core::mem::MaybeUninit;
use thurible_core::{Exec, Real, Space, Status};
use walk::Walk;

impl Job {
    /// Solves window after window in the same block, and writes what was kept of them as one result.
    pub(super) fn solve_in_windows<T: Real + Sample, S: Space>(
        &self,
        exec: &dyn Exec,
        block: &mut [MaybeUninit<u8>],
    ) -> Result<Solved, Failure> {
        let all = self.planned.windows();
        let began_with = self.request.began_with();
        let files = report::files(self.planned.problem.steps, self.options.outputs.images);
        let mut destination = Destination::check(&self.request.folder, files)?;
        let masses = match self.request.found {
            Some(_) => None,
            None => ahead::look::<T, S>(self, exec, block, (&destination, &all))?,
        };
        let mut watch = self.watch()?;
        let mut keeper = self.keeper(&destination, began_with)?;
        // A state goes on with the files beside it: where they are elsewhere, none is kept at the end either.
        let (aside, are_beside) = match keeper.beside_states()? {
            Some(folder) => (Aside::within(folder.to_owned()), true),
            None => (destination.aside()?, false),
        };
        let mut reading = self.request.found.as_ref().map(Reading::new).transpose()?;
        let mut walk = Walk::new(self, aside, exec, T::PRECISION)?;
        // What comes after a release is not searched.
        let last = all.iter().rposition(Window::is_searched);
        watch.windows = last.map_or(0, |last| last + 1);
        match &mut reading {
            Some(reading) => walk.go_on::<T, S>(block, reading, &mut watch)?,
            None => walk.masses = masses,
        }
        messages::plan(&watch.display, &self.request.scene, &self.planned);
        messages::windows(&watch.display, &all);
        let blind = windows::blind(&all, &self.planned.problem);
        blind.iter().for_each(|text| watch.display.warning(text));
        match &reading {
            Some(reading) => messages::goes_on(&watch.display, reading.folder(), &watch),
            None => watch.clock.begin(),
        }
        let mut ended = walk.ended();
        while !walk.is_over()
            && let Some(window) = all.get(walk.number())
        {
            messages::window(
                &watch.display,
                &self.planned.problem,
                (walk.number(), all.len()),
                window,
            );
            ended = walk.through::<T, S>(block, (&mut watch, &mut keeper), window, reading.take())?;
        }
        watch.clock.nested = walk.nested();
        watch.clock.solved();
        watch.display.detail(format_args!("writing the result"));
        watch.clock.finished();
        if walk.kept.problem.steps < 2 {
            watch.display.close();
            return Err(messages::without_flow(&self.request.scene, ended, &mut keeper));
        }
        let end = walk.words(&mut watch);
        let (found, mass_factors) = walk.found();
        let facts = Facts {
            scene: &self.request.scene,
            planned: &self.planned,
            problem: &walk.kept.problem,
            footprint: self.footprint,
            mass_factors: &mass_factors,
            folder: destination.folder(),
        };
        let mut record = facts.record(found, ended, &mut watch);
        if self.request.from.as_ref().is_some_and(|from| from.step.is_some()) {
            let text = "In windows the densities are not compared with those that follow in the result that it goes on from.";
            record.remarks.push(text.into());
        }
        record.remarks.extend(blind);
        if let Some(step) = walk.too_fast() {
            record.remarks.push(messages::too_fast(step));
        }
        if let Some(step) = walk.simulated() {
            record.simulated_steps = Some(step);
            record.remarks.push(messages::stopped_after(step, record.steps));
        }
        if let Some(short) = messages::short(&record, self.planned.problem.steps) {
            record.remarks.insert(0, short);
        }
        let kept = &mut walk.kept;
        let result = destination.folder().to_path_buf();
        let filled = destination.fill(|folder| {
            report::write_numbers(folder, &result, kept, &record).map_err(|error| kept.trouble(error))
        });
        if let Err(failure) = filled {
            watch.display.close();
            let how = (ended == Status::Cancelled, false);
            let states = end
                .filter(|_| are_beside)
                .and_then(|words| keeper.keep_end(how, &words, &mut |saving| walk.write(saving)));
            return Err(messages::unwritten(failure, states.as_deref()));
        }
        Ok(Solved {
            destination,
            record,
            watch,
            keeper: Some(keeper),
        })
    }
}
