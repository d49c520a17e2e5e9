//! OpenVDB volumes of floats, full or half, plain or packed by zip or Blosc's LZ4: versions 222 to 224 of the format, which programs write since
//! 2013.

mod bytes;
mod codec;
mod container;
mod dense;
mod draw;
mod gather;
mod tree;

pub(super) use dense::{Bounds, bounds, frame};
pub(super) use draw::draw;
