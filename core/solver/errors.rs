//! Why memory or a field is refused.

use crate::memory::ALIGN;
use crate::method::refusal::PlanError;
use core::fmt;

/// Why a [`Solver`](super::Solver) cannot be made.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum SolverError {
    /// The plan is refused.
    Plan(PlanError),
    /// The memory has fewer bytes than planned.
    TooSmall {
        /// Bytes needed.
        needed: usize,
        /// Bytes given.
        given: usize,
    },
    /// The memory does not begin on a multiple of [`Plan::ALIGN`](super::Plan::ALIGN).
    Misaligned,
}

impl fmt::Display for SolverError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Plan(error) => error.fmt(f),
            Self::TooSmall { needed, given } => {
                write!(f, "the solve needs {needed} bytes and was given {given}")
            }
            Self::Misaligned => write!(f, "the memory must begin on a multiple of {ALIGN} bytes"),
        }
    }
}

impl core::error::Error for SolverError {}

impl From<PlanError> for SolverError {
    fn from(error: PlanError) -> Self {
        Self::Plan(error)
    }
}

/// Why a field is refused.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum InputError {
    /// It has the wrong number of values.
    Length {
        /// Values expected.
        expected: usize,
        /// Values given.
        given: usize,
    },
    /// A value is NaN or infinite.
    NotFinite {
        /// Its index.
        index: usize,
    },
    /// A density is negative.
    Negative {
        /// Its index.
        index: usize,
    },
    /// The density has no mass.
    Empty,
    /// All but a hundredth of the density's mass is in solid cells.
    Buried,
    /// A region's value is above 1.
    AboveOne {
        /// Its index.
        index: usize,
    },
    /// All cells are solid.
    NoFluid,
    /// Solid cells were given after densities, which may lie in them.
    SolidsLate,
    /// The shape of an emitter is not set.
    NoEmitter {
        /// The emitter.
        index: usize,
    },
    /// There is no such keyframe or axis.
    Index {
        /// The index.
        given: usize,
        /// How many there are.
        count: usize,
    },
    /// The source must be set first.
    NoSource,
    /// A keyframe was not set.
    NoKeyframe {
        /// Its index.
        index: usize,
    },
    /// The method follows a flow, and none was given.
    NoReference,
    /// A field of so many cells has no room to be resampled.
    TooFine {
        /// Its cells.
        cells: usize,
    },
    /// Smoke that is made was given where none was planned for.
    NoEmission,
}

impl fmt::Display for InputError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Length { expected, given } => {
                write!(f, "it has {given} values where {expected} are needed")
            }
            Self::NotFinite { index } => write!(f, "value {index} is not finite"),
            Self::Negative { index } => write!(f, "value {index} is negative"),
            Self::Buried => write!(f, "all of it, or nearly, is inside solid cells"),
            Self::SolidsLate => write!(
                f,
                "solid cells come before every density; give them first, to a new solver"
            ),
            Self::Empty => write!(f, "it is empty: its mass is zero"),
            Self::Index { given, count } => write!(f, "index {given} is out of range; there are {count}"),
            Self::AboveOne { index } => write!(f, "value {index} is above 1"),
            Self::NoFluid => write!(f, "all cells are solid"),
            Self::NoEmitter { index } => write!(f, "the shape of emitter {index} must be set first"),
            Self::NoSource => write!(
                f,
                "there is no smoke yet: a source must be set before, or an emitter that has begun"
            ),
            Self::NoKeyframe { index } => write!(f, "keyframe {index} was not set"),
            Self::NoReference => write!(f, "there is no flow to follow: one must be set before"),
            Self::TooFine { cells } => {
                write!(f, "its {cells} cells are too many to be resampled in this memory")
            }
            Self::NoEmission => write!(
                f,
                "no smoke that is made was planned for: `emission` must be set before"
            ),
        }
    }
}

impl core::error::Error for InputError {}
