//! One cell in each lane of a vector, and loops over its faces and edges that are unrolled.

use crate::simd::Vector;

/// The most lanes of a vector.
pub(super) const MAX_LANES: usize = 16;

/// Vector `index` of a list of vectors that lie in `values` one after the other.
#[inline(always)]
pub(super) fn at<V: Vector>(values: &[V::Elem], index: usize) -> V {
    V::load(&values[index * V::LANES..])
}

/// Stores a vector as vector `index` of a list.
#[inline(always)]
pub(super) fn store_at<V: Vector>(vector: V, values: &mut [V::Elem], index: usize) {
    vector.store(&mut values[index * V::LANES..]);
}

/// The lanes that values are gathered to: that of the first cell, and whether cells stay in order or are left
/// as [`Vector::load_pairs`] leaves them.
#[derive(Clone, Copy)]
pub(super) struct Onto {
    pub(super) lane: usize,
    pub(super) in_order: bool,
}

impl Onto {
    /// Groups of one slot: a cell in every lane.
    pub(super) const GROUPS: Self = Self {
        lane: 0,
        in_order: false,
    };

    /// The lane of a cell read by `P`.
    #[inline(always)]
    pub(super) fn lane<P: Vector>(self, cell: usize) -> usize {
        self.lane
            + if self.in_order {
                cell
            } else {
                P::PAIRED.get(cell).copied().unwrap_or(cell)
            }
    }
}

/// A few slots side by side in a vector.
#[derive(Clone, Copy)]
pub(super) struct SideBySide {
    /// Lanes of each slot.
    pub(super) each: usize,
    /// Number of slots.
    pub(super) count: usize,
    /// Cells of a row.
    pub(super) nx: usize,
}

impl SideBySide {
    /// The lanes of one of the slots.
    pub(super) fn onto(self, slot: usize) -> Onto {
        Onto {
            lane: slot * self.each,
            in_order: true,
        }
    }
}

/// Repeats the body for each of the numbers that are below a constant, so that it is compiled with every
/// index known.
macro_rules! unroll {
    ($i:ident < $count:expr; $($number:literal)*; $body:block) => {
        $(if $number < $count {
            let $i: usize = $number;
            $body
        })*
    };
}
pub(super) use unroll;
