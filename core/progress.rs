//! What an outer iteration reports, and how a solve ends: data, not errors.

use crate::checkpoint::{Damaged, Record};
use crate::words::named;

/// Most cycles of one Navier-Stokes problem whose residuals are reported, the first residual included.
pub const MAX_CYCLES: usize = 64;
/// Most iterations of one advection problem whose residuals are reported.
pub const MAX_RESIDUALS: usize = 16;

/// Data and force terms of the objective J (paper eq. 5).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Objective {
    /// 1/2 sum over keyframes of <e, C e>.
    pub data: f64,
    /// r/2 sum of |u|^2.
    pub force: f64,
}

impl Objective {
    /// Both terms in a checkpoint.
    ///
    /// # Errors
    /// [`Damaged`].
    pub fn record(&mut self, record: &mut Record<'_>) -> Result<(), Damaged> {
        record.real(&mut self.data)?;
        record.real(&mut self.force)
    }

    /// J.
    #[must_use]
    pub fn total(&self) -> f64 {
        self.data + self.force
    }
}

/// How a solve ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Status {
    /// The method's own rule says so.
    Converged,
    /// The iterations were used up.
    MaxIterations,
    /// It no longer moves, but does not satisfy the rule of convergence.
    Stalled,
    /// Of a step: nothing that it tries is finite, or slow enough to be transported; what
    /// [`Solver::finish`](crate::Solver::finish) gives is the last flow that was. Of a solve: there is no such flow.
    NotFinite,
    /// The observer said stop.
    Cancelled,
    /// The source or a keyframe is missing.
    NotReady,
}

named!(Status {
    Converged = "converged",
    MaxIterations = "max_iterations",
    Stalled = "stalled",
    NotFinite = "not_finite",
    Cancelled = "cancelled",
    NotReady = "not_ready",
});

impl Status {
    /// How a solve ended whose last step ended so, where its result could be made feasible or not.
    #[must_use]
    pub fn of_result(self, feasible: bool) -> Self {
        match self {
            _ if !feasible => Self::NotFinite,
            Self::NotFinite => Self::Stalled,
            status => status,
        }
    }
}

/// What one outer iteration did.
#[derive(Clone, Debug, Default)]
pub struct Progress {
    /// Outer iteration, from 1.
    pub iteration: usize,
    /// Set when the solve is over.
    pub status: Option<Status>,
    /// The objective of the current velocities and forces.
    pub objective: Objective,
    /// How ADMM went.
    pub admm: AdmmProgress,
    /// How the direct method went, or L-BFGS over the forces.
    pub direct: DirectProgress,
}

/// How the direct method, or L-BFGS over the forces, went in one iteration.
#[derive(Clone, Copy, Debug, Default)]
pub struct DirectProgress {
    /// Cells of the grid that it worked on.
    pub cells: [usize; 3],
    /// That grid, 0 for the finest.
    pub level: usize,
    /// Iteration on that grid, from 1.
    pub level_iteration: usize,
    /// Step along the direction, 0 when none gained anything.
    pub step: f64,
    /// <gradient, direction>: the objective's derivative along the direction.
    pub slope: f64,
    /// Flows, or forces, whose objective was computed.
    pub evaluations: usize,
}

/// How ADMM went in one outer iteration.
#[derive(Clone, Debug, Default)]
pub struct AdmmProgress {
    /// Blending step alpha of AO.
    pub ao_step: f64,
    /// max change of rho since the iteration before, over max rho_0.
    pub density_change: f64,
    /// max |f| of NSO before its first V-cycle and after each.
    pub nso_residuals: heapless::Vec<f64, MAX_CYCLES>,
    /// max of AO's direction, over dt, in each of its iterations: the residual of its fixed point as an acceleration (the paper's
    /// Figure 7). Of more than [`MAX_RESIDUALS`] the last stands for all that came later.
    pub ao_residuals: heapless::Vec<f64, MAX_RESIDUALS>,
    /// The largest violation of the optimality conditions: of AO's, NSO's, and max |v - v*| over dt (the paper's Figure 7).
    pub kkt: f64,
    /// max |v - v*| over max |v|.
    pub gap: f64,
    /// Data term of v*, where the objective's is that of v.
    pub data_of_star: f64,
    /// Whether the multipliers were held: an iteration of the plain augmented Lagrangian.
    pub held: bool,
}
