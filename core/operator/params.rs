//! What a caller chooses for an operator.

use crate::method::params::MAX_THREADS;
use crate::method::refusal::{PlanError, count};

/// What a caller chooses for an operator.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OperatorParams {
    /// What an implicit step and its adjoint leave of their residuals, in parts of the largest velocity and of the covector, and projections
    /// of divergences; where rounding errors are larger, these. The gradient is that of the equations themselves, so this is its relative
    /// error too, by the order of magnitude.
    pub tolerance: f64,
    /// States that are kept on the way forward, that at the start counted; as many as the ceiling holds where it is not said, at most one for
    /// each step.
    pub slots: Option<usize>,
    /// Threads that memory is planned for.
    pub threads: usize,
    /// Bytes that the operator must stay within.
    pub ceiling: Option<usize>,
}

impl Default for OperatorParams {
    fn default() -> Self {
        Self {
            tolerance: 1e-10,
            slots: None,
            threads: 1,
            ceiling: None,
        }
    }
}

impl OperatorParams {
    /// Checks every number, for `steps` steps.
    ///
    /// # Errors
    /// [`PlanError`] names the first that is wrong.
    pub fn check(&self, steps: usize) -> Result<(), PlanError> {
        crate::problem::positive("operator.tolerance", self.tolerance)?;
        if let Some(slots) = self.slots {
            count("operator.slots", slots, steps)?;
        }
        count("threads", self.threads, MAX_THREADS)
    }
}
