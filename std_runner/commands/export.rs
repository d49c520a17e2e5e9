//! `thurible export DIR`: a result as files of other programs.

use super::render::{fps, steps};
use crate::exit::Failure;
use crate::export::{Codec, Format, Request, Up};
use crate::progress::Mode;
use clap::{Args, ValueEnum};
use core::ops::RangeInclusive;
use std::path::PathBuf;
use thurible_core::exec::Ranks;

/// The bits of numbers in volumes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Bits {
    /// 16: three digits, and half the disc.
    Half,
    /// 32.
    Float,
}

/// Arguments of `export`.
#[derive(Args, Debug)]
pub struct ExportArguments {
    /// The result folder: of `solve`, `simulate`, `track` or what follows on these.
    #[arg(value_name = "DIR")]
    pub result: PathBuf,
    /// Where the files go [default: DIR/export].
    #[arg(short, long, value_name = "DIR")]
    pub output: Option<PathBuf>,
    /// What is written, one or several; usd writes vdb too.
    #[arg(
        long,
        value_enum,
        ignore_case = true,
        value_name = "F,F",
        value_delimiter = ',',
        default_value = "usd"
    )]
    pub format: Vec<Format>,
    /// Steps from the first to the last, or one [default: all].
    #[arg(long, value_name = "FROM..TO", value_parser = steps)]
    pub steps: Option<RangeInclusive<usize>>,
    /// The axis that is up in vdb, usd and fga: z for Blender, y for Houdini [default: z].
    #[arg(long, value_enum)]
    pub up: Option<Up>,
    /// A grid of the velocity on faces too, in vdb.
    #[arg(long)]
    pub staggered: bool,
    /// Of numbers in vdb [default: half].
    #[arg(long, value_enum)]
    pub precision: Option<Bits>,
    /// Of vdb [default: blosc].
    #[arg(long, value_enum)]
    pub compression: Option<Codec>,
    /// Steps a second when it plays; velocities in vdb, usd and fga are in length a second of that [default: 1 / dt where that is 10 to 240, else 24].
    #[arg(long, value_name = "N", value_parser = fps)]
    pub fps: Option<f64>,
    /// The number of the frame that shows step 0, as in 1001; names of files and the stage count from it.
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(..=1_000_000))]
    pub first_frame: u32,
    /// Print nothing but errors.
    #[arg(long, conflicts_with = "json")]
    pub quiet: bool,
    /// Print JSON lines.
    #[arg(long)]
    pub json: bool,
    /// The programs that share the steps, where there are several.
    #[arg(skip)]
    pub ranks: Option<&'static dyn Ranks>,
}

/// Writes the files; the answer is the exit code.
pub fn run(arguments: &ExportArguments) -> Result<u8, Failure> {
    let folder = arguments.output.clone();
    crate::export::run(&Request {
        result: arguments.result.clone(),
        folder: folder.unwrap_or_else(|| arguments.result.join("export")),
        formats: arguments.format.clone(),
        steps: arguments.steps.clone(),
        up: arguments.up,
        staggered: arguments.staggered,
        half: arguments.precision.map(|bits| bits == Bits::Half),
        codec: arguments.compression,
        fps: arguments.fps,
        first_frame: arguments.first_frame as usize,
        ranks: arguments.ranks,
        mode: match (arguments.quiet, arguments.json) {
            (true, _) => Mode::Quiet,
            (_, true) => Mode::Json,
            _ => Mode::Human,
        },
    })
}
