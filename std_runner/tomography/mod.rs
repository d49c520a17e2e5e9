//! `thurible tomography`: density of smoke from what cameras see of it, and the photographs to try it with.
//!
//! A file of views ([`views`]) names a box, cameras ([`cameras`]) and their pictures ([`sources`]). All pictures are read and
//! checked before anything runs; then [`frames`] reconstructs them, each in its lane of one planned block, and [`written`] and
//! [`page`] write the result folder. [`rig`] takes the photographs of a known density.

mod cameras;
mod frames;
mod job;
mod novel;
mod page;
mod place;
mod plan;
mod raw;
mod request;
mod rig;
mod settings;
mod sources;
mod subject;
mod vector;
mod views;
mod written;

pub(crate) use job::reconstruct;
pub(crate) use request::Request;
pub(crate) use rig::photograph;
pub(crate) use subject::Rig;
pub(crate) use vector::{cross, dot, minus};
