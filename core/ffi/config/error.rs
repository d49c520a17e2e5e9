//! Why a configuration is refused.

use crate::result::ThuribleResult;
use core::fmt;
use thurible_core::PlanError;
use thurible_core::condense::CondenseError;
use thurible_core::tomography::TomographyError;

/// Names of a list and of its length, and the most that it may have.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ListNames {
    /// The field that points to it.
    pub list: &'static str,
    /// The field that counts it.
    pub count: &'static str,
    /// Entries at most.
    pub most: usize,
}

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
    /// A list has too many entries.
    Count {
        /// The list.
        names: &'static ListNames,
        /// How many it has.
        given: usize,
    },
    /// A list is null or misaligned.
    Pointer {
        /// The list.
        names: &'static ListNames,
    },
    /// An emitter has not the one or the other of rate and target.
    Supply {
        /// The emitter.
        index: usize,
    },
    /// The core refuses it.
    Plan(PlanError),
    /// The core refuses cameras or settings.
    Tomography(TomographyError),
    /// The core refuses a body, or how it is condensed.
    Condense(CondenseError),
}

impl ConfigError {
    /// What a call returns.
    #[must_use]
    pub fn result(self) -> ThuribleResult {
        match self {
            Self::Result(result) => result,
            Self::Plan(error) => error.into(),
            Self::Tomography(error) => error.into(),
            Self::Condense(error) => error.into(),
            _ => ThuribleResult::Config,
        }
    }
}

impl From<ThuribleResult> for ConfigError {
    fn from(result: ThuribleResult) -> Self {
        Self::Result(result)
    }
}

impl From<CondenseError> for ConfigError {
    fn from(error: CondenseError) -> Self {
        Self::Condense(error)
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
            Self::Result(ThuribleResult::ConfigSize) => write!(
                f,
                "the size of the configuration is that of no known version; call thurible_defaults first"
            ),
            Self::Result(result) => f.write_str(result.words()),
            Self::Code { field, given } => write!(f, "{field} is {given}, which stands for nothing"),
            Self::Count {
                names: ListNames { count, most, .. },
                given,
            } => {
                write!(f, "{count} is {given}; it must be at most {most}")
            }
            Self::Pointer {
                names: ListNames { list, count, .. },
            } => {
                write!(f, "{list} is null or misaligned, but {count} is not 0")
            }
            Self::Supply { index } => {
                write!(
                    f,
                    "emitters[{index}] must have either a rate or a target above 0, and the other 0"
                )
            }
            Self::Plan(error) => error.fmt(f),
            Self::Tomography(error) => error.fmt(f),
            Self::Condense(error) => error.fmt(f),
        }
    }
}
