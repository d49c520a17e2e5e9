//! What a caller chooses for adjoint control.

use crate::method::choices::{Kind, Numbers, choices};
use crate::optimise::quasi_newton::recursion::MAX_PAIRS;

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
}

choices!(LbfgsParams, "lbfgs" {
    history: history, Kind::Automatic(LbfgsParams::MOST), "pairs that it remembers; auto: as many as fit";
    tolerance: tolerance, Kind::Number(Numbers::Below(1.0)),
        "converged when the objective falls by less than this part of itself, twice in a row";
    nested: nested, Kind::Flag, "begin with the forces of the same scene on coarser grids";
});
