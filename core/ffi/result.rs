//! What calls return, and how a solve ended.

use core::ffi::{CStr, c_char};
use thurible_core::condense::CondenseError;
use thurible_core::{InputError, PlanError, SavedError, SolverError, Status};

/// The version of this library: major * 65536 + minor * 256 + patch.
pub const THURIBLE_VERSION: u32 = 256;

/// What a call returns: 0, or why it was refused. What is refused changes nothing.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ThuribleResult {
    /// The call did what it was asked to do.
    Ok = 0,
    /// A pointer that must not be null is.
    Null = 1,
    /// A pointer is not aligned for what it points to.
    Misaligned = 2,
    /// The handle points to no instance: never made, closed, overwritten, or moved to another address.
    NoInstance = 3,
    /// The instance is in another call: of another thread, or of the callback that made this one.
    Busy = 4,
    /// The size of the configuration is that of no version this library knows.
    ConfigSize = 5,
    /// A field of the configuration is wrong; `thurible_explain` says which.
    Config = 6,
    /// The sizes do not fit this machine's addresses.
    TooLarge = 7,
    /// The memory has fewer bytes than planned.
    TooSmall = 8,
    /// An array has the wrong number of bytes.
    Length = 9,
    /// There is no such keyframe, emitter, axis, step, field, output or fact.
    Index = 10,
    /// A value is NaN or infinite.
    NotFinite = 11,
    /// A density is negative.
    Negative = 12,
    /// A density has no mass outside of solid cells.
    Empty = 13,
    /// There is no smoke yet: the source must be set first, or an emitter that has begun.
    NoSource = 14,
    /// A keyframe was not set.
    NoKeyframe = 15,
    /// There is no result: the solve was not finished, or went on since; an operator did not simulate or differentiate before.
    NoResult = 16,
    /// The executor has no function, no thread, or more threads than were planned for.
    Executor = 17,
    /// The bytes are no saved instance.
    NotSaved = 18,
    /// The saved instance is in a format that this library does not read.
    SavedFormat = 19,
    /// The saved instance is of another scene, precision, method or choice.
    SavedOther = 20,
    /// The saved instance is damaged.
    SavedDamaged = 21,
    /// A value of a region, or a flag of a solid cell, is above 1.
    AboveOne = 22,
    /// The shape of an emitter must be set first.
    NoEmitter = 23,
    /// All cells are solid.
    NoFluid = 24,
    /// The flow that the method follows was not set.
    NoReference = 25,
    /// The library's fault: a refusal that this interface has no word for.
    Unknown = 26,
    /// A frame, or the picture of a camera, that this needs was not given or not begun.
    NoFrame = 27,
    /// The tracker was stopped in a pair, or left the finite numbers there: begin another one.
    Ended = 28,
    /// It must be given before the first frame, solid cells before every density.
    Late = 29,
    /// All pictures are dark.
    Dark = 30,
    /// What is made between frames was given where the configuration has no `emission`.
    NoEmission = 31,
}

impl ThuribleResult {
    const ALL: [(Self, &'static CStr); 32] = [
        (Self::Ok, c"done"),
        (Self::Null, c"a pointer that must not be null is"),
        (Self::Misaligned, c"a pointer is not aligned"),
        (
            Self::NoInstance,
            c"the handle points to no instance: never made, closed, overwritten or moved",
        ),
        (Self::Busy, c"the instance is in another call"),
        (
            Self::ConfigSize,
            c"the size of the configuration is that of no known version",
        ),
        (Self::Config, c"a field of the configuration is wrong"),
        (Self::TooLarge, c"the sizes do not fit this machine's addresses"),
        (Self::TooSmall, c"the memory has fewer bytes than planned"),
        (Self::Length, c"an array has the wrong number of bytes"),
        (
            Self::Index,
            c"there is no such keyframe, emitter, axis, step, field, output or fact",
        ),
        (Self::NotFinite, c"a value is not finite"),
        (Self::Negative, c"a density is negative"),
        (Self::Empty, c"a density has no mass outside of solid cells"),
        (
            Self::NoSource,
            c"there is no smoke yet: the source must be set first, or an emitter that has begun",
        ),
        (Self::NoKeyframe, c"a keyframe was not set"),
        (
            Self::NoResult,
            c"there is no result: the solve was not finished, or went on since",
        ),
        (
            Self::Executor,
            c"the executor has no function, no thread, or more threads than were planned for",
        ),
        (Self::NotSaved, c"the bytes are no saved instance"),
        (
            Self::SavedFormat,
            c"the saved instance is in a format that is not read",
        ),
        (
            Self::SavedOther,
            c"the saved instance is of another scene, precision, method or choice",
        ),
        (Self::SavedDamaged, c"the saved instance is damaged"),
        (
            Self::AboveOne,
            c"a value of a region, or a flag of a solid cell, is above 1",
        ),
        (Self::NoEmitter, c"the shape of an emitter must be set first"),
        (Self::NoFluid, c"all cells are solid"),
        (Self::NoReference, c"the flow that the method follows was not set"),
        (Self::Unknown, c"a refusal that this interface has no word for"),
        (
            Self::NoFrame,
            c"a frame, or the picture of a camera, that this needs was not given or not begun",
        ),
        (
            Self::Ended,
            c"the tracker was stopped in a pair, or left the finite numbers there: begin another one",
        ),
        (
            Self::Late,
            c"it must be given before the first frame, solid cells before every density",
        ),
        (Self::Dark, c"all pictures are dark"),
        (
            Self::NoEmission,
            c"what is made between frames was given where the configuration has no `emission`",
        ),
    ];
}

impl ThuribleResult {
    /// A few words for it.
    #[must_use]
    pub fn words(self) -> &'static str {
        let found = Self::ALL.iter().find(|(code, _)| *code == self);
        found.and_then(|(_, text)| text.to_str().ok()).unwrap_or("")
    }
}

