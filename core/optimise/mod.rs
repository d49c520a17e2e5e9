//! Minimisation over trajectories, without knowledge of what is minimised.

mod course;
pub mod descent;
mod function;
pub mod line_search;
pub mod quasi_newton;
