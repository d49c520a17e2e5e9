//! Limited transport: third order where the density is smooth, and no value outside those around it (mathematics section 3).
//!
//! The density at a face that flows from L to R, LL being the next cell upstream (Koren 1993):
//!
//! ```text
//! rho_f = rho_L + 1/2 lim(rho_L - rho_LL, rho_R - rho_L)
//! lim(c, d) = sign(d) max(0, min(2 c sign d, (c + 2 d) sign d / 3, 2 d sign d))
//! ```
//!
//! A sub-step of length tau is one of SSP Runge-Kutta's of third order (Shu & Osher 1988), L summing over a cell's faces v_f rho_f / h
//! with its sign:
//!
//! ```text
//! a = rho + tau L rho,   b = 3/4 rho + 1/4 (a + tau L a),   rho' = 1/3 rho + 2/3 (b + tau L b)
//! ```
//!
//! At walls, and at the closed faces of solid cells, the last cell stands for the missing one upstream of it: lim(0, d) = 0 there, and so are
//! its derivatives. Differences across closed faces are 0, which comes to the same.

mod backward;
mod forward;
mod limiter;
mod transposed;

pub use backward::backward;
pub use forward::forward;

use super::rows::Velocity;
use crate::grid::Grid;

/// Stages that are kept for the way back: a and b.
pub const KEPT: usize = 2;
/// The Courant number up to which a step of Euler's is monotone with this limiter: rho_f is at most 2 rho_L, and what leaves a cell in a
/// step at most twice that number times what it has.
pub const COURANT: f64 = 0.5;

/// So many times longer sub-steps may be while a flow is searched: three stages are stable at Courant number 1, if not quite monotone.
pub const LONGER: f64 = 2.0;

/// What each stage of limited transport keeps of rho; the rest is of the field that flows: rho, a and b.
pub const KEEP: [f64; 3] = [0.0, 0.75, 1.0 / 3.0];

/// One sub-step.
#[derive(Clone, Copy)]
pub struct Substep<'a, T> {
    /// The grid.
    pub grid: &'a Grid,
    /// Velocity at faces.
    pub velocity: Velocity<'a, T>,
    /// 0 at the closed faces of solid cells, 1 at others; empty without solid cells.
    pub open: Velocity<'a, T>,
    /// Length of the sub-step.
    pub tau: f64,
    /// Values of a stage below this are set to 0, so that rows far from the smoke stay empty.
    pub negligible: f64,
    /// Whether the way back passes over nothing.
    pub everywhere: bool,
}

impl<T> Substep<'_, T> {
    /// Whether there are solid cells.
    fn among_solids(&self) -> bool {
        !self.open.0[0].is_empty()
    }

    /// tau / h of the grid's axes.
    fn scales(&self) -> [f64; 3] {
        self.grid.h.map(|h| self.tau / h)
    }
}
