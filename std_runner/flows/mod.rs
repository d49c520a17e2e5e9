//! Known flows taken further, a step in memory at a time: smoke that they carry again, finer cells, other solid cells.

mod importance;
mod job;
mod known;
mod measure;
mod page;
mod place;
mod request;
mod walk;

pub(crate) use job::run;
pub(crate) use request::{Deed, Request};
