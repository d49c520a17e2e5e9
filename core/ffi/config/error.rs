//! Why a configuration is refused.

use crate::result::ThuribleResult;
use core::fmt;
use thurible_core::PlanError;
use thurible_core::problem::MAX_STEPS;

/// Why a configuration is refused.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ConfigError {
    /// The pointer or the size is wrong: what the call returns says how.
    Result(ThuribleResult),
    /// A code that stands for nothing.
    Code {
        /// Name of the field.
        field: &'static str,
        /// The code that it holds.
        given: u32,
    },
    /// There are more keyframes than steps.
    Keyframes {
        /// The value of `keyframe_count`.
        given: usize,
    },
    /// `keyframes` is null or misaligned.
    KeyframePointer,
    /// The core refuses it.
    Plan(PlanError),
}

impl ConfigError {
    /// What a call returns.
    #[must_use]
    pub fn result(self) -> ThuribleResult {
        match self {
            Self::Result(result) => result,
            Self::Plan(error) => error.into(),
            _ => ThuribleResult::Config,
        }
    }
}

impl From<PlanError> for ConfigError {
    fn from(error: PlanError) -> Self {
        Self::Plan(error)
    }
}

impl fmt::Display for ConfigError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Result(ThuribleResult::Null) => write!(f, "the pointer to the configuration is null"),
            Self::Result(ThuribleResult::Misaligned) => write!(f, "the configuration is misaligned"),
            Self::Result(_) => write!(
                f,
                "the size of the configuration is that of no known version; call thurible_defaults first"
            ),
            Self::Code { field, given } => write!(f, "{field} is {given}, which stands for nothing"),
            Self::Keyframes { given } => {
                write!(f, "keyframe_count is {given}; it must be at most {MAX_STEPS}")
            }
            Self::KeyframePointer => {
                write!(f, "keyframes is null or misaligned, but keyframe_count is not 0")
            }
            Self::Plan(error) => error.fmt(f),
        }
    }
}
