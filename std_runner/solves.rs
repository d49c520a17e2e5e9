//! The door of all scenes: each goes to what solves it.

use crate::exit::Failure;
use crate::fluids;
use crate::run::{Outcome, Request, RunOptions};

/// Solves the scene of `request` into its folder.
pub(crate) fn solve(options: &RunOptions, request: Request) -> Result<Outcome, Failure> {
    if request.scene.method.fluids.chosen {
        fluids::solve(options, request)
    } else {
        options.solve(request)
    }
}
