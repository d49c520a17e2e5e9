//! One solve: from a scene to its result folder.
//!
//! `RunOptions::solve` plans the scene and takes its one block of memory; the job solves it there, watched by
//! [`progress`](crate::progress), and writes the folder.

pub(crate) mod drawn;
mod earlier;
mod found;
pub mod frames;
pub mod inputs;
pub(crate) mod job;
mod masses;
pub(crate) mod messages;
pub(crate) mod outcome;
mod reach;
mod request;
pub(crate) mod saved;
mod settled;
mod shared;
mod stages;
mod targets;
mod whole;
mod windows;

pub(crate) use earlier::Origin;
pub(crate) use job::drawing_bytes;
pub(crate) use outcome::{Outcome, command_line};
pub(crate) use request::{Outputs, Request, RunOptions};
pub(crate) use shared::{share_of, unshared};

use crate::exit::Failure;
use crate::{address_space, devices, plan, threads};
use job::Job;

impl RunOptions {
    /// Solves the scene of `request`, which no Stable Fluids solve, into its folder.
    pub(crate) fn solve(&self, request: Request) -> Result<Outcome, Failure> {
        let planned = plan::choose(&request.scene, &self.plan)?;
        if let Some(device) = self.device {
            devices::check(device, &request.scene, &planned, &self.plan)?;
        }
        let threads = planned.params.threads;
        let (job, region) = Job::new(*self, request, planned)?;
        address_space::check(threads)?;
        threads::with(threads, || job.run(region))?
    }
}
