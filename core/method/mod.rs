//! The methods: ways to solve a problem, or to simulate it.

pub mod admm;
pub mod direct;
pub mod lbfgs;
pub mod simulate;
