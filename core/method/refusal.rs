//! Why a plan is refused.

use crate::problem::ProblemError;
use core::fmt;

/// Why a [`Plan`](crate::Plan) is refused.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum PlanError {
    /// The problem or a parameter is wrong.
    Problem(ProblemError),
    /// `iterations` or `threads` is 0 or absurd.
    OutOfRange {
        /// The field.
        field: &'static str,
        /// The value.
        given: usize,
        /// The largest value.
        most: usize,
    },
    /// The ceiling holds less than the least that is needed.
    Ceiling {
        /// Bytes needed.
        needed: usize,
        /// The ceiling.
        ceiling: usize,
    },
    /// The sizes do not fit this machine's addresses.
    TooLarge,
}

impl fmt::Display for PlanError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Problem(error) => error.fmt(f),
            Self::OutOfRange { field, given, most } => {
                write!(f, "{field} is {given}; it must be from 1 to {most}")
            }
            Self::Ceiling { needed, ceiling } => write!(
                f,
                "{needed} bytes are needed at least and the ceiling is {ceiling}; raise it, or take fewer cells"
            ),
            Self::TooLarge => write!(
                f,
                "cells times steps is more than this machine can address; use fewer cells or steps"
            ),
        }
    }
}

impl core::error::Error for PlanError {}

impl From<ProblemError> for PlanError {
    fn from(error: ProblemError) -> Self {
        Self::Problem(error)
    }
}

/// Refuses a count that is not from 1 to `most`.
///
/// # Errors
/// [`PlanError::OutOfRange`].
pub fn count(field: &'static str, given: usize, most: usize) -> Result<(), PlanError> {
    if (1..=most).contains(&given) {
        Ok(())
    } else {
        Err(PlanError::OutOfRange { field, given, most })
    }
}
