//! The objective J (paper eq. 5) and its gradient: keyframes and data term, the density sweep forward and back in time, J as a
//! function of the flow alone, and the same scene on coarser grids.

pub mod coarse;
mod feasible;
pub mod flow;
mod force_term;
pub mod keyframes;
pub mod sweep;
