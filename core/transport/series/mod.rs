//! The Taylor series of exp(tau L(v)) and its adjoint, term by term (mathematics section 3).
//!
//! ```text
//! y_0 = rho,   y_k = (tau / k) L y_{k-1},   exp(tau L) rho = y_0 + y_1 + ..
//! ```
//!
//! L sums over a cell's faces v_f rho_f / h with its sign, rho_f being interpolated from upstream ([`weights`]).

mod adjoint;
mod forward;
mod transposed;

pub use adjoint::adjoint;
pub use forward::{sum, sum_rolling};

use super::rows::{Cells, Velocity};
use super::runs::Sparse;
use super::terms::Terms;
use crate::grid::Grid;
use crate::problem::Scheme;
use crate::real::Real;

/// The most terms of a series after the first one.
pub const MAX_TERMS: usize = 20;
/// The terms that there are at a time where each is used once.
pub const ROLLING: usize = 2;

/// One sub-step.
pub struct Series<'a, T> {
    /// The grid.
    pub grid: &'a Grid,
    /// Velocity at faces.
    pub velocity: Velocity<'a, T>,
    /// See [`weights`].
    pub weights: [T; 3],
    /// Length of the sub-step.
    pub tau: f64,
    /// Terms are summed until max |term| is below this.
    pub cut: f64,
    /// Values of a term below this are set to 0.
    pub negligible: f64,
    /// Whether the way back passes over nothing.
    pub everywhere: bool,
}

/// The interpolation to a face, rho_f = w[0] downstream + w[1] upstream - w[2] next upstream (QUICK: Leonard 1979).
#[must_use]
pub fn weights<T: Real>(scheme: Scheme) -> [T; 3] {
    match scheme {
        Scheme::Central => [0.5, 0.5, 0.0],
        _ => [0.375, 0.75, 0.125],
    }
    .map(T::from_f64)
}

/// The size of a row that became 0 and was not before: in [`Terms`] of a series, 0 says that y_0 and all terms so far are 0 there.
const VANISHED: f64 = -1.0;

/// What term `k` is made from, y_{k-1}: `first`, or one of `terms` with the sizes of its rows.
fn previous<'a, T>(k: usize, grid: &Grid, first: &'a [T], terms: &Terms<&'a [T]>) -> Sparse<'a, T> {
    match k.checked_sub(2) {
        None => Sparse {
            cells: Cells::Plain(first),
            sizes: None,
        },
        Some(before) => Sparse {
            cells: Cells::WithHalo(&terms.fields[before * terms.stride..]),
            sizes: terms.sizes.get(before * grid.rows()..),
        },
    }
}
