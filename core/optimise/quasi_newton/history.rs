//! How many pairs L-BFGS remembers, and in how many bytes.

use crate::words::named;

/// In how many bytes the numbers of the pairs are kept. All that is computed with them is in the precision of the solve.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum HistoryPrecision {
    /// In those of the solve.
    #[default]
    Full,
    /// In half of them: bfloat16 where a solve is in `f32`, `f32` where it is in `f64`.
    Half,
}

named!(HistoryPrecision { Full = "full", Half = "half" });

/// Most pairs.
pub const MAX_PAIRS: usize = 8;
/// Most fields.
pub const MAX_FIELDS: usize = History::full(MAX_PAIRS).fields();

/// What L-BFGS remembers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct History {
    /// Pairs at most, from 1 to [`MAX_PAIRS`].
    pub pairs: usize,
    /// In how many bytes they are kept.
    pub precision: HistoryPrecision,
}

impl History {
    /// So many pairs in the precision of the solve.
    #[must_use]
    pub const fn full(pairs: usize) -> Self {
        Self {
            pairs,
            precision: HistoryPrecision::Full,
        }
    }

    /// Whether a pair is one field of halves instead of two fields.
    #[must_use]
    pub const fn halves(self) -> bool {
        matches!(self.precision, HistoryPrecision::Half)
    }

    /// Fields that it asks for: those of the pairs, the direction and P g, and what a trial needs beside what the oldest pair leaves it.
    #[must_use]
    pub const fn fields(self) -> usize {
        if self.halves() {
            self.pairs + 3
        } else {
            2 * self.pairs + 2
        }
    }

    /// Sums for each row of the grid.
    #[must_use]
    pub const fn sums_per_row(self) -> usize {
        2 * self.pairs + 1
    }
}

/// Where s and z of a pair are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kept {
    /// In these two fields.
    Full([usize; 2]),
    /// In one field, each in half of an element: see [`Real::of_halves`](crate::real::Real::of_halves).
    Halves(usize),
}

impl Kept {
    /// The fields.
    #[must_use]
    pub fn fields(&self) -> &[usize] {
        match self {
            Self::Full(fields) => fields,
            Self::Halves(field) => core::slice::from_ref(field),
        }
    }

    /// The same, to be written.
    pub(super) fn fields_mut(&mut self) -> &mut [usize] {
        match self {
            Self::Full(fields) => fields,
            Self::Halves(field) => core::slice::from_mut(field),
        }
    }
}
