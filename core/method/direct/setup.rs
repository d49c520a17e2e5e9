//! The numbers of a solve: those of the problem, and what they come to on each grid.

use super::params::{DirectParams, dearer};
use crate::grid::Grid;
use crate::method::params::Params;
use crate::objective::{flow, sweep};
use crate::operators::blur::Metric;
use crate::optimise::quasi_newton::history::History;
use crate::problem::Problem;
use crate::transport::Stepping;

/// All that a solve follows from but its densities, in scaled numbers.
#[derive(Clone, Copy, Debug)]
pub struct Setup {
    /// The finest grid.
    pub grid: Grid,
    /// The objective on the finest grid; max rho_0 is set with the source.
    pub flow: flow::Setup,
    /// Fields of the script.
    pub fields: usize,
    /// Pairs of L-BFGS.
    pub history: History,
    /// What an iteration on the finest grid must gain, relative to the objective.
    pub tolerance: f64,
    /// Whether the flow begins on coarser grids.
    pub nested: bool,
    /// Iterations at most on each of them, where that is chosen.
    pub coarse_iterations: Option<usize>,
    /// What the force's weight is multiplied by from each grid to the next coarser one.
    pub coarse_force_weight: f64,
    /// Iterations on the finest grid at most.
    pub iterations: usize,
    /// Whether two steps are one on the coarser grids: where every keyframe's step is even and leaves a time level to steer by.
    pub halves_time: bool,
}

impl Setup {
    /// That of `problem`.
    #[must_use]
    pub fn new(problem: &Problem<'_>, params: &Params) -> Self {
        let DirectParams {
            history,
            history_precision,
            tolerance,
            nested,
            coarse_iterations,
            coarse_force_weight,
            overlap,
        } = params.direct;
        let mut flow = flow::Setup::new(problem, params.threads);
        flow.sweep.overlap = overlap.unwrap_or(true);
        let even = |&step: &usize| step.is_multiple_of(2) && step >= 4;
        Self {
            grid: problem.grid(),
            flow,
            fields: problem.fields(),
            history: History {
                pairs: history.unwrap_or(DirectParams::MOST_BY_DEFAULT),
                precision: history_precision,
            },
            tolerance,
            nested,
            coarse_iterations,
            coarse_force_weight,
            iterations: params.iterations,
            halves_time: problem.steps.is_multiple_of(2) && problem.keyframes.iter().all(even),
        }
    }
}

/// Scale K of the first inverse Hessian (K + r S)^-1, in scaled numbers.
const STIFFNESS: f64 = 1e3;

/// Steps of the scene that are one on grid `level`.
pub fn stride(setup: &Setup, level: usize) -> u32 {
    if level > 0 && setup.halves_time { 2 } else { 1 }
}

/// Slots on grid `level`.
pub fn slots_on(setup: &Setup, level: usize) -> usize {
    (setup.flow.sweep.slots + 1) / stride(setup, level) as usize - 1
}

/// K, nu and r in the scaled numbers of grid `level`: with steps `s` times as long, v of a step is s times as large, w s^2 times, and
/// there are s times fewer of each. On coarser grids force may be dearer, or cheaper.
pub fn weights(setup: &Setup, level: usize) -> [f64; 3] {
    let s = f64::from(stride(setup, level));
    let dearer = dearer(level, setup.coarse_force_weight);
    [
        STIFFNESS / (s * s),
        setup.flow.viscosity * s,
        dearer * setup.flow.force_weight / (s * s * s),
    ]
}

/// Weight of e in the metric on the grids between the coarsest and the finest. What those grids cannot resolve would make them
/// tear the smoke's edge, and the finest grid would inherit it; the coarsest needs the whole metric, to move far smoke at all.
const IDENTITY_BETWEEN: f64 = 0.25;

/// Where the search cuts the series of transport, on the finest grid and on those that it starts from: at so many times the cut
/// of the result, and at no more than this part of max rho_0. A minimum moves by the square of what that leaves out; but J goes in
/// steps of it, which end a search whose tolerance is small, as it is on the coarser grids.
const SEARCH_CUT: [(f64, f64); 2] = [(1e2, 1e-3), (1e1, 1e-4)];

/// Courant number of the search's sub-steps at most: fewer of them need fewer terms in all. Terms grow before they fall, to e^7.5 at
/// worst, which single precision holds to 1e-4 of max rho_0; twenty of them leave 7.5^20 / 20! = 0.13 of what could be worst.
const SEARCH_COURANT: f64 = 3.0;

/// Transport of the search on grid `level` for that of the result.
fn search_stepping(result: Stepping, level: usize) -> Stepping {
    let (times, most) = SEARCH_CUT[usize::from(level > 0)];
    Stepping {
        tolerance: result.tolerance.max(most.min(times * result.tolerance)),
        courant: SEARCH_COURANT,
        ..result
    }
}

/// Transport and metric of the search on grid `level` of `levels`.
pub fn sweep_setup(setup: &Setup, level: usize, levels: usize, threads: usize) -> sweep::Setup {
    let between = (1..levels.saturating_sub(1)).contains(&level);
    let metric = Metric {
        filters: setup.flow.sweep.metric.filters.saturating_sub(level),
        identity: if between { IDENTITY_BETWEEN } else { 1.0 },
    };
    sweep::Setup {
        slots: slots_on(setup, level),
        metric,
        stepping: search_stepping(setup.flow.sweep.stepping, level),
        threads,
        ..setup.flow.sweep
    }
}
