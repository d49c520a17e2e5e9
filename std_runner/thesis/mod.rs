//! The figures and tables of J. Gregson, "Applications of inverse problems in fluids and imaging" (PhD thesis, UBC 2015), and the page that puts
//! our own rows beside the thesis'. Its captures and photographs are not part of the project: smoke is simulated ([`truth`]) and photographed,
//! images are drawn.
//!
//! A figure of the [`catalogue`] is a function that has runs made by a [`bench`], each once, and fills a [`sheet`] with rows, pictures and curves.

mod bench;
mod catalogue;
mod chapter3;
mod chapter4;
mod chapter5;
mod doors;
mod fields;
mod figure;
mod page;
mod pictures;
mod plays;
mod sheet;
mod truth;

pub(crate) use bench::{Bench, Halt};
pub(crate) use catalogue::{figures, known};
pub(crate) use figure::Figure;
pub(crate) use page::{Done, RULE, facts, overview, page};
pub(crate) use sheet::Sheet;
