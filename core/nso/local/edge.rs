//! The edges of a cell, across which two of its faces meet.

use crate::grid::Space;

/// An edge of the cell, where its faces on `side_a` along `a` and on `side_b` along `b` meet.
#[derive(Clone, Copy)]
pub(super) struct Edge {
    pub(super) a: usize,
    pub(super) b: usize,
    pub(super) side_a: usize,
    pub(super) side_b: usize,
}

impl Edge {
    /// Edge `e` of the cell: four for each pair of axes.
    #[inline(always)]
    pub(super) fn new<S: Space>(e: usize) -> Self {
        let (a, b) = S::PAIRS[e / 4];
        Self {
            a,
            b,
            side_a: e % 2,
            side_b: e / 2 % 2,
        }
    }

    /// The cell's own a-face.
    #[inline(always)]
    pub(super) const fn face_a(self) -> usize {
        2 * self.a + self.side_a
    }

    /// The cell's own b-face.
    #[inline(always)]
    pub(super) const fn face_b(self) -> usize {
        2 * self.b + self.side_b
    }

    /// Where, from the cell, the outside a-face is.
    #[inline(always)]
    pub(super) fn outside_a(self) -> [isize; 3] {
        let mut at = [0; 3];
        at[self.a] = self.side_a as isize;
        at[self.b] = 2 * self.side_b as isize - 1;
        at
    }

    /// Where, from the cell, the outside b-face is.
    #[inline(always)]
    pub(super) fn outside_b(self) -> [isize; 3] {
        let mut at = [0; 3];
        at[self.b] = self.side_b as isize;
        at[self.a] = 2 * self.side_a as isize - 1;
        at
    }

    /// (A-, A+) or (B-, B+) from the cell's own face and the outside one.
    #[inline(always)]
    pub(super) fn order<V>(own: V, outside: V, own_is_low: usize) -> [V; 2] {
        if own_is_low == 1 {
            [own, outside]
        } else {
            [outside, own]
        }
    }
}
