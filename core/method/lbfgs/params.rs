//! What a caller chooses for adjoint control.

use crate::method::refusal::{PlanError, count};
use crate::optimise::quasi_newton::recursion::MAX_PAIRS;
use crate::problem::positive;

/// What a caller chooses for adjoint control.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LbfgsParams {
    /// Pairs; by default as many as the ceiling allows, at most [`LbfgsParams::MOST`].
    pub history: Option<usize>,
    /// Stop when the objective falls by less than this times itself in an iteration, twice in a row.
    pub tolerance: f64,
    /// Whether the forces begin as those of the same scene on coarser grids.
    pub nested: bool,
}

impl Default for LbfgsParams {
    fn default() -> Self {
        Self {
            history: None,
            tolerance: 1e-4,
            nested: false,
        }
    }
}

impl LbfgsParams {
    /// Most pairs.
    pub const MOST: usize = MAX_PAIRS;

    /// Checks every number.
    ///
    /// # Errors
    /// [`PlanError`] names the first that is wrong.
    pub fn check(&self) -> Result<(), PlanError> {
        positive("lbfgs.tolerance", self.tolerance)?;
        count("lbfgs.history", self.history.unwrap_or(1), Self::MOST)
    }
}
