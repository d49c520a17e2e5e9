//! What pages share that put our own figures beside those of a publication: names on the command line, the scale of grids, and the machine that
//! the figures were made on.

mod machine;
mod names;
mod scale;

pub use scale::Scale;

pub(crate) use machine::machine;
pub(crate) use names::Names;

/// What stands where a publication, or a row without a result, has no figure.
pub(crate) const NOT_GIVEN: &str = "\u{2013}";
