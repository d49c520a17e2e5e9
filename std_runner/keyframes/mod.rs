//! Shapes: what a scene says in words, files and pictures becomes a density on the cells of a grid.
//!
//! A [`ShapeSpec`] is one table of the scene file. [`ShapeSpec::rasterise`] fills the cells of a [`Canvas`] with
//! `0.5 - 0.5 tanh(signed distance / h)` for everything that has a signed distance (circle, box, torus, capsule,
//! text), with as soft an edge for meshes, and with resampled values for pictures and arrays. A list of shapes is added up and clipped.

mod array;
mod build;
mod canvas;
mod caption;
mod check;
mod decode;
mod earlier;
mod ending;
mod error;
mod font;
mod frames;
mod header;
mod image;
mod ink;
mod measured;
mod mesh;
mod note;
mod npy;
mod npz;
mod outline;
mod raster;
mod resample;
mod series;
mod shaping;
mod solid;
mod spec;
mod text;
mod vdb;
mod velocity;
mod whole;

pub use array::steps_of_array;
pub use canvas::Canvas;
pub(crate) use caption::caption;
pub(crate) use decode::is_picture;
pub use earlier::Earlier;
pub(crate) use ending::ends_with;
pub use error::ShapeError;
pub use frames::{Frame, Frames, has_array};
pub(crate) use measured::{Measured, Measurements, measured};
pub(crate) use mesh::files_beside;
pub use note::Note;
pub(crate) use raster::DENSEST;
pub use series::Series;
pub(crate) use series::array_names;
pub use spec::ShapeSpec;
pub(crate) use velocity::VELOCITY;
pub use velocity::{read_centered_velocity, read_velocity};
