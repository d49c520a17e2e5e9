//! The objective J (paper eq. 5) and its gradient: what is given for each step, the data term, the density sweep forward and back in time, J as a
//! function of the flow alone, and the same scene on coarser grids.

pub mod coarse;
pub mod data_term;
pub mod feasible;
pub mod flow;
mod force_term;
mod gradient;
pub mod script;
pub mod sweep;
