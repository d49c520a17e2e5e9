//! `thurible track`: the flow behind frames of smoke, from files to a result folder.
//!
//! Frames are read one by one and results written one by one, so that a sequence of any length runs in the memory of three frames and one
//! solve.

mod album;
mod arrays;
mod emission;
mod ending;
mod errors;
mod files;
mod given;
mod job;
mod middle;
mod page;
mod plan;
mod record;
mod scene;
mod wheel;

pub(crate) use job::{Request, run};
pub(crate) use middle::Middle;
pub(crate) use plan::{planned, print_plan};
pub(crate) use scene::CaptureScene;
pub(crate) use wheel::{Plane, wheel};
