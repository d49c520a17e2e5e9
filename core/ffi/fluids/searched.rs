//! How far a search by Stable Fluids is.

use crate::result::ThuribleStatus;
use thurible_core::Progress;

/// How far a search is.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default)]
pub struct ThuribleSearched {
    /// How it ended, or that it goes on.
    pub status: ThuribleStatus,
    /// Iterations so far.
    pub iteration: usize,
    /// Data term of the objective.
    pub data: f64,
    /// Price of the forces.
    pub force: f64,
    /// Price of the velocity at the start.
    pub initial: f64,
    /// Step along the direction.
    pub step: f64,
    /// Objectives computed in the iteration.
    pub evaluations: usize,
    /// Steps that its gradient repeated, beside those that were run once more to be taken back.
    pub repeated: usize,
}

impl From<&Progress> for ThuribleSearched {
    fn from(progress: &Progress) -> Self {
        let fact = |name: &str| progress.report.get(name).unwrap_or_default();
        Self {
            status: progress.status.into(),
            iteration: progress.iteration,
            data: progress.objective.data,
            force: progress.objective.force,
            initial: progress.objective.initial,
            step: fact("step"),
            evaluations: fact("evaluations") as usize,
            repeated: fact("recomputed_steps") as usize,
        }
    }
}
