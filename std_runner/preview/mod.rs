//! `thurible scene check`: everything that a scene draws, in one picture with its masses, and what is probably not meant, before an hour is
//! spent.

mod dilate;
mod findings;
mod layers;
mod sheet;

pub(crate) use findings::findings;
pub(crate) use layers::{cell_volume, layers};
pub(crate) use sheet::{sheet, shown};
