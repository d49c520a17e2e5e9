//! Stable Fluids: reference data, adjoints, gradients, memory and bits.

mod adjoints;
pub mod case;
mod gradients;
mod memory;
mod operator;
mod reference;
mod refusals;
mod saved;
mod solves;
