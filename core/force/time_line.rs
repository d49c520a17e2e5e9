//! The Hessian of the force term for a flow at rest, exact in time: kappa + S with S = (D + c)^T (D + c), D d = d_k - d_{k-1}.
//!
//! c, the drag, stands for the viscosity nu C^T C; without it S = tridiag(-1, 2, -1), last diagonal entry 1. For each face a
//! scalar tridiagonal system along time. It is the same at every face, so solving it commutes with the projection and keeps
//! flows free of divergence (mathematics section 6).

use crate::field::rows;
use crate::grid::Grid;
use crate::real::Real;

/// The reciprocal pivots of kappa + S.
#[derive(Clone, Copy, Debug)]
pub struct TimeLine<'a> {
    pivots: &'a [f64],
    /// 1 + c: minus the entries beside the diagonal.
    coupling: f64,
}

/// The drag that stands for nu C^T C on a grid: nu sum_a 1 / h_a^2, at a quarter of the largest eigenvalue.
///
/// Measured on letter_f with nu from 1e-5 to 1e-3: from a tenth to all of that eigenvalue the direct method needs the same
/// iterations; without a drag it starts a twentieth higher.
#[must_use]
pub fn drag(grid: &Grid, viscosity: f64) -> f64 {
    viscosity * grid.h.iter().take(grid.dims).map(|h| 1.0 / (h * h)).sum::<f64>()
}

impl<'a> TimeLine<'a> {
    /// Factors kappa + S with one slot for each of `pivots`; kappa > 0, `drag` >= 0.
    pub fn new(kappa: f64, drag: f64, pivots: &'a mut [f64]) -> Self {
        let mut pivot = 0.0;
        let last = pivots.len().saturating_sub(1);
        let coupling = 1.0 + drag;
        for (k, slot) in pivots.iter_mut().enumerate() {
            let diagonal = kappa + coupling * coupling + if k == last { 0.0 } else { 1.0 };
            pivot = 1.0 / (diagonal - coupling * coupling * pivot);
            *slot = pivot;
        }
        Self { pivots, coupling }
    }

    /// The reciprocal pivots, and minus the entries beside the diagonal.
    #[must_use]
    pub fn numbers(&self) -> (&'a [f64], f64) {
        (self.pivots, self.coupling)
    }

    /// x <- (kappa + S)^-1 x for every face of a row of all slots, `nx` faces a slot.
    pub fn solve<T: Real>(&self, row: &mut [T], nx: usize) {
        let coupling = T::from_f64(self.coupling);
        for (k, &pivot) in self.pivots.iter().enumerate() {
            let (before, now) = row.split_at_mut(k * nx);
            if k > 0 {
                rows::add_scaled(&mut now[..nx], coupling, &before[(k - 1) * nx..]);
            }
            rows::scale_in_place(&mut now[..nx], T::from_f64(pivot));
        }
        for (k, &pivot) in self.pivots.iter().enumerate().rev().skip(1) {
            let (now, after) = row.split_at_mut((k + 1) * nx);
            rows::add_scaled(
                &mut now[k * nx..],
                T::from_f64(pivot * self.coupling),
                &after[..nx],
            );
        }
    }
}
