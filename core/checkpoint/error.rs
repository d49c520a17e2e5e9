//! Why saved bytes are refused.

use super::Broken;
use super::label::FORMAT;
use core::fmt;

/// Why saved bytes are refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum SavedError {
    /// There are more or fewer than this solver saves.
    Length {
        /// Bytes expected.
        expected: usize,
        /// Bytes given.
        given: usize,
    },
    /// They are no saved solver.
    NotSaved,
    /// They are in a format that is not read.
    Format {
        /// Its number.
        given: u64,
    },
    /// They belong to another problem, precision, method or choice.
    OtherSolve,
    /// They are not what was written.
    Damaged,
    /// They could not be written or read: the sink or the source says why.
    Refused,
}

impl From<Broken> for SavedError {
    fn from(broken: Broken) -> Self {
        match broken {
            Broken::Damaged => Self::Damaged,
            Broken::Refused => Self::Refused,
        }
    }
}

impl fmt::Display for SavedError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Length { expected, given } => {
                write!(f, "{given} bytes were given where {expected} are needed")
            }
            Self::NotSaved => write!(f, "these bytes are no saved solver"),
            Self::Format { given } => write!(
                f,
                "the saved solver is in format {given}; only {} is read",
                FORMAT
            ),
            Self::OtherSolve => write!(
                f,
                "the saved solver is of another problem, precision, method or choice of it"
            ),
            Self::Damaged => write!(f, "the saved solver is damaged"),
            Self::Refused => write!(f, "the saved solver could not be written or read to its end"),
        }
    }
}

impl core::error::Error for SavedError {}
