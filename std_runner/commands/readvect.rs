//! `thurible readvect DIR`: the flow of a result carries its smoke again.

use super::options::{Overwriting, Resources};
use super::takes::request;
use crate::exit::Failure;
use crate::flows::Deed;
use clap::Args;
use std::path::PathBuf;

/// Arguments of `readvect`.
#[derive(Args, Debug)]
pub struct ReadvectArguments {
    /// The result folder: of `track`, `solve`, `simulate` or what follows on these.
    #[arg(value_name = "DIR")]
    pub result: PathBuf,
    /// The new result folder [default: DIR with _readvect at its end].
    #[arg(short, long, value_name = "DIR")]
    pub output: Option<PathBuf>,
    /// The step whose density is carried on.
    #[arg(long, value_name = "K", default_value_t = 0)]
    pub at: usize,
    /// Cells 1, 2, 4 or 8 times as fine in every direction.
    #[arg(long, value_name = "1|2|4|8", value_parser = scale, default_value = "1")]
    pub scale: usize,
    /// What becomes of a result that is there.
    #[command(flatten)]
    pub overwriting: Overwriting,
    /// Those of the machine.
    #[command(flatten)]
    pub resources: Resources,
}

/// Carries the smoke and writes the result folder; the answer is the exit code.
pub fn run(arguments: &ReadvectArguments) -> Result<u8, Failure> {
    let deed = Deed::Readvect {
        scale: arguments.scale,
    };
    let from = (arguments.result.as_path(), arguments.at);
    let to = (arguments.output.as_deref(), "_readvect");
    let request = request(&arguments.resources, from, to, deed);
    arguments.overwriting.check(&request.folder)?;
    crate::flows::run(&request)
}

/// Reads how many times as fine cells are to be; the error says what is allowed.
fn scale(text: &str) -> Result<usize, String> {
    let scale = text.trim().parse().ok();
    scale.filter(|scale| [1, 2, 4, 8].contains(scale)).ok_or_else(|| {
        format!("found \"{text}\", allowed are 1, 2, 4 and 8: how many times as fine cells are to be")
    })
}
