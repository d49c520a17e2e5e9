//! Fields of a sub-step that are kept for the way back, and what the way back changes.

use crate::field::VectorMut;

/// Terms of a series, or stages of a Runge-Kutta step.
pub struct Terms<N> {
    /// The fields, whose rows have halos.
    pub fields: N,
    /// The distance from one field to the next.
    pub stride: usize,
    /// The largest magnitude in each row of each field: 0 where the row may be passed over.
    pub sizes: N,
}

/// What the backward sweep of a sub-step changes.
pub struct Backward<'a, T> {
    /// mu, before and after.
    pub mu: &'a mut [T],
    /// Two fields of cells, whose rows have halos.
    pub work: [&'a mut [T]; 2],
    /// The velocity gradient.
    pub gradient: VectorMut<'a, T>,
    /// Whether the gradient is begun with this sub-step, or added to.
    pub first: bool,
}
