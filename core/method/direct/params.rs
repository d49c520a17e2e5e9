//! What a caller chooses for the direct method.

use crate::grid::levels;
use crate::method::choices::{Kind, Numbers, choices};
use crate::objective::coarse;
use crate::optimise::quasi_newton::history::{HistoryPrecision, MAX_PAIRS};
use crate::problem::Problem;
use crate::words::Named;

/// Iterations at most on the coarsest grid, where they cost nothing, and on those between it and the finest.
const COARSE_ITERATIONS: [usize; 2] = [100, 60];
/// Iterations on a coarser grid that may be asked for.
const MOST_COARSE_ITERATIONS: usize = 100_000;

/// The factor of the force's weight from grid to grid is below this.
const MOST_COARSE_WEIGHT: f64 = 100.0;
/// The factor of all grids together stays between 1 over this and this: single precision holds what is divided by it.
const MOST_DEARER: f64 = 1e6;

/// What the force's weight is multiplied by on grid `level`, where it is `factor` times as much from each grid to the next.
pub(super) fn dearer(level: usize, factor: f64) -> f64 {
    libm::pow(factor, level as f64).clamp(1.0 / MOST_DEARER, MOST_DEARER)
}

/// Iterations at most on grid `level` > 0, of which `coarsest` is the last, where `chosen` of them are asked for.
pub(super) fn coarse_iterations(level: usize, coarsest: usize, chosen: Option<usize>) -> usize {
    chosen.unwrap_or(COARSE_ITERATIONS[usize::from(level < coarsest)])
}

/// What a caller chooses for the direct method.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DirectParams {
    /// Pairs of L-BFGS; by default as many as the ceiling allows, at most [`DirectParams::MOST_BY_DEFAULT`].
    pub history: Option<usize>,
    /// In how many bytes their numbers are kept.
    pub history_precision: HistoryPrecision,
    /// Stop when the objective falls by less than this times itself in an iteration, twice in a row.
    pub tolerance: f64,
    /// Whether the flow begins as that of the same scene on coarser grids.
    pub nested: bool,
    /// Iterations at most on each coarser grid; by default few, which is fast. More find cheaper ways where a shape changes a great deal.
    pub coarse_iterations: Option<usize>,
    /// What the weight of the force is multiplied by from each grid to the next coarser one. Above 1 a flow of little force is found first, which misses
    /// its keyframes, and is then led to them grid by grid. All grids together change it by a million at most.
    pub coarse_force_weight: f64,
    /// Whether two threads take different tasks where fields are small; by default where memory allows it. Changes no result.
    pub overlap: Option<bool>,
}

impl Default for DirectParams {
    fn default() -> Self {
        Self {
            history: None,
            history_precision: HistoryPrecision::Full,
            tolerance: 1e-4,
            nested: true,
            coarse_iterations: None,
            coarse_force_weight: 1.0,
            overlap: None,
        }
    }
}

choices!(DirectParams, "direct" {
    history: history, Kind::Automatic(MAX_PAIRS),
        "pairs of its quasi-Newton method: more need more memory; auto: as many as fit, at most 5";
    history_precision: history_precision, Kind::Word(HistoryPrecision::WORDS),
        "numbers of the pairs; half: in half the bytes, bfloat16 for f32 and f32 for f64";
    tolerance: tolerance, Kind::Number(Numbers::Below(1.0)),
        "converged when the objective falls by less than this part of itself, twice in a row";
    nested: nested, Kind::Flag, "begin with the flow of the same scene on coarser grids";
    coarse_iterations: coarse_iterations, Kind::Automatic(MOST_COARSE_ITERATIONS),
        "iterations on each coarser grid at most; 400 for a shape that changes much";
    coarse_force_weight: coarse_force_weight, Kind::Number(Numbers::Within(MOST_COARSE_WEIGHT)),
        "factor of force_weight from each grid to the next coarser one; 3 finds shapes that need little force";
});

impl DirectParams {
    /// Pairs when nothing is said and memory is plenty.
    pub const MOST_BY_DEFAULT: usize = 5;

    /// Iterations of a solve at most, those on coarser grids included, of which `on_finest` on the finest.
    #[must_use]
    pub fn most_iterations(&self, problem: &Problem<'_>, on_finest: usize) -> usize {
        let grids = levels::hierarchy(&problem.grid());
        let coarser = grids
            .windows(2)
            .take_while(|pair| self.nested && coarse::begins_on(&pair[0], &pair[1]))
            .count();
        (1..=coarser)
            .map(|level| coarse_iterations(level, coarser, self.coarse_iterations))
            .fold(on_finest, usize::saturating_add)
    }
}
