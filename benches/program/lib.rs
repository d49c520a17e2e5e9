//! `thurible-bench`: what this machine does. The parts that are public serve `cargo bench` too.

pub mod arguments;
mod circles;
mod files;
pub mod flow;
mod kernels;
pub mod machine;
pub mod memory;
pub mod navier_stokes;
pub mod pieces;
pub mod prepared;
mod printer;
mod process;
mod roofline;
mod row;
mod scaling;
pub mod scenes;
mod section;
mod solves;
mod speed;
mod table;
mod threads;
pub mod timing;

use crate::arguments::{Arguments, Benchmark};
use thurible::exit::Failure;

/// Measures what `arguments` name.
///
/// # Errors
/// [`Failure`]: the arguments are wrong, the memory does not suffice, or a page cannot be written.
pub fn run(arguments: &Arguments) -> Result<u8, Failure> {
    match &arguments.what {
        Some(Benchmark::Memory(arguments)) => memory::run(arguments),
        Some(Benchmark::Scaling(arguments)) => scaling::run(arguments),
        Some(Benchmark::Roofline(arguments)) => roofline::run(arguments),
        Some(Benchmark::Circles(arguments)) => circles::run(arguments),
        None => speed::run(arguments),
    }
}
