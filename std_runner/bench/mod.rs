//! `thurible bench`: what this machine does. For now its memory.

pub mod memory;
mod page;

use crate::cli::{BenchArguments, Benchmark};
use crate::exit::Failure;

/// Runs `bench`.
pub fn run(arguments: &BenchArguments) -> Result<u8, Failure> {
    match &arguments.what {
        Some(Benchmark::Memory(arguments)) => memory::run(arguments),
        None => Err(Failure::Input("there is no speed table yet; write `thurible bench memory` for the memory table".into())),
    }
}
