//! `thurible tomography VIEWS`: density from photographs.

use super::options::{Options, Overwriting};
use crate::exit::Failure;
use crate::tomography::{Request, reconstruct};
use clap::Args;
use std::path::PathBuf;

/// Arguments of `tomography`.
#[derive(Args, Debug)]
pub struct TomographyArguments {
    /// The file of views (TOML), or a folder with views.toml in it.
    pub views: PathBuf,
    /// The result folder.
    #[arg(short, long, value_name = "DIR", default_value = "out/tomography")]
    pub output: PathBuf,
    /// Print the memory that it takes, to the byte, and stop.
    #[arg(long)]
    pub plan: bool,
    /// What becomes of a result that is there.
    #[command(flatten)]
    pub overwriting: Overwriting,
    /// The common options.
    #[command(flatten)]
    pub options: Options,
}

/// Reconstructs every frame; the answer is the exit code.
pub fn run(arguments: &TomographyArguments) -> Result<u8, Failure> {
    if !arguments.plan {
        arguments.overwriting.check(&arguments.output)?;
    }
    reconstruct(&Request {
        views: &arguments.views,
        folder: arguments.output.clone(),
        plan: arguments.plan,
        options: &arguments.options,
    })
}
