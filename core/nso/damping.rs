//! The local damping of a level: where the flow is slow, the smoother damps a cell instead of linearising its
//! equations.
//!
//! The local Jacobian J and the outside-face term O keep the smoother stable where smoke crosses a good part
//! of a cell in one step. Elsewhere they hardly change the convergence of a cycle, but take two thirds of the
//! arithmetic. So both are left out at every cell and in every slot where
//!
//! ```text
//! s = sum over the faces f of the cell of (v_f dt / h)^2
//! ```
//!
//! is at most a threshold, and s takes their place on the diagonal, which keeps corrections from
//! overshooting. Changes that are constant in time meet kappa alone in the system of a cell, and J would add
//! J^T J, which is of the order of s: so the threshold grows with kappa. `docs/convergence.md` has what was
//! measured. With viscosity nothing is left out.

use crate::real::Real;

/// The largest threshold, whatever kappa: from a speed of 0.8 cells a step on, convergence suffers.
const LARGEST: f64 = 1.3;

/// Where the smoother damps.
#[derive(Clone, Copy, Debug)]
pub struct LocalDamping<T> {
    /// The largest s at which a cell is damped.
    pub threshold: T,
}

impl LocalDamping<f64> {
    /// The smoother's own, at kappa = 1.
    pub const USUAL: Self = Self { threshold: 0.4 };
    /// Only cells at rest are damped, by 0: nothing is left out.
    pub const NONE: Self = Self { threshold: 0.0 };

    /// From the damping at kappa = 1, that of a problem with this `kappa`.
    #[must_use]
    pub fn at<T: Real>(self, kappa: f64) -> LocalDamping<T> {
        LocalDamping {
            threshold: T::from_f64((self.threshold * kappa).min(LARGEST)),
        }
    }
}
