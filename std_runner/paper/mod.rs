//! The scenes of the paper's Table 2 and figures, and the page that puts results beside the paper's own figures.

mod catalogue;
mod page;
mod scale;
mod sections;
mod selection;
mod tables;
pub(crate) mod verdict;

pub use scale::Scale;

pub(crate) use catalogue::Entry;
pub(crate) use page::page;
pub(crate) use sections::{GROUPS, SECTIONS};
pub(crate) use selection::Selection;
pub(crate) use tables::{SolvedScene, table};
