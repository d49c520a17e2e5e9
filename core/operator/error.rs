//! Why an operator does not come to its end.

use crate::solver::InputError;
use crate::transport::Stop;
use core::fmt;

/// Why a simulation or its gradient is refused, or stopped.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum OperatorError {
    /// What was given is refused.
    Input {
        /// What it is.
        what: Input,
        /// Why.
        error: InputError,
    },
    /// The flow of a step is too fast, or not finite: its implicit equation has no solution that is found, or its Courant number is above 64.
    TooFast {
        /// The step, from 0.
        step: usize,
    },
    /// The observer said stop.
    Cancelled,
    /// Nothing was simulated that a gradient could be taken of.
    NotSimulated,
    /// Nothing is kept for the way back.
    NothingKept,
}

/// What a caller gives.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Input {
    /// The density rho_0.
    Density,
    /// The velocity v_0.
    Velocity,
    /// The shape of an emitter.
    Emitter {
        /// Its number.
        index: usize,
    },
    /// The force of a step.
    Force {
        /// The step.
        step: usize,
    },
    /// The covector of a step.
    Cotangent {
        /// The step.
        step: usize,
    },
}

impl Input {
    /// As the reason for an error.
    pub(super) fn refused(self) -> impl Fn(InputError) -> OperatorError {
        move |error| OperatorError::Input { what: self, error }
    }
}

impl OperatorError {
    /// Why step `step` stopped.
    pub(super) fn stopped(step: usize) -> impl Fn(Stop) -> Self {
        move |stop| match stop {
            Stop::TooFast => Self::TooFast { step },
            Stop::Cancelled => Self::Cancelled,
        }
    }
}

impl fmt::Display for Input {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Density => f.write_str("the density at the start"),
            Self::Velocity => f.write_str("the velocity at the start"),
            Self::Emitter { index } => write!(f, "the shape of emitter {index}"),
            Self::Force { step } => write!(f, "the force of step {step}"),
            Self::Cotangent { step } => write!(f, "the cotangent of step {step}"),
        }
    }
}

impl fmt::Display for OperatorError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Input { what, error } => write!(f, "{what} is refused: {error}"),
            Self::TooFast { step } => write!(
                f,
                "the flow of step {step} is too fast to be followed; take shorter steps, or weaker forces"
            ),
            Self::Cancelled => f.write_str("it was stopped"),
            Self::NotSimulated => f.write_str("nothing was simulated yet whose gradient could be taken"),
            Self::NothingKept => f.write_str("nothing is kept for the way back; choose how many states are"),
        }
    }
}

impl core::error::Error for OperatorError {}
