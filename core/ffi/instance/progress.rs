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
        let fact = |name: &str| progress.report.get(name);
        Self {
            status: progress.status.into(),
            iteration: progress.iteration,
            data: progress.objective.data,
            force: progress.objective.force,
            cells: progress.cells,
            level: progress.level,
            level_iteration: progress.level_iteration,
            step: fact("step").or(fact("ao_step")).unwrap_or_default(),
            evaluations: fact("evaluations").unwrap_or_default() as usize,
            density_change: fact("density_change").unwrap_or_default(),
            gap: fact("gap").unwrap_or_default(),
            kkt: fact("kkt").unwrap_or_default(),
        }
    }
}
