//! The scenes of the paper's Table 2 and figures, and the page that puts results beside the paper's own figures.

mod catalogue;
mod page;
mod scale;
mod sections;
mod selection;

pub use scale::Scale;

pub(crate) use catalogue::Entry;
pub(crate) use page::{SolvedScene, page, table};
pub(crate) use sections::{GROUPS, SECTIONS};
pub(crate) use selection::Selection;
