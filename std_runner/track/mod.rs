//! `thurible track`: the flow behind frames of smoke, from files to a result folder.
//!
//! Frames are read one by one and results written one by one, so that a sequence of any length runs in the memory of three frames and one
//! solve.

mod errors;
mod files;
mod given;
mod job;
mod page;
mod plan;
mod record;
mod scene;
mod store;
mod wheel;

pub(crate) use job::{Request, run};
pub(crate) use plan::{print_plan, planned};
pub(crate) use scene::CaptureScene;
