//! What a caller chooses for adjoint control.

use crate::method::choices::{Kind, Numbers, choices};
use crate::optimise::quasi_newton::history::{HistoryPrecision, MAX_PAIRS};
use crate::words::Named;

/// What a caller chooses for adjoint control.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LbfgsParams {
    /// Pairs; by default as many as the ceiling allows, at most [`LbfgsParams::MOST`].
    pub history: Option<usize>,
    /// In how many bytes their numbers are kept.
    pub history_precision: HistoryPrecision,
    /// Stop when the objective falls by less than this times itself in an iteration, twice in a row.
    pub tolerance: f64,
    /// Whether the forces begin as those of the same scene on coarser grids.
    pub nested: bool,
}

impl Default for LbfgsParams {
    fn default() -> Self {
        Self {
            history: None,
            history_precision: HistoryPrecision::Full,
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
    history_precision: history_precision, Kind::Word(HistoryPrecision::WORDS),
        "numbers of the pairs; half: in half the bytes, bfloat16 for f32 and f32 for f64";
    tolerance: tolerance, Kind::Number(Numbers::Below(1.0)),
        "converged when the objective falls by less than this part of itself, twice in a row";
    nested: nested, Kind::Flag, "begin with the forces of the same scene on coarser grids";
});
