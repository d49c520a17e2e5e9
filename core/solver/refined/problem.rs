//! The problem on the finer grid, and the grids below it.

use crate::grid::Grid;
use crate::grid::spectrum::LONGEST;
use crate::method::refusal::PlanError;
use crate::problem::{Advection, Problem, Scheme};

/// The longest axis among solid cells. A plane is projected by longer eigenvectors than a search has, which take longer than their many cells.
pub(super) const fn longest_among_solids(dims: usize) -> usize {
    if dims == 2 { 1024 } else { LONGEST }
}

/// Refuses what a problem on the finer grid cannot be.
pub(super) fn check_problem(problem: &Problem<'_>) -> Result<(), PlanError> {
    let longest = longest_among_solids(problem.cells.len());
    let fits = problem.cells.iter().all(|&n| n <= longest);
    let solids = problem.solids && !fits;
    Problem { solids, ..*problem }.check().map_err(PlanError::from)
}

/// What is left of a problem that nobody steers.
pub(super) fn free<'a>(problem: &Problem<'a>) -> Problem<'a> {
    Problem {
        keyframes: &[],
        keyframe_weights: &[],
        keyframe_regions: false,
        schedule: &[],
        release: None,
        advection: Advection {
            scheme: Scheme::Limited,
            ..problem.advection
        },
        ..*problem
    }
}

/// The grid whose cells are as often twice as long; `None` if there is none.
pub(super) fn halved(grid: &Grid, halvings: usize) -> Option<Grid> {
    let mut coarse = *grid;
    let by = 1 << halvings;
    for axis in 0..grid.dims {
        if !grid.n[axis].is_multiple_of(by) {
            return None;
        }
        coarse.n[axis] /= by;
        coarse.h[axis] *= by as f64;
    }
    Some(coarse)
}
