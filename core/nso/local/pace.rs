//! How fast the flow is at a cell, and what the smoother leaves out where it is slow.
//!
//! The local Jacobian J and the outside-face term O keep the smoother from going astray where smoke crosses a good part of a cell in a
//! step. Elsewhere they change nothing that a cycle would show, and take two thirds of the arithmetic; so each is left out at every cell and in
//! every slot whose own Courant number, the sum of |v_f| dt / 2h over the cell's faces, is below a bound. Changes that do not vary in
//! time meet kappa alone in the system of a cell, and what J adds to that is of the order of the Courant number squared: the bounds go with
//! the root of kappa, or faster (`docs/convergence.md` has what was measured). With viscosity nothing is left out.

use super::Kept;
use crate::grid::Space;
use crate::real::Real;
use crate::simd::Vector;

/// The power of kappa that the bounds go with: with 1/2, small kappa lost up to a third of a cycle's factor; 2/3 keeps the
/// bound of O where it was seen to be harmless for all of them.
const GROWTH: f64 = 2.0 / 3.0;

/// Courant numbers up to which the smoother leaves terms out.
#[derive(Clone, Copy, Debug)]
pub struct Slow<T> {
    /// J, and so O too.
    pub without_jacobian: T,
    /// O.
    pub without_outside: T,
}

impl Slow<f64> {
    /// Those of the smoother at kappa = 1.
    pub const USUAL: Self = Self { without_jacobian: 0.45, without_outside: 0.85 };
    /// Nothing is left out where anything moves.
    pub const AT_REST: Self = Self { without_jacobian: 0.0, without_outside: 0.0 };

    /// From those at kappa = 1, those of a problem with this kappa.
    #[must_use]
    pub fn at<T: Real>(self, kappa: f64) -> Slow<T> {
        let bound = |courant: f64| T::from_f64((courant * libm::pow(kappa, GROWTH)).min(1.0));
        Slow { without_jacobian: bound(self.without_jacobian), without_outside: bound(self.without_outside) }
    }
}

/// What the cells of a group, together, make of a slot: how much of the Jacobian is left of its block.
#[derive(Clone, Copy)]
pub(super) enum Pace<T> {
    /// All of them are slow, in this slot and in all before: the block left by elimination is one number, of which this is the reciprocal.
    Still(T),
    /// All of them are slow: M is 1.
    Slow,
    /// Some are not.
    Fast,
}

impl<T: Real> Pace<T> {
    /// Writes it to what is kept for a slot.
    #[inline(always)]
    pub(super) fn keep<S: Space, V: Vector<Elem = T>>(self, now: &mut [T]) {
        let number = match self {
            Self::Still(reciprocal) => reciprocal,
            Self::Slow => T::ZERO,
            Self::Fast => -T::ONE,
        };
        V::splat(number).store(&mut now[Kept::<S>::PACE * V::LANES..]);
    }

    /// Reads it again.
    #[inline(always)]
    pub(super) fn of<S: Space, V: Vector<Elem = T>>(now: &[T]) -> Self {
        match now[Kept::<S>::PACE * V::LANES] {
            number if number > T::ZERO => Self::Still(number),
            number if number < T::ZERO => Self::Fast,
            _ => Self::Slow,
        }
    }

    /// Whether there is an M.
    #[inline(always)]
    pub(super) fn is_fast(self) -> bool {
        matches!(self, Self::Fast)
    }
}
