//! `thurible deblur`: a sharp image from a blurred one and its kernel.

mod job;
mod light;
mod psf;
mod written;

pub(crate) use job::{Request, restore};
pub(crate) use light::Light;
