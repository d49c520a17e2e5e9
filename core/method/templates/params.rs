//! What a caller chooses for a search over templates.

use crate::method::choices::{Kind, Numbers, choices};
use crate::optimise::quasi_newton::history::MAX_PAIRS;

/// What a caller chooses for a search over templates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TemplatesParams {
    /// Pairs.
    pub history: usize,
    /// Stop when the objective falls by less than this times itself in an iteration, twice in a row.
    pub tolerance: f64,
}

impl Default for TemplatesParams {
    fn default() -> Self {
        Self {
            history: MAX_PAIRS,
            tolerance: 1e-4,
        }
    }
}

choices!(TemplatesParams, "templates" {
    history: history, Kind::Count(MAX_PAIRS), "pairs that it remembers";
    tolerance: tolerance, Kind::Number(Numbers::Below(1.0)),
        "converged when the objective falls by less than this part of itself, twice in a row";
});
