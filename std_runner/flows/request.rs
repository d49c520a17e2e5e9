//! What is done to a known flow.

use crate::problem::Precision;
use crate::progress::Mode;
use std::path::PathBuf;

/// What is done to a flow.
#[derive(Clone, Debug)]
pub(crate) enum Deed {
    /// Its density is carried again, on cells so many times as fine.
    Readvect { scale: usize },
    /// It gets the solid cells of a file; whether what is dyed should keep its flow.
    Remap { solid: PathBuf, weighted: bool },
}

/// What is asked for.
#[derive(Clone, Debug)]
pub(crate) struct Request {
    pub deed: Deed,
    /// The result folder.
    pub from: PathBuf,
    /// Where the new one goes.
    pub folder: PathBuf,
    /// The step to begin at.
    pub at: usize,
    /// That of the result, if none is given.
    pub precision: Option<Precision>,
    pub threads: usize,
    /// The ceiling in bytes, or `None` for the machine's memory.
    pub limit: Option<usize>,
    pub mode: Mode,
}

impl Deed {
    /// Its command.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Readvect { .. } => "readvect",
            Self::Remap { .. } => "remap",
        }
    }

    /// How many times as fine the cells are.
    pub fn scale(&self) -> usize {
        match self {
            Self::Readvect { scale } => *scale,
            Self::Remap { .. } => 1,
        }
    }
}
