//! A scene that is solved window by window in the memory of one: see [`crate::windows`].

mod ahead;
mod kept;
mod left;
mod sum;
mod walk;

use super::job::{Job, Solved};
use super::messages::{self, not_finite};
use super::outcome::Facts;
use crate::destination::Destination;
use crate::exit::Failure;
use crate::output::Sample;
use crate::report;
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
        let windows = self.planned.windows();
        let files = report::files(self.planned.problem.steps, self.options.outputs.images);
        let mut destination = Destination::check(&self.request.folder, files)?;
        let mut walk = Walk::new(self, destination.aside()?, exec, T::PRECISION)?;
        walk.look_ahead::<T, S>(block)?;
        let mut watch = self.watch()?;
        messages::plan(&watch.display, &self.request.scene, &self.planned);
        messages::windows(&watch.display, &windows);
        watch.clock.begin();
        let mut nested = 0.0;
        let mut ended = Status::Converged;
        for (number, window) in windows.iter().enumerate() {
            let begun = watch.clock.seconds();
            messages::window(
                &watch.display,
                &self.planned.problem,
                (number, windows.len()),
                window,
            );
            watch.enter_window(number);
            ended = walk.through::<T, S>(block, &mut watch, window)?;
            nested += (watch.clock.nested - begun).max(0.0);
            if walk.is_over() {
                break;
            }
        }
        watch.clock.nested = nested;
        watch.clock.solved();
        watch.display.detail(format_args!("writing the result"));
        watch.clock.finished();
        if walk.kept.problem.steps < 2 {
            watch.display.close();
            return Err(not_finite(&self.request.scene));
        }
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
        if let Some(short) = messages::short(&record, self.planned.problem.steps) {
            record.remarks.insert(0, short);
        }
        let kept = &mut walk.kept;
        destination.fill(|folder| {
            report::write_numbers(folder, kept, &record).map_err(|error| kept.trouble(error))
        })?;
        Ok(Solved {
            destination,
            record,
            watch,
        })
    }
}
