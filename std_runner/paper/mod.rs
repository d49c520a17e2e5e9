//! The scenes of the paper's Table 2 and figures, and the page that puts results beside the paper's own figures.

mod catalogue;
mod page;
mod sections;
mod selection;
mod tables;
pub(crate) mod verdict;

pub(crate) use catalogue::Entry;
pub(crate) use page::page;
pub(crate) use sections::SECTIONS;
pub(crate) use selection::{Selection, known};
pub(crate) use tables::{SolvedScene, table};
