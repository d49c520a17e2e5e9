//! A scene that several programs share, the ranks: the first one draws, writes and shows as a program alone does, the others follow its solver.

use super::job::Job;
use super::messages::no_memory;
use super::{Request, RunOptions};
use crate::exit::{DONE, Failure};
use crate::interrupt::Interrupt;
use crate::problem::Precision;
use crate::region::{Region, touch};
use crate::scene::Scene;
use crate::{address_space, plan, threads};
use thurible_core::exec::{Ranks, Together};
use thurible_core::grid::Share;
use thurible_core::{D2, D3, Exec};

/// Which of the ranks this program is.
pub(crate) fn share_of(ranks: &dyn Ranks) -> Share {
    Share::new(ranks.rank(), ranks.count())
}

/// Refuses a scene that ranks cannot share, for what the core does not know of.
pub(crate) fn unshared(scene: &Scene) -> Result<(), Failure> {
    if !scene.method.fluids.chosen {
        return Ok(());
    }
    let path = scene.document.path().display();
    Err(Failure::Input(format!(
        "{path}: the solver stable_fluids cannot be shared by ranks; take another one, or run `thurible` on one machine"
    )))
}

impl RunOptions {
    /// The ranks that share a scene, where there are several.
    pub(crate) fn several(&self) -> Option<&'static dyn Ranks> {
        self.ranks.filter(|ranks| ranks.count() > 1)
    }

    /// Whether this program follows another one.
    pub(crate) fn follows(&self) -> bool {
        self.ranks.is_some_and(|ranks| ranks.rank() > 0)
    }

    /// Follows the first rank, which solves the scene of `request`; the answer is the exit code.
    ///
    /// # Errors
    /// What that one refuses too, or that there is no memory here.
    pub(crate) fn follow(&self, request: Request) -> Result<u8, Failure> {
        unshared(&request.scene)?;
        let planned = plan::choose(&request.scene, &self.plan)?;
        let threads = planned.params.threads;
        let (job, region) = Job::new(*self, request, planned)?;
        address_space::check(threads)?;
        // A signal to all of them is the first one's to answer, who lets the others go in good order.
        let _ears = Interrupt::listen()?;
        threads::with(threads, || job.follow(region))??;
        Ok(DONE)
    }
}

impl Job {
    /// Calls `work` with the threads of `exec` as those of a rank, where there are several.
    pub(super) fn among_ranks<R>(&self, exec: &dyn Exec, work: impl FnOnce(&dyn Exec) -> R) -> R {
        match self.options.ranks {
            Some(ranks) => work(&Together::new(exec, ranks)),
            None => work(exec),
        }
    }

    /// Follows in `region` until the first rank is done.
    fn follow(&self, mut region: Region) -> Result<(), Failure> {
        let bytes = self.planned.plan.bytes();
        let block = region.carve(bytes).ok_or_else(|| no_memory(bytes))?;
        touch(block);
        threads::together(self.planned.params.threads, |exec| {
            self.among_ranks(exec, |exec| {
                match (self.planned.problem.cells.len(), self.planned.precision) {
                    (2, Precision::F32) => self.follow_through::<f32, D2>(exec, block),
                    (2, Precision::F64) => self.follow_through::<f64, D2>(exec, block),
                    (_, Precision::F32) => self.follow_through::<f32, D3>(exec, block),
                    (_, Precision::F64) => self.follow_through::<f64, D3>(exec, block),
                }
            })
        })
    }
}
