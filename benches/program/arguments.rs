//! The words of the command line.

use clap::{Args, Parser, Subcommand};
use std::path::PathBuf;
use thurible::threads;

/// Measures this machine with thurible: the speed of kernels, iterations and solves, scaling, memory.
#[derive(Debug, Parser)]
#[command(
    name = "thurible-bench",
    version,
    about,
    args_conflicts_with_subcommands = true
)]
pub struct Arguments {
    /// What is measured, if not the speed of kernels, iterations and solves.
    #[command(subcommand)]
    pub what: Option<Benchmark>,
    /// Options of all measurements of speed.
    #[command(flatten)]
    pub common: MeasureArguments,
    /// Solve the paper's moving sphere too, by direct and by admm; takes up to half an hour more than the three minutes without.
    #[arg(long)]
    pub long: bool,
}

/// What can be measured.
#[derive(Debug, Subcommand)]
pub enum Benchmark {
    /// Print bytes planned and touched for a table of sizes, methods and precisions, each measured in a process of its own.
    Memory(MemoryArguments),
    /// Print seconds for each cell and step at many sizes, on one thread and on all.
    Scaling(MeasureArguments),
    /// Time a circle that becomes two in both precisions: what benches/rivals.py has other programs do.
    Circles(MeasureArguments),
    /// Print bytes, operations and rates of each kernel beside what the machine can do.
    Roofline(RooflineArguments),
}

/// What measurements of speed take.
#[derive(Args, Debug)]
pub struct MeasureArguments {
    /// Threads.
    #[arg(long, value_name = "N", value_parser = threads::parse, default_value = "2")]
    pub threads: usize,
    /// Tiny sizes, in a few seconds: to see that it works.
    #[arg(long)]
    pub quick: bool,
    /// Write the tables into performance.md there too, and figures beside it.
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Print nothing but errors.
    #[arg(long, conflicts_with = "json")]
    pub quiet: bool,
    /// Print JSON lines.
    #[arg(long)]
    pub json: bool,
}

/// What `roofline` takes.
#[derive(Args, Debug)]
pub struct RooflineArguments {
    /// Options of all measurements of speed.
    #[command(flatten)]
    pub common: MeasureArguments,
    /// Operations for each cell and slot of each kernel, counted by benches/flops.py.
    #[arg(long, value_name = "FILE")]
    pub flops: Option<PathBuf>,
    /// Run KERNEL, as in cycle,3,2 (kernel, dimensions, times), and print cells times slots alone: how operations are counted.
    #[arg(long, hide = true, value_name = "KERNEL")]
    pub only: Option<String>,
}

/// What `memory` takes.
#[derive(Args, Debug)]
pub struct MemoryArguments {
    /// The smallest sizes alone.
    #[arg(long)]
    pub quick: bool,
    /// Write memory.md and its figures there too.
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Print JSON lines.
    #[arg(long)]
    pub json: bool,
    /// Solve one row here and print what it touched: how the table's processes are called.
    #[arg(long, hide = true)]
    pub row: Option<usize>,
}
