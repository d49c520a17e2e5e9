//! The objective J (paper eq. 5) and its gradient: keyframes and data term, the density sweep forward and back in time, J as a
//! function of the flow alone, and the same scene on coarser grids.

pub mod coarse;
pub mod flow;
pub mod keyframes;
pub mod sweep;
