//! `thurible remap DIR --solid FILE`: the flow of a result among other solid cells.

use super::options::{Overwriting, Resources};
use super::takes::{not_negative, request};
use crate::exit::Failure;
use crate::flows::Deed;
use clap::Args;
use std::path::PathBuf;

/// Arguments of `remap`.
#[derive(Args, Debug)]
pub struct RemapArguments {
    /// The result folder: of `track`, `solve`, `simulate` or what follows on these.
    #[arg(value_name = "DIR")]
    pub result: PathBuf,
    /// What is solid: a picture or an array over the box, or a scene whose obstacles are meant.
    #[arg(long, value_name = "FILE")]
    pub solid: PathBuf,
    /// The new result folder [default: DIR with _remapped at its end].
    #[arg(short, long, value_name = "DIR")]
    pub output: Option<PathBuf>,
    /// The step to begin at.
    #[arg(long, value_name = "K", default_value_t = 0)]
    pub at: usize,
    /// Let all of the flow give way alike, not that outside of the smoke first.
    #[arg(long)]
    pub plain: bool,
    /// How dear the vorticity of the change is, beside the change itself: a smooth change takes 5 to 15 times as long.
    #[arg(long, value_name = "A", value_parser = not_negative, default_value = "0")]
    pub alpha: f64,
    /// What becomes of a result that is there.
    #[command(flatten)]
    pub overwriting: Overwriting,
    /// Those of the machine.
    #[command(flatten)]
    pub resources: Resources,
}

/// Takes the flow there and writes the result folder; the answer is the exit code.
pub fn run(arguments: &RemapArguments) -> Result<u8, Failure> {
    let deed = Deed::Remap {
        solid: arguments.solid.clone(),
        weighted: !arguments.plain,
        smoothness: arguments.alpha,
    };
    let from = (arguments.result.as_path(), arguments.at);
    let to = (arguments.output.as_deref(), "_remapped");
    let request = request(&arguments.resources, from, to, deed);
    arguments.overwriting.check(&request.folder)?;
    crate::flows::run(&request)
}
