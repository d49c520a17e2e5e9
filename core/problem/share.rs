//! What ranks that share a box cannot do.

use super::Problem;
use crate::grid::Share;
use core::fmt;

/// Why ranks cannot share a problem.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ShareError {
    /// There is no such rank.
    Rank {
        /// The rank.
        rank: usize,
        /// How many there are said to be.
        ranks: usize,
    },
    /// The method cannot.
    Method {
        /// Its name.
        method: &'static str,
    },
    /// There are more ranks than the box has planes for.
    Thin {
        /// The ranks one behind the other.
        ranks: usize,
        /// Planes along the last axis.
        planes: usize,
        /// Planes that each needs.
        least: usize,
    },
    /// There are more ranks beside each other than planes have rows for.
    Narrow {
        /// The ranks beside each other.
        ranks: usize,
        /// Rows along the axis before the last.
        rows: usize,
        /// Rows that each needs.
        least: usize,
    },
    /// Ranks cannot have blocks of the box.
    Blocks {
        /// The ranks.
        ranks: usize,
        /// How many were to be beside each other.
        beside: usize,
        /// Axes of the box.
        dims: usize,
    },
}

impl fmt::Display for ShareError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Rank { rank, ranks } => write!(
                f,
                "rank {rank} is none of {ranks} ranks, which count from 0; give a rank below their number"
            ),
            Self::Method { method } => write!(
                f,
                "the method {method} cannot be shared by ranks; simulate, direct and admm can, or take one rank and more threads"
            ),
            Self::Thin { ranks, planes, least } => write!(
                f,
                "{ranks} ranks one behind the other share {planes} planes of cells; each needs at least {least}, so take {} of them at most, or in 3D a number that two others have as their product, for blocks",
                planes / (*least).max(1)
            ),
            Self::Narrow { ranks, rows, least } => write!(
                f,
                "{ranks} ranks beside each other share {rows} rows of cells; each needs at least {least}, so put {} beside each other at most",
                rows / (*least).max(1)
            ),
            Self::Blocks { dims: 2, .. } => {
                write!(
                    f,
                    "a box with two axes cannot be cut into blocks; let each rank have whole rows"
                )
            }
            Self::Blocks { ranks, beside, .. } => write!(
                f,
                "{ranks} ranks cannot be {beside} beside each other along y; give a number that divides theirs and is smaller, so that z is cut too"
            ),
        }
    }
}

impl Problem<'_> {
    /// Whether several ranks share the box.
    #[must_use]
    pub fn is_shared(&self) -> bool {
        self.share.is_some_and(|share| share.ranks > 1)
    }

    /// Refuses what they cannot do.
    ///
    /// # Errors
    /// [`ShareError`].
    pub(super) fn check_share(&self) -> Result<(), ShareError> {
        let Some(Share {
            rank,
            ranks,
            beside,
            reach: least,
        }) = self.share
        else {
            return Ok(());
        };
        if rank >= ranks {
            return Err(ShareError::Rank { rank, ranks });
        }
        if !self.is_shared() {
            return Ok(());
        }
        let dims = self.cells.len();
        if beside != 1 && (dims < 3 || beside == 0 || beside >= ranks || !ranks.is_multiple_of(beside)) {
            return Err(ShareError::Blocks { ranks, beside, dims });
        }
        let [planes, rows] = [1, 2].map(|before| {
            let axis = dims.checked_sub(before);
            axis.and_then(|axis| self.cells.get(axis)).copied().unwrap_or(1)
        });
        let behind = ranks / beside;
        if planes / least.max(1) < behind {
            let ranks = behind;
            return Err(ShareError::Thin { ranks, planes, least });
        }
        if beside > 1 && rows / least.max(1) < beside {
            let ranks = beside;
            return Err(ShareError::Narrow { ranks, rows, least });
        }
        Ok(())
    }
}
