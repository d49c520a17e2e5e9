//! Options that several commands share.

use crate::plan::PlanOptions;
use crate::problem::Precision;
use crate::progress::Mode;
use crate::run::{Outputs, RunOptions};
use crate::scene::steering;
use crate::{bytes, threads};
use clap::Args;
use std::path::PathBuf;
use thurible_core::{Named, stable_fluids};

/// What a command takes of the machine, and how it tells its progress.
#[derive(Args, Clone, Debug)]
pub struct Resources {
    /// Threads [default: as many as the machine offers].
    #[arg(long, value_name = "N", value_parser = threads::parse)]
    pub threads: Option<usize>,
    /// Precision of all fields [default: f32; of `simulate` and `guide`, where forces may be almost zero: f64; where a result is taken further: its own].
    #[arg(long, value_enum)]
    pub precision: Option<Precision>,
    /// Ceiling for the one block of memory, as in 1GiB [default: the machine's memory].
    #[arg(long, value_name = "SIZE", value_parser = bytes::parse)]
    pub memory_limit: Option<usize>,
    /// Print nothing but errors.
    #[arg(long, conflicts_with = "json")]
    pub quiet: bool,
    /// Print JSON lines.
    #[arg(long)]
    pub json: bool,
}

impl Resources {
    /// How progress is shown: a bar, JSON lines or nothing.
    pub fn mode(&self) -> Mode {
        match (self.quiet, self.json) {
            (true, _) => Mode::Quiet,
            (_, true) => Mode::Json,
            _ => Mode::Human,
        }
    }
}

/// Options of every command that plans or solves.
#[derive(Args, Clone, Debug)]
pub struct Options {
    /// Those of the machine.
    #[command(flatten)]
    pub resources: Resources,
    /// Overrides of single keys of the scene.
    #[arg(
        long,
        value_name = "KEY=VALUE",
        help = "Override any key of the scene, as in --set time.steps=20 or --set 'keyframe[0].text=\"G\"'"
    )]
    pub set: Vec<String>,
}

impl Options {
    /// The options of the plan.
    pub fn plan(&self) -> PlanOptions {
        PlanOptions {
            precision: self.resources.precision.unwrap_or(Precision::F32),
            threads: self.resources.threads,
            limit: self.resources.memory_limit,
        }
    }

    /// How progress is shown.
    pub fn mode(&self) -> Mode {
        self.resources.mode()
    }

    /// The options of a solve that writes `outputs`.
    pub(crate) fn run(&self, outputs: Outputs) -> RunOptions {
        RunOptions {
            plan: self.plan(),
            mode: self.mode(),
            outputs,
        }
    }
}

/// Arguments of `solve` and `plan`.
#[derive(Args, Debug)]
pub struct SceneArguments {
    /// The scene file (TOML).
    pub scene: PathBuf,
    /// The method, by its word.
    #[arg(long, value_name = "M", help = methods())]
    pub method: Option<String>,
    /// The common options.
    #[command(flatten)]
    pub options: Options,
}

/// The methods of `compare` and `paper`.
#[derive(Args, Debug)]
pub struct MethodList {
    /// The methods, in the order in which they run.
    #[arg(
        long,
        value_name = "M,M",
        value_delimiter = ',',
        default_value = "direct,admm"
    )]
    pub methods: Vec<String>,
}

/// The help of `--method`.
fn methods() -> String {
    let words: Vec<&str> = steering().into_iter().map(Named::name).collect();
    format!(
        "The method, one of: {}, {}",
        words.join(", "),
        stable_fluids::NAME
    )
}
