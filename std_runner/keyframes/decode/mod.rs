//! Pictures of every kind as pixels: PNG, JPEG, TIFF, WebP, EXR and SVG, by what is in the file, not by its name.

mod exr;
mod kind;
mod matte;
mod photo;
mod pixels;
mod planes;
mod png;
mod room;
mod svg;
mod tiff;
mod webp;

pub(crate) use kind::is_picture;
pub(super) use kind::read;
pub(super) use pixels::Pixels;
