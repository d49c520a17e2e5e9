//! `thurible upsample DIR`: the flow of a result on finer cells, with the turbulence that its own were too coarse for.

use super::options::{Overwriting, Resources};
use super::takes::{not_negative, request};
use crate::exit::Failure;
use crate::flows::Deed;
use clap::Args;
use std::path::PathBuf;
use thurible_core::Turbulence;

/// Arguments of `upsample`.
#[derive(Args, Debug)]
pub struct UpsampleArguments {
    /// The result folder: of `track`, `solve`, `simulate` or what follows on these.
    #[arg(value_name = "DIR")]
    pub result: PathBuf,
    /// The new result folder [default: DIR with _upsampled at its end].
    #[arg(short, long, value_name = "DIR")]
    pub output: Option<PathBuf>,
    /// Cells 2, 4 or 8 times as fine in every direction.
    #[arg(long, value_name = "2|4|8", value_parser = factor, default_value = "4")]
    pub factor: usize,
    /// How strong the turbulence is: 1 goes on as the spectrum of the flow does, 0 adds none.
    #[arg(long, value_name = "A", value_parser = not_negative, default_value = "1")]
    pub turbulence: f64,
    /// Which turbulence: another number, other noise.
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub seed: u64,
    /// The step to begin at.
    #[arg(long, value_name = "K", default_value_t = 0)]
    pub at: usize,
    /// What becomes of a result that is there.
    #[command(flatten)]
    pub overwriting: Overwriting,
    /// Those of the machine.
    #[command(flatten)]
    pub resources: Resources,
}

/// Takes the flow there and writes the result folder; the answer is the exit code.
pub fn run(arguments: &UpsampleArguments) -> Result<u8, Failure> {
    let deed = Deed::Upsample {
        factor: arguments.factor,
        turbulence: Turbulence {
            strength: arguments.turbulence,
            seed: arguments.seed,
        },
    };
    let from = (arguments.result.as_path(), arguments.at);
    let to = (arguments.output.as_deref(), "_upsampled");
    let request = request(&arguments.resources, from, to, deed);
    arguments.overwriting.check(&request.folder)?;
    crate::flows::run(&request)
}

/// Reads how many times as fine cells are to be; the error says what is allowed.
fn factor(text: &str) -> Result<usize, String> {
    let factor = text.trim().parse().ok();
    factor.filter(|factor| [2, 4, 8].contains(factor)).ok_or_else(|| {
        format!("found \"{text}\", allowed are 2, 4 and 8: how many times as fine cells are to be")
    })
}
