//! What local damping makes of the block of a slot (see [`damping`](crate::nso::damping)).

use crate::real::Real;
use crate::simd::Vector;

/// The form of the block of a slot, the same for all cells of a group.
#[derive(Clone, Copy)]
pub(super) enum Form<V> {
    /// All cells are damped, in this slot and in all before: what elimination leaves of the block is a
    /// multiple of the identity, the reciprocal of this one.
    Scalar(V),
    /// All cells are damped: M is the identity.
    Damped,
    /// At least one cell has a Jacobian.
    Full,
}

impl<V: Vector> Form<V>
where
    V::Elem: Real,
{
    /// Stores it in the first vector of `to`: a positive one, 0 or a negative one.
    #[inline(always)]
    pub(super) fn store(self, to: &mut [V::Elem]) {
        let code = match self {
            Self::Scalar(reciprocal) => reciprocal,
            Self::Damped => V::splat(V::Elem::ZERO),
            Self::Full => V::splat(-V::Elem::ONE),
        };
        code.store(to);
    }

    /// What [`Self::store`] stored.
    #[inline(always)]
    pub(super) fn load(from: &[V::Elem]) -> Self {
        match from[0] {
            code if code > V::Elem::ZERO => Self::Scalar(V::load(from)),
            code if code < V::Elem::ZERO => Self::Full,
            _ => Self::Damped,
        }
    }

    /// Whether there is a Jacobian.
    #[inline(always)]
    pub(super) fn is_full(self) -> bool {
        matches!(self, Self::Full)
    }
}
