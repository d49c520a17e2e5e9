//! The words of the command line; [`program`](crate::program) acts on them.

use crate::bytes;
use crate::paper::Scale;
use crate::plan::Wishes;
use crate::problem::Precision;
use crate::progress::Mode;
use crate::threads;
use clap::{Args, Parser, Subcommand};
use std::path::PathBuf;

/// Finds the smallest force field that makes an incompressible flow of smoke pass through keyframes.
#[derive(Debug, Parser)]
#[command(name = "thurible", version, about, arg_required_else_help = true)]
#[command(
    after_help = "Exit codes: 0 done, 1 not finite, 2 bad input or usage, 3 does not fit in memory,\n4 a file could not be read or written, 5 stalled (result written), 130 interrupted (result written)."
)]
pub struct Cli {
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
}

/// The commands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Solve a scene and write the result folder.
    Solve(SolveArguments),
    /// Simulate the flow of a scene without control; its keyframes and method are left out.
    Simulate(SimulateArguments),
    /// Print the memory that a scene needs, to the byte; allocates nothing.
    Plan(SceneArguments),
    /// Solve a scene by several methods, one after the other, and compare them on one page.
    Compare(CompareArguments),
    /// Solve the scenes of Pan & Manocha's paper and put the results beside its own.
    Paper(PaperArguments),
    /// Measure this machine: speed, scaling, memory.
    Bench(BenchArguments),
    /// Write a commented scene to start from.
    New(NewArguments),
}

/// What `solve` and `plan` share.
#[derive(Args, Debug)]
pub struct SceneArguments {
    /// The scene file (TOML).
    pub scene: PathBuf,
    /// The method: direct, admm, lbfgs or pd.
    #[arg(long, value_name = "M")]
    pub method: Option<String>,
    /// The common options.
    #[command(flatten)]
    pub options: Options,
}

/// What every command that plans or solves takes.
#[derive(Args, Debug)]
pub struct Options {
    /// Threads [default: as many as the machine offers].
    #[arg(long, value_name = "N", value_parser = thread_count)]
    pub threads: Option<usize>,
    /// Precision of all numbers [default: f32; of `simulate`, whose forces are next to nothing: f64].
    #[arg(long, value_enum)]
    pub precision: Option<Precision>,
    /// Ceiling for the one block of memory, as in 1GiB [default: the machine's memory].
    #[arg(long, value_name = "SIZE", value_parser = bytes::parse)]
    pub memory_limit: Option<usize>,
    /// Overrides of single keys of the scene.
    #[arg(
        long,
        value_name = "KEY=VALUE",
        help = "Override any key of the scene, as in --set time.steps=20 or --set 'keyframe[0].text=\"G\"'"
    )]
    pub set: Vec<String>,
    /// Print nothing but errors.
    #[arg(long, conflicts_with = "json")]
    pub quiet: bool,
    /// Print JSON lines.
    #[arg(long)]
    pub json: bool,
}

/// What `solve` takes.
#[derive(Args, Debug)]
pub struct SolveArguments {
    /// The scene and the common options.
    #[command(flatten)]
    pub common: SceneArguments,
    /// The result folder [default: `output.folder` of the scene].
    #[arg(short, long, value_name = "DIR")]
    pub output: Option<PathBuf>,
}

/// What `simulate` takes.
#[derive(Args, Debug)]
pub struct SimulateArguments {
    /// The scene file (TOML).
    pub scene: PathBuf,
    /// The common options.
    #[command(flatten)]
    pub options: Options,
    /// The result folder [default: `output.folder` of the scene with _flow at its end].
    #[arg(short, long, value_name = "DIR")]
    pub output: Option<PathBuf>,
    /// Go on from the last density and velocity of a result with the same cells.
    #[arg(long, value_name = "DIR")]
    pub from: Option<PathBuf>,
    /// Steps, as --set time.steps=M.
    #[arg(long, value_name = "M")]
    pub steps: Option<usize>,
}

/// The methods of `compare` and `paper`.
#[derive(Args, Debug)]
pub struct Contenders {
    /// The methods, in the order in which they run.
    #[arg(
        long,
        value_name = "M,M",
        value_delimiter = ',',
        default_value = "direct,admm"
    )]
    pub methods: Vec<String>,
}

/// What `compare` takes.
#[derive(Args, Debug)]
pub struct CompareArguments {
    /// The scene file (TOML).
    pub scene: PathBuf,
    /// By what it is solved.
    #[command(flatten)]
    pub contenders: Contenders,
    /// The common options.
    #[command(flatten)]
    pub options: Options,
    /// Where the page and a result folder for each method go [default: `output.folder` of the scene with _compare after it].
    #[arg(short, long, value_name = "DIR")]
    pub output: Option<PathBuf>,
}

/// What `paper` takes.
#[derive(Args, Debug)]
pub struct PaperArguments {
    /// Which of them; all of Table 2 if none is named. --list shows the names.
    #[arg(value_name = "NAME")]
    pub names: Vec<String>,
    /// Print the names and what they are, and solve nothing.
    #[arg(long)]
    pub list: bool,
    /// The paper's cells along each axis times this: 1, 1/2, 1/4 or 1/8; the steps stay.
    #[arg(long, value_name = "S", default_value = "1", value_parser = Scale::parse)]
    pub scale: Scale,
    /// By what they are solved.
    #[command(flatten)]
    pub contenders: Contenders,
    /// Keep result.npz of every solve too; at full size they are gigabytes.
    #[arg(long)]
    pub arrays: bool,
    /// The common options.
    #[command(flatten)]
    pub options: Options,
    /// Where the page and the result folders go.
    #[arg(short, long, value_name = "DIR", default_value = "out/paper")]
    pub output: PathBuf,
}

/// What `bench` takes.
#[derive(Args, Debug)]
#[command(args_conflicts_with_subcommands = true)]
pub struct BenchArguments {
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
    #[arg(long, value_name = "N", value_parser = thread_count, default_value = "2")]
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

/// What `bench roofline` takes.
#[derive(Args, Debug)]
pub struct RooflineArguments {
    /// Options of all measurements of speed.
    #[command(flatten)]
    pub common: MeasureArguments,
    /// Operations for each cell and slot of each kernel, counted by benches/flops.py.
    #[arg(long, value_name = "FILE")]
    pub flops: Option<PathBuf>,
    /// Run one kernel so many times and print nothing: how its operations are counted.
    #[arg(long, hide = true, value_name = "KERNEL=N")]
    pub only: Option<String>,
}

/// What `bench memory` takes.
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

/// What `new` takes.
#[derive(Args, Debug)]
pub struct NewArguments {
    /// Name of the scene; NAME.toml is written.
    pub name: PathBuf,
    /// Print nothing but errors.
    #[arg(long)]
    pub quiet: bool,
}

impl Options {
    /// What they say about the plan.
    pub fn wishes(&self) -> Wishes {
        Wishes {
            precision: self.precision.unwrap_or(Precision::F32),
            threads: self.threads,
            limit: self.memory_limit,
        }
    }

    /// How progress is shown.
    pub fn mode(&self) -> Mode {
        match (self.quiet, self.json) {
            (true, _) => Mode::Quiet,
            (_, true) => Mode::Json,
            _ => Mode::Human,
        }
    }
}

fn thread_count(text: &str) -> Result<usize, String> {
    match text.parse() {
        Ok(count) if (1..=threads::MOST).contains(&count) => Ok(count),
        _ => Err(format!(
            "found \"{text}\", allowed is a whole number from 1 to {}",
            threads::MOST
        )),
    }
}
