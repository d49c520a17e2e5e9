//! How far a solve is, as C sees it.

use crate::result::ThuribleStatus;
use thurible_core::Progress;

/// How far a solve is.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default)]
pub struct ThuribleProgress {
    /// How the solve ended, or that it goes on.
    pub status: ThuribleStatus,
    /// Iterations of the method so far.
    pub iteration: usize,
    /// Data term of the objective.
    pub data: f64,
    /// Force term of the objective.
    pub force: f64,
    /// Cells of the grid that the direct method or L-BFGS worked on.
    pub cells: [usize; 3],
    /// That grid, 0 for the finest.
    pub level: usize,
    /// Iteration on that grid.
    pub level_iteration: usize,
    /// Step along the direction, of the direct method or L-BFGS; blending step of ADMM.
    pub step: f64,
    /// Objectives computed in the iteration, of the direct method or L-BFGS.
    pub evaluations: usize,
    /// ADMM: change of the densities over the largest.
    pub density_change: f64,
    /// ADMM: max |v - v*| over max |v|.
    pub gap: f64,
    /// ADMM: the largest violation of the conditions of an optimum.
    pub kkt: f64,
}

impl From<&Progress> for ThuribleProgress {
    fn from(progress: &Progress) -> Self {
        let Progress {
            iteration,
            status,
            objective,
            admm,
            direct,
        } = progress;
        Self {
            status: (*status).into(),
            iteration: *iteration,
            data: objective.data,
            force: objective.force,
            cells: direct.cells,
            level: direct.level,
            level_iteration: direct.level_iteration,
            step: if direct.level_iteration > 0 {
                direct.step
            } else {
                admm.ao_step
            },
            evaluations: direct.evaluations,
            density_change: admm.density_change,
            gap: admm.gap,
            kkt: admm.kkt,
        }
    }
}