impl From<InputError> for ThuribleResult {
    fn from(error: InputError) -> Self {
        match error {
            InputError::Length { .. } => Self::Length,
            InputError::NotFinite { .. } => Self::NotFinite,
            InputError::Negative { .. } => Self::Negative,
            InputError::Empty | InputError::Buried => Self::Empty,
            InputError::Index { .. } => Self::Index,
            InputError::NoSource => Self::NoSource,
            InputError::AboveOne { .. } => Self::AboveOne,
            InputError::NoEmitter { .. } => Self::NoEmitter,
            InputError::NoFluid => Self::NoFluid,
            InputError::SolidsLate => Self::Late,
            InputError::NoKeyframe { .. } => Self::NoKeyframe,
            InputError::NoReference => Self::NoReference,
            InputError::NoEmission => Self::NoEmission,
            _ => Self::Unknown,
        }
    }
}

impl From<SavedError> for ThuribleResult {
    fn from(error: SavedError) -> Self {
        match error {
            SavedError::Length { .. } => Self::Length,
            SavedError::NotSaved => Self::NotSaved,
            SavedError::Format { .. } => Self::SavedFormat,
            SavedError::OtherSolve => Self::SavedOther,
            SavedError::Damaged => Self::SavedDamaged,
            _ => Self::Unknown,
        }
    }
}

impl From<CondenseError> for ThuribleResult {
    fn from(error: CondenseError) -> Self {
        match error {
            CondenseError::TooLarge => Self::TooLarge,
            CondenseError::Memory { .. } => Self::TooSmall,
            CondenseError::Values => Self::NotFinite,
            _ => Self::Config,
        }
    }
}

impl From<PlanError> for ThuribleResult {
    fn from(error: PlanError) -> Self {
        match error {
            PlanError::TooLarge => Self::TooLarge,
            _ => Self::Config,
        }
    }
}

impl From<SolverError> for ThuribleResult {
    fn from(error: SolverError) -> Self {
        match error {
            SolverError::Plan(error) => error.into(),
            SolverError::TooSmall { .. } => Self::TooSmall,
            SolverError::Misaligned => Self::Misaligned,
            _ => Self::Unknown,
        }
    }
}

/// How a solve ended. Data, not an error.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ThuribleStatus {
    /// It did not end: there is more to do.
    #[default]
    Goes = 0,
    /// The method's own rule says so.
    Converged = 1,
    /// The iterations were used up.
    MaxIterations = 2,
    /// It no longer moves, but does not satisfy the rule of convergence.
    Stalled = 3,
    /// Of a step: nothing that it tries is finite, or slow enough to be transported, and finishing gives the last flow that was. Of a
    /// finish or a solve: there is no such flow.
    NotFinite = 4,
    /// The observer said stop.
    Cancelled = 5,
    /// The source, a keyframe or the shape of an emitter is missing.
    NotReady = 6,
}

impl ThuribleStatus {
    const ALL: [(Self, &'static CStr); 7] = [
        (Self::Goes, c"goes on"),
        (Self::Converged, c"converged"),
        (Self::MaxIterations, c"ran its iterations"),
        (Self::Stalled, c"stalled"),
        (Self::NotFinite, c"left the finite numbers"),
        (Self::Cancelled, c"cancelled"),
        (Self::NotReady, c"not ready"),
    ];
}

impl From<Option<Status>> for ThuribleStatus {
    fn from(status: Option<Status>) -> Self {
        match status {
            None => Self::Goes,
            Some(Status::Converged) => Self::Converged,
            Some(Status::MaxIterations) => Self::MaxIterations,
            Some(Status::Stalled) => Self::Stalled,
            Some(Status::NotFinite) => Self::NotFinite,
            Some(Status::Cancelled) => Self::Cancelled,
            Some(Status::NotReady) => Self::NotReady,
        }
    }
}

fn word(found: Option<&'static CStr>) -> *const c_char {
    found.unwrap_or(c"no such code").as_ptr()
}

/// A few words for a `ThuribleResult`, in static memory.
#[unsafe(no_mangle)]
pub extern "C" fn thurible_result_text(result: u32) -> *const c_char {
    word(
        ThuribleResult::ALL
            .iter()
            .find(|(code, _)| *code as u32 == result)
            .map(|(_, text)| *text),
    )
}

/// A few words for a `ThuribleStatus`, in static memory.
#[unsafe(no_mangle)]
pub extern "C" fn thurible_status_text(status: u32) -> *const c_char {
    word(
        ThuribleStatus::ALL
            .iter()
            .find(|(code, _)| *code as u32 == status)
            .map(|(_, text)| *text),
    )
}

/// The version of the library that is linked: compare it with `THURIBLE_VERSION` of the header.
#[unsafe(no_mangle)]
pub extern "C" fn thurible_version() -> u32 {
    THURIBLE_VERSION
}
