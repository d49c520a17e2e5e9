//! Stable Fluids: reference data, adjoints, gradients, memory and bits.

mod adjoints;
pub mod case;
mod gradients;
mod memory;
#[path = "../../program/support/npz.rs"]
#[allow(dead_code, reason = "the program's tests write arrays too")]
mod npz;
mod operator;
mod reference;
mod refusals;
mod solves;
