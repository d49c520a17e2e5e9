//! What is done to a known flow.

use crate::problem::Precision;
use crate::progress::Mode;
use std::path::PathBuf;
use thurible_core::{Refinement, Turbulence, Yielding};

/// What is done to a flow.
#[derive(Clone, Debug)]
pub(crate) enum Deed {
    /// Its density is carried again, on cells so many times as fine.
    Readvect { scale: usize },
    /// It goes to cells so many times as fine, with turbulence that its own were too coarse for.
    Upsample { factor: usize, turbulence: Turbulence },
    /// It gets the solid cells of a file; whether what is dyed should keep its flow, and how dear the vorticity of the change is.
    Remap {
        solid: PathBuf,
        weighted: bool,
        smoothness: f64,
    },
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
            Self::Upsample { .. } => "upsample",
            Self::Remap { .. } => "remap",
        }
    }

    /// How many times as fine the cells are.
    pub fn scale(&self) -> usize {
        match self {
            Self::Readvect { scale } => *scale,
            Self::Upsample { factor, .. } => *factor,
            Self::Remap { .. } => 1,
        }
    }

    /// What is done to the flow of each step.
    pub fn refinement(&self, threads: usize) -> Refinement {
        let doublings = self.scale().checked_ilog2().unwrap_or(0) as usize;
        let plain = Refinement {
            doublings,
            threads,
            ..Refinement::default()
        };
        match *self {
            Self::Readvect { .. } => plain,
            Self::Upsample { turbulence, .. } => Refinement {
                turbulence: Some(turbulence),
                ..plain
            },
            Self::Remap {
                weighted, smoothness, ..
            } => Refinement {
                weighted: (weighted || smoothness > 0.0).then_some(Yielding {
                    smoothness,
                    ..Yielding::default()
                }),
                ..plain
            },
        }
    }
}
