//! Good inputs, small ones.

pub mod arrays;
pub mod bodies;
mod font;
pub mod kept;
pub mod pictures;
pub mod texts;

/// The folder of the whole project.
pub const ROOT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../..");
