//! How fast the flow is at a cell, and what the smoother leaves out where it is slow.
//!
//! The local Jacobian J and the outside-face term O keep the smoother from going astray where smoke crosses a good part of a cell in a
//! step. Elsewhere they change little that a cycle would show, and take two thirds of the arithmetic; so both are left out at every cell and in
//! every slot where s, the sum of (v_f dt / h)^2 over the cell's faces, is below a bound. Changes that do not vary in time meet kappa alone
//! in the system of a cell, and J adds J^T J to that, which is of the order of s: so the bound goes with kappa, and s itself stands in for what is
//! left out, on the diagonal, which keeps the smoother from going too far (`docs/convergence.md` has what was measured). With viscosity
//! nothing is left out.

use super::{Kept, at};
use crate::grid::Space;
use crate::real::Real;
use crate::simd::Vector;

/// What the bound is at most, whatever kappa: from a speed of 0.8 cells a step on, factors grow.
const MOST: f64 = 1.3;

/// Up to where the smoother leaves terms out.
#[derive(Clone, Copy, Debug)]
pub struct Slow<T> {
    /// The largest sum of (v_f dt / h)^2 over the faces of a slow cell.
    pub squares: T,
}

impl Slow<f64> {
    /// That of the smoother at kappa = 1.
    pub const USUAL: Self = Self { squares: 0.4 };
    /// Nothing is left out where anything moves.
    pub const AT_REST: Self = Self { squares: 0.0 };

    /// From that at kappa = 1, that of a problem with this kappa.
    #[must_use]
    pub fn at<T: Real>(self, kappa: f64) -> Slow<T> {
        Slow {
            squares: T::from_f64((self.squares * kappa).min(MOST)),
        }
    }
}

/// What the cells of a group, together, make of a slot: how much of the Jacobian is left of its block.
#[derive(Clone, Copy)]
pub(super) enum Pace<V> {
    /// All of them are slow, in this slot and in all before: the block left by elimination is one number a cell, of which this is the reciprocal.
    Still(V),
    /// All of them are slow: M is 1.
    Slow,
    /// Some are not.
    Fast,
}

impl<V: Vector> Pace<V>
where
    V::Elem: Real,
{
    /// Writes it to what is kept for a slot.
    #[inline(always)]
    pub(super) fn keep<S: Space>(self, now: &mut [V::Elem]) {
        let numbers = match self {
            Self::Still(reciprocal) => reciprocal,
            Self::Slow => V::splat(V::Elem::ZERO),
            Self::Fast => V::splat(-V::Elem::ONE),
        };
        numbers.store(&mut now[Kept::<S>::PACE * V::LANES..]);
    }

    /// Reads it again.
    #[inline(always)]
    pub(super) fn of<S: Space>(now: &[V::Elem]) -> Self {
        match now[Kept::<S>::PACE * V::LANES] {
            number if number > V::Elem::ZERO => Self::Still(at(now, Kept::<S>::PACE)),
            number if number < V::Elem::ZERO => Self::Fast,
            _ => Self::Slow,
        }
    }

    /// Whether there is an M.
    #[inline(always)]
    pub(super) fn is_fast(self) -> bool {
        matches!(self, Self::Fast)
    }
}
