//! Why a problem is refused, in words.

use super::{CELLS, Feature, MAX_FILTERS, MAX_STEPS, ShareError, TemplateError};
use crate::grid::spectrum::MOST_OPEN;
use crate::words::Named;
use core::fmt;

/// Why a [`Problem`](super::Problem) is refused.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum ProblemError {
    /// `cells` has not as many entries as the solver has dimensions.
    Dimensions {
        /// Entries expected.
        expected: usize,
        /// Entries given.
        given: usize,
    },
    /// An entry of `cells` is not from 4 to 4096.
    Cells {
        /// The axis.
        axis: usize,
        /// The entry.
        given: usize,
    },
    /// `boundary` has not one entry for each axis.
    Boundary {
        /// Entries given.
        given: usize,
    },
    /// `steps` is below 2.
    Steps {
        /// The value.
        given: usize,
    },
    /// There is no keyframe.
    NoKeyframe,
    /// A keyframe is not from 2 to N.
    Keyframe {
        /// Its step.
        step: usize,
        /// N.
        steps: usize,
    },
    /// A keyframe is not from 1 to N, where the method has them from the first step on.
    KeyframeFrom1 {
        /// Its step.
        step: usize,
        /// N.
        steps: usize,
    },
    /// More states are to be kept than there are steps.
    Slots {
        /// How many.
        given: usize,
        /// N.
        steps: usize,
    },
    /// A second solve stands for the adjoint of conjugate gradients alone.
    SecondSolve,
    /// Keyframes are not in ascending order.
    Order {
        /// The step that is not above the one before it.
        step: usize,
    },
    /// A number is not positive and finite.
    NotPositive {
        /// The field.
        field: &'static str,
        /// The value.
        given: f64,
    },
    /// A number is negative or not finite.
    Negative {
        /// The field.
        field: &'static str,
        /// The value.
        given: f64,
    },
    /// A number is not finite.
    NotFinite {
        /// The field.
        field: &'static str,
        /// The value.
        given: f64,
    },
    /// A number is not at least 0 and below 1.
    NotFraction {
        /// The field.
        field: &'static str,
        /// The value.
        given: f64,
    },
    /// A number is not above 0 and below another one.
    NotWithin {
        /// The field.
        field: &'static str,
        /// The value.
        given: f64,
        /// What it must be below.
        limit: f64,
    },
    /// A number is not from 0 to a bound.
    NotUpTo {
        /// The field.
        field: &'static str,
        /// The value.
        given: f64,
        /// The bound.
        most: f64,
    },
    /// The method cannot do what the problem asks for.
    Unfit {
        /// The method.
        method: &'static str,
        /// What it cannot.
        feature: Feature,
    },
    /// Ranks cannot share the box so.
    Share(ShareError),
    /// Only limited transport goes around solid cells.
    SolidScheme,
    /// Only limited transport lets smoke out of open sides.
    OpenScheme,
    /// An axis with an open side is too long.
    OpenCells {
        /// The axis.
        axis: usize,
        /// Its cells.
        given: usize,
    },
    /// A flow sticks to surfaces by its viscosity, and it has none.
    SticksWithoutViscosity,
    /// Smoke leaves by open sides, so that keyframes cannot be scaled to its mass.
    MassLeaves,
    /// A list has more entries than there are keyframes.
    Weights {
        /// Its entries.
        given: usize,
    },
    /// An emitter's steps are not ascending, or beyond the end.
    EmitterSteps {
        /// Its number.
        index: usize,
        /// N.
        steps: usize,
    },
    /// Smoke that is filled up to a target is not known before, so keyframes cannot be scaled to its mass.
    MassUnknown {
        /// The emitter's number.
        index: usize,
    },
    /// A keyframe is after the release.
    KeyframeReleased {
        /// Its step.
        step: usize,
        /// The release.
        release: usize,
    },
    /// `release` is not from 2 to N - 1.
    Release {
        /// The value.
        given: usize,
        /// N.
        steps: usize,
    },
    /// The schedule's steps are not ascending.
    ScheduleOrder {
        /// The step that is not above the one before it.
        step: usize,
    },
    /// The method takes templates, and there is none.
    NoTemplate,
    /// A template is wrong.
    Template {
        /// Its number.
        index: usize,
        /// What is wrong.
        error: TemplateError,
    },
    /// `filters` is above 12.
    Filters {
        /// The value.
        given: usize,
    },
}

