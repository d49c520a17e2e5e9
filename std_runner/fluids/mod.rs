//! Stable Fluids by a scene: planned, searched or simulated in one block of memory, written a step at a time.

mod checked;
mod inputs;
mod job;
mod plan;
mod played;
mod record;
mod search;
mod written;

pub(crate) use checked::check as check_gradient;
pub(crate) use plan::{planned, print_plan};

use crate::address_space;
use crate::exit::Failure;
use crate::run::{Outcome, Request, RunOptions};
use crate::threads;
use job::Job;

/// Solves the scene of `request`, or simulates it where it has no keyframes, into its folder.
pub(crate) fn solve(options: &RunOptions, request: Request) -> Result<Outcome, Failure> {
    let planned = planned(&request.scene, &options.plan)?;
    let count = planned.params.threads;
    address_space::check(count)?;
    threads::with(count, || Job::new(*options, request, planned)?.run())?
}
