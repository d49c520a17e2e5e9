//! `thurible deblur`: a sharp image from a blurred one and its kernel.

mod job;
mod light;
mod psf;
mod request;
mod written;

pub(crate) use job::restore;
pub(crate) use light::{Light, interleaved};
pub(crate) use psf::Psf;
pub(crate) use request::Request;
