//! Why a result could not be written.

use crate::exit::Failure;
use crate::keyframes::ShapeError;
use std::io;
use std::path::{Path, PathBuf};

/// A result file that could not be written.
#[derive(Debug, thiserror::Error)]
pub enum OutputError {
    /// The operating system refused.
    #[error("cannot write `{}` ({source}); check that the folder can be written to and that the disc has room, or choose another one by `-o`", path.display())]
    Write {
        /// The file or folder.
        path: PathBuf,
        /// What the operating system said.
        source: io::Error,
    },
    /// A file that was written could not be read back.
    #[error("cannot read `{}` back ({source}); check the disc, or solve again into another folder by `-o`", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// What the operating system said.
        source: io::Error,
    },
    /// What was to be written could not be had.
    #[error("{0}")]
    Source(Failure),
    /// A field had another number of values than its grid.
    #[error("cannot write `{}`: {array} has {found} values where its grid has {expected}; this is a fault of thurible, please report it", path.display())]
    Size {
        /// The file.
        path: PathBuf,
        /// The array.
        array: String,
        /// Values that came.
        found: usize,
        /// Values that its shape has.
        expected: usize,
    },
}

impl OutputError {
    /// For `map_err`: the error of writing `path`.
    pub(crate) fn of<E: Into<io::Error>>(path: &Path) -> impl Fn(E) -> Self {
        move |error| Self::Write {
            path: path.to_owned(),
            source: error.into(),
        }
    }

    /// For `map_err`: the error of reading `path` back.
    pub(crate) fn unread<E: Into<io::Error>>(path: &Path) -> impl Fn(E) -> Self {
        move |error| Self::Read {
            path: path.to_owned(),
            source: error.into(),
        }
    }

    /// For `map_err`: the error of an archive that is not what was written.
    pub(crate) fn unusable(error: ShapeError) -> Self {
        let sentence = error.to_string();
        Self::Source(error.failure(sentence))
    }
}

impl From<OutputError> for Failure {
    fn from(error: OutputError) -> Self {
        match error {
            OutputError::Source(failure) => failure,
            other => Self::File(other.to_string()),
        }
    }
}
