//! The methods: ways to solve a problem, or to simulate it.
//!
//! A method is a folder: its choices, its state, and how it fulfils the [`contract`]. It is known to everything else by its entry in
//! the registry (`list.rs`).

pub mod admm;
pub mod animation;
pub mod choices;
mod coarse_start;
pub mod contract;
pub mod direct;
pub mod first_hessian;
pub mod lbfgs;
mod list;
pub mod output;
pub mod params;
pub mod refusal;
pub mod registry;
pub mod simulate;
pub mod templates;
