//! The search itself: iterations, whose state is kept and whose flow is shown now and then.

use super::job::Run;
use super::played::Replayed;
use crate::checkpoint::{Keeper, Words};
use crate::progress::Watch;
use crate::run::saved::{self, Ended, Progressed};
use std::time::Instant;
use thurible_core::{Exec, Fluids, Real, Space, Status};

impl Run {
    /// Iterates to the end, records what is heard of it, and keeps states; how it ended. What ended before is not searched again.
    pub fn search<T: Real, S: Space>(
        &self,
        exec: &dyn Exec,
        fluids: &mut Fluids<'_, T, S>,
        so_far: &mut Progressed,
        (watch, keeper): (&mut Watch, &mut Keeper),
    ) -> Status {
        if let Some(Ended(status)) = so_far.ended {
            return status;
        }
        if self.planned.params.controls.is_empty() {
            return Status::Converged;
        }
        loop {
            let progress = fluids.step(exec, watch);
            if !matches!(progress.status, Some(Status::Cancelled | Status::NotFinite)) {
                watch.iteration(&progress);
            }
            if let Some(status) = progress.status {
                return status;
            }
            self.show(exec, fluids, watch);
            if keeper.is_due(watch) {
                let mut words = Words::default();
                if so_far.record(&mut words, watch).is_ok() {
                    keeper.keep(Instant::now(), watch, &words, &mut |file| {
                        saved::write(fluids, file)
                    });
                }
            }
        }
    }

    /// Draws the flow as it is on the page of the search, if it has one: by one run forward.
    fn show<T: Real, S: Space>(&self, exec: &dyn Exec, fluids: &mut Fluids<'_, T, S>, watch: &mut Watch) {
        if let Some(live) = watch.page() {
            let problem = &self.planned.problem;
            let mut played = Replayed {
                fluids,
                exec,
                problem,
            };
            live.draw(Instant::now(), &mut played, 0, problem.steps);
        }
    }
}
