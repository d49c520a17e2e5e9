//! Why a call was refused.

use crate::result::ThuribleResult;
use core::fmt;
use thurible_core::condense::CondenseError;
use thurible_core::operator::OperatorError;
use thurible_core::tomography::{Fault, TomographyError};
use thurible_core::{InputError, SavedError};

/// Why the last call was refused.
#[derive(Clone, Copy, Debug)]
pub enum Refusal {
    /// As the code says.
    Result(ThuribleResult),
    /// A field was refused.
    Input(InputError),
    /// Saved bytes were refused.
    Saved(SavedError),
    /// Something of a reconstruction was refused.
    Tomography(TomographyError),
    /// Something of an operator was refused.
    Operator(OperatorError),
    /// What was given to a body was refused.
    Condense(CondenseError),
}

impl fmt::Display for Refusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Result(ThuribleResult::Ok) => Ok(()),
            Self::Result(result) => f.write_str(result.words()),
            Self::Input(error) => error.fmt(f),
            Self::Saved(error) => error.fmt(f),
            Self::Tomography(error) => error.fmt(f),
            Self::Operator(error) => error.fmt(f),
            Self::Condense(error) => error.fmt(f),
        }
    }
}

impl From<ThuribleResult> for Refusal {
    fn from(result: ThuribleResult) -> Self {
        Self::Result(result)
    }
}

impl From<InputError> for Refusal {
    fn from(error: InputError) -> Self {
        Self::Input(error)
    }
}

impl From<SavedError> for Refusal {
    fn from(error: SavedError) -> Self {
        Self::Saved(error)
    }
}

impl From<TomographyError> for Refusal {
    fn from(error: TomographyError) -> Self {
        Self::Tomography(error)
    }
}

impl Refusal {
    /// What the call returns.
    pub(super) fn result(self) -> ThuribleResult {
        match self {
            Self::Result(result) => result,
            Self::Input(error) => error.into(),
            Self::Saved(error) => error.into(),
            Self::Tomography(error) => error.into(),
            Self::Operator(error) => error.into(),
            Self::Condense(error) => error.into(),
        }
    }
}

impl From<CondenseError> for Refusal {
    fn from(error: CondenseError) -> Self {
        Self::Condense(error)
    }
}

impl From<OperatorError> for Refusal {
    fn from(error: OperatorError) -> Self {
        Self::Operator(error)
    }
}

impl From<OperatorError> for ThuribleResult {
    fn from(error: OperatorError) -> Self {
        match error {
            OperatorError::Input { error, .. } => error.into(),
            OperatorError::NotSimulated | OperatorError::NothingKept => ThuribleResult::NoResult,
            _ => ThuribleResult::Unknown,
        }
    }
}

impl From<TomographyError> for ThuribleResult {
    fn from(error: TomographyError) -> Self {
        match error {
            TomographyError::Pixels {
                fault: Fault::Count { .. },
                ..
            } => ThuribleResult::Length,
            TomographyError::Pixels {
                fault: Fault::NotFinite { .. },
                ..
            } => ThuribleResult::NotFinite,
            TomographyError::Dark => ThuribleResult::Dark,
            TomographyError::TooLarge => ThuribleResult::TooLarge,
            TomographyError::Memory { .. } => ThuribleResult::TooSmall,
            _ => ThuribleResult::Config,
        }
    }
}
