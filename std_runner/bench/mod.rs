//! `thurible bench`: what this machine does. The parts that are public serve `cargo bench` too.

pub mod arguments;
mod circles;
pub mod flow;
mod kernels;
pub mod memory;
pub mod navier_stokes;
mod page;
pub mod pieces;
pub mod ready;
mod roofline;
mod row;
mod scaling;
pub mod scenes;
mod section;
mod sheet;
mod solves;
mod speed;
pub mod yardstick;

use crate::console;
use crate::exit::Failure;
use crate::{address_space, threads};
use arguments::{BenchArguments, Benchmark, MeasureArguments};
use serde_json::Value;
use thurible_core::Exec;

/// Runs `bench`.
pub fn run(arguments: &BenchArguments) -> Result<u8, Failure> {
    match &arguments.what {
        Some(Benchmark::Memory(arguments)) => memory::run(arguments),
        Some(Benchmark::Scaling(arguments)) => scaling::run(arguments),
        Some(Benchmark::Roofline(arguments)) => roofline::run(arguments),
        Some(Benchmark::Circles(arguments)) => circles::run(arguments),
        None => speed::run(arguments),
    }
}

/// Calls `work` on so many threads.
fn with_team<R: Send>(
    count: usize,
    work: impl FnOnce(&dyn Exec) -> Result<R, Failure> + Send,
) -> Result<R, Failure> {
    address_space::check(count)?;
    threads::with(count, || threads::together(count, work))?
}

/// How results are told.
#[derive(Clone, Copy, Debug)]
struct Voice {
    quiet: bool,
    json: bool,
}

impl Voice {
    fn of(arguments: &MeasureArguments) -> Self {
        Self {
            quiet: arguments.quiet,
            json: arguments.json,
        }
    }

    /// A line for people alone.
    fn for_people(self, text: &str) {
        if !self.quiet && !self.json {
            console::print(text);
        }
    }

    /// A line for people, or the same for programs.
    fn say(self, text: &str, value: Value) {
        if self.json {
            console::print(&value.to_string());
        }
        self.for_people(text);
    }
}
