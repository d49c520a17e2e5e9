//! The Hessian of the force term for a flow at rest, exact in time: kappa + S with S = tridiag(-1, 2, -1), last diagonal entry 1.
//!
//! For each face a scalar tridiagonal system along time. It is the same at every face, so solving it commutes with the
//! projection and keeps flows free of divergence (mathematics section 6).

use crate::field::rows;
use crate::real::Real;

/// The reciprocal pivots of kappa + S.
#[derive(Clone, Copy, Debug)]
pub struct TimeLine<'a> {
    pivots: &'a [f64],
}

impl<'a> TimeLine<'a> {
    /// Factors kappa + S with one slot for each of `pivots`; kappa > 0.
    pub fn new(kappa: f64, pivots: &'a mut [f64]) -> Self {
        let (mut pivot, last) = (0.0, pivots.len().saturating_sub(1));
        for (k, slot) in pivots.iter_mut().enumerate() {
            let diagonal = if k == last { kappa + 1.0 } else { kappa + 2.0 };
            pivot = 1.0 / (diagonal - pivot);
            *slot = pivot;
        }
        Self { pivots }
    }

    /// With the pivots of an earlier [`Self::new`].
    #[must_use]
    pub fn factored(pivots: &'a [f64]) -> Self {
        Self { pivots }
    }

    /// x <- (kappa + S)^-1 x for every face of a row of all slots, `nx` faces a slot.
    pub fn solve<T: Real>(&self, row: &mut [T], nx: usize) {
        for (k, &pivot) in self.pivots.iter().enumerate() {
            let (before, now) = row.split_at_mut(k * nx);
            if k > 0 {
                rows::add(&mut now[..nx], &before[(k - 1) * nx..]);
            }
            rows::scale_in_place(&mut now[..nx], T::from_f64(pivot));
        }
        for (k, &pivot) in self.pivots.iter().enumerate().rev().skip(1) {
            let (now, after) = row.split_at_mut((k + 1) * nx);
            rows::add_scaled(&mut now[k * nx..], T::from_f64(pivot), &after[..nx]);
        }
    }
}
