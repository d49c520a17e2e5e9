//! Result files: `result.npz` in the precision of the solve, frames and an animation as PNG.
//!
//! A solver shows itself as [`Frames`], one field at a time, so that no second copy of a trajectory is needed. Pictures are
//! drawn from the written numbers, when the solver and its block of memory are gone.

mod animation;
mod archive;
mod densities;
mod error;
mod exr;
mod file;
mod frames;
mod gallery;
mod lines;
mod lists;
mod middle;
mod movie;
mod npz;
mod picture;
mod plate;
mod quiet;
mod reel;
mod render;
mod series;
mod store;
mod webp;

pub use error::OutputError;
pub use frames::{Frames, Given, GivenValues, Precision, Sample, Samples};

pub(crate) use archive::{Plain, array_name, write_archive, write_arrays};
pub(crate) use densities::{Densities, Pictured, Places, Shown, densities_of, full};
pub(crate) use file::{create_folder, sync_file, sync_folder, write_bytes, write_whole};
pub(crate) use gallery::{ANIMATION, Gallery, KeyframePictures, frame, strip_steps};
pub(crate) use lines::Vectors;
pub(crate) use lists::{List, Values, write_lists};
pub(crate) use middle::middle;
pub(crate) use movie::Movie;
pub(crate) use npz::write_npz;
pub(crate) use picture::{Colours, Picture};
pub(crate) use plate::{Tone, colour_plate, plate};
pub(crate) use reel::{Reel, Still};
pub(crate) use render::{Angles, Body, Field, Film, Over, Shot, Smoke, arrow_side};
pub(crate) use series::Series;
pub(crate) use store::Store;
pub(crate) use webp::WEBP_MOST;
