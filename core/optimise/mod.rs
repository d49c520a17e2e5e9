//! Minimisation over trajectories, without knowledge of what is minimised.

pub mod descent;
pub mod quasi_newton;
