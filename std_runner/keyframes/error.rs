//! Why a shape was refused.

use crate::exit::Failure;
use std::io;
use std::path::{Path, PathBuf};

/// A shape that cannot be drawn: what was found, and what to write instead.
#[derive(Debug, thiserror::Error)]
pub enum ShapeError {
    /// A key of the scene file has a value that is not allowed.
    #[error("`{key}` {found}; {remedy}")]
    Key {
        /// The key, with the shape it belongs to: `circle.radius`.
        key: String,
        /// What was found.
        found: String,
        /// What is allowed and what to do.
        remedy: String,
    },
    /// A file was read, and what is in it will not do.
    #[error("`{key}` file `{}` {found}; {remedy}", path.display())]
    File {
        /// The key that names the file.
        key: String,
        /// The file, as it was looked for.
        path: PathBuf,
        /// What was found.
        found: String,
        /// What is allowed and what to do.
        remedy: String,
    },
    /// A file could not be read at all.
    #[error("`{key}` file `{}` cannot be read ({source}); check the name and its permissions (a relative path in a scene starts at the folder of that scene)", path.display())]
    Read {
        /// The key that names the file.
        key: String,
        /// The file, as it was looked for.
        path: PathBuf,
        /// What the operating system said.
        source: io::Error,
    },
}

impl ShapeError {
    /// True where the file could not be read, as opposed to bad content (the program ends with another exit code).
    pub fn is_unreadable(&self) -> bool {
        matches!(self, Self::Read { .. })
    }

    /// The failure that says `sentence`, with the exit code that belongs to this.
    pub(crate) fn failure(&self, sentence: String) -> Failure {
        if self.is_unreadable() {
            Failure::File(sentence)
        } else {
            Failure::Input(sentence)
        }
    }

    pub(super) fn key(key: impl Into<String>, found: impl Into<String>, remedy: impl Into<String>) -> Self {
        Self::Key {
            key: key.into(),
            found: found.into(),
            remedy: remedy.into(),
        }
    }
}

/// What is wrong with the content of a file, before it is known which key named the file.
#[derive(Debug)]
pub(super) enum Fault {
    Read(io::Error),
    Content { found: String, remedy: String },
}

impl Fault {
    pub(super) fn content(found: impl Into<String>, remedy: impl Into<String>) -> Self {
        Self::Content {
            found: found.into(),
            remedy: remedy.into(),
        }
    }

    /// The same of an entry along the first axis.
    pub(super) fn of_entry(self, entry: Option<usize>) -> Self {
        match (self, entry) {
            (Self::Content { found, remedy }, Some(entry)) => Self::Content {
                found: format!("{found} of entry {entry}"),
                remedy,
            },
            (fault, _) => fault,
        }
    }

    /// The error of the user's `key`, which named `path`.
    pub(super) fn of(self, key: &str, path: &Path) -> ShapeError {
        let (key, path) = (key.to_owned(), path.to_owned());
        match self {
            Self::Read(source) => ShapeError::Read { key, path, source },
            Self::Content { found, remedy } => ShapeError::File {
                key,
                path,
                found,
                remedy,
            },
        }
    }
}

impl From<io::Error> for Fault {
    fn from(error: io::Error) -> Self {
        Self::Read(error)
    }
}
