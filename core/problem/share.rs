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
        /// The ranks.
        ranks: usize,
        /// Planes along the last axis.
        planes: usize,
        /// Planes that each needs.
        least: usize,
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
                "{ranks} ranks share {planes} planes of cells; each needs at least {least}, so take {} ranks at most",
                planes / (*least).max(1)
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
        let planes = self.cells.last().copied().unwrap_or(1);
        if planes / least.max(1) < ranks {
            return Err(ShareError::Thin { ranks, planes, least });
        }
        Ok(())
    }
}