impl fmt::Display for ProblemError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Dimensions { expected, given } => {
                write!(f, "cells has {given} entries where {expected} are needed")
            }
            Self::Cells { axis, given } => write!(
                f,
                "cells[{axis}] is {given}; it must be from {} to {}",
                CELLS.start(),
                CELLS.end()
            ),
            Self::Boundary { given } => write!(f, "boundary has {given} entries; it needs one for each axis"),
            Self::Steps { given } => write!(f, "steps is {given}; it must be from 2 to {MAX_STEPS}"),
            Self::NoKeyframe => write!(f, "there is no keyframe; at least one is needed"),
            Self::Keyframe { step, steps } => write!(
                f,
                "a keyframe is at step {step}; it must be from 2 to steps = {steps}"
            ),
            Self::KeyframeFrom1 { step, steps } => write!(
                f,
                "a keyframe is at step {step}; it must be from 1 to steps = {steps}"
            ),
            Self::Slots { given, steps } => write!(
                f,
                "slots is {given}; it must be from 1 to steps = {steps}, or 0 for all that the adjoint reads"
            ),
            Self::SecondSolve => write!(
                f,
                "adjoint is second_solve, which only conjugate gradients have; take pressure = \"cg\", or adjoint = \"exact\""
            ),
            Self::Order { step } => write!(f, "the keyframe at step {step} is not after the one before it"),
            Self::NotPositive { field, given } => {
                write!(f, "{field} is {given}; it must be positive and finite")
            }
            Self::Negative { field, given } => {
                write!(f, "{field} is {given}; it must be at least 0 and finite")
            }
            Self::NotFinite { field, given } => write!(f, "{field} is {given}; it must be finite"),
            Self::NotFraction { field, given } => {
                write!(f, "{field} is {given}; it must be at least 0 and below 1")
            }
            Self::NotWithin { field, given, limit } => {
                write!(f, "{field} is {given}; it must be above 0 and below {limit}")
            }
            Self::NotUpTo { field, given, most } => {
                write!(f, "{field} is {given}; it must be from 0 to {most}")
            }
            Self::Unfit { method, feature } => {
                write!(
                    f,
                    "the method {method} knows no {}; take another method, or leave it out",
                    feature.name()
                )
            }
            Self::Share(error) => error.fmt(f),
            Self::SolidScheme => write!(f, "only limited transport goes around solid cells; take that"),
            Self::OpenScheme => write!(
                f,
                "only limited transport lets smoke out of open sides; take that"
            ),
            Self::OpenCells { axis, given } => write!(
                f,
                "cells[{axis}] is {given}; along an axis with open sides at most {MOST_OPEN} are possible"
            ),
            Self::SticksWithoutViscosity => write!(
                f,
                "the flow is to stick to walls and obstacles, which it does by its viscosity, and that is 0; give it some, or let it slip"
            ),
            Self::MassLeaves => write!(
                f,
                "smoke leaves by open sides, so the mass of a keyframe is not known before; take match_mass = false"
            ),
            Self::Weights { given } => write!(f, "there are {given} weights, more than keyframes"),
            Self::EmitterSteps { index, steps } => write!(
                f,
                "emitter {index} must emit from a step to a later one, at most steps = {steps}"
            ),
            Self::MassUnknown { index } => write!(
                f,
                "emitter {index} fills up to a target, so the mass of the smoke is not known before; take match_mass = false, or a rate"
            ),
            Self::KeyframeReleased { step, release } => write!(
                f,
                "a keyframe is at step {step}, after the release at step {release}; no force leads to it"
            ),
            Self::Release { given, steps } => write!(
                f,
                "release is {given}; it must be from 2 to a step before the end at {steps}"
            ),
            Self::ScheduleOrder { step } => {
                write!(f, "the schedule's step {step} is not after the one before it")
            }
            Self::NoTemplate => write!(
                f,
                "there is no template; at least one is needed, or another method"
            ),
            Self::Template { index, error } => write!(f, "template {index} {error}"),
            Self::Filters { given } => write!(f, "filters is {given}; it must be at most {MAX_FILTERS}"),
        }
    }
}

impl core::error::Error for ProblemError {}
