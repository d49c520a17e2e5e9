//! What is chosen for the flow between two frames.

use crate::words::named;

/// How the correction of a level is found.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Minimiser {
    /// Conjugate gradients among flows without divergence.
    #[default]
    Direct,
    /// The alternating direction method: data and smoothness by conjugate gradients, then a projection.
    Admm,
    /// Horn & Schunck 1981: flows may have divergence, perhaps at a price.
    HornSchunck,
}

named!(Minimiser { Direct = "direct", Admm = "admm", HornSchunck = "horn_schunck" });

/// How a frame is pulled back by a flow.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Warping {
    /// Traced back and forth, with an error compensation that is limited.
    #[default]
    Bfecc,
    /// The transport of densities, with the flow turned round.
    Quick,
}

named!(Warping { Bfecc = "bfecc", Quick = "quick" });

/// The numbers of the flow between two frames, in cells and frames.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FlowParams {
    /// How the correction of a level is found.
    pub minimiser: Minimiser,
    /// Weight of smoothness.
    pub alpha: f64,
    /// Weight of the flow's kinetic energy.
    pub beta: f64,
    /// Price of divergence, of Horn-Schunck alone.
    pub gamma: f64,
    /// Step of ADMM.
    pub lambda: f64,
    /// Iterations of ADMM.
    pub iterations: usize,
    /// Grids, at most [`MAX_LEVELS`](super::MAX_LEVELS).
    pub levels: usize,
    /// The cells of the next coarser grid along an axis, in parts of a grid's.
    pub eta: f64,
    /// Width of the blur before a frame goes to a coarser grid, in cells of the finer one; 0 for none.
    pub sigma: f64,
    /// How often a level warps and solves.
    pub warps: usize,
    /// How a frame is pulled back.
    pub warp: Warping,
    /// What conjugate gradients leave of their right-hand side.
    pub cg_tolerance: f64,
    /// Their steps at most.
    pub cg_iterations: usize,
    /// ADMM ends early when it changes less than this part; 0 for never.
    pub tolerance: f64,
}

impl FlowParams {
    /// Fields of faces that a minimiser works in: w, r, q, A q of conjugate gradients, and of ADMM two copies of w and a right-hand side.
    #[must_use]
    pub(super) const fn fields(&self) -> usize {
        match self.minimiser {
            Minimiser::Admm => 7,
            Minimiser::Direct | Minimiser::HornSchunck => 4,
        }
    }

    /// Whether flows have no divergence.
    #[must_use]
    pub const fn is_hard(&self) -> bool {
        !matches!(self.minimiser, Minimiser::HornSchunck)
    }
}
