//! `thurible guide SCENE --reference DIR`: the flow of a scene, guided by that of a result.

use super::options::{Keeping, Options, Sharing};
use super::simulate::Simulation;
use crate::exit::Failure;
use crate::run::{Origin, Request};
use clap::Args;
use std::path::PathBuf;
use thurible_core::Method;

/// Arguments of `guide`.
#[derive(Args, Debug)]
pub struct GuideArguments {
    /// The scene file (TOML): its source, emitters, obstacles and buoyancy; `[method.guide]` has the choices.
    pub scene: PathBuf,
    /// The result whose flow is followed: of `track`, `solve` or `simulate`; with other cells it is brought to those of the scene.
    #[arg(long, value_name = "DIR")]
    pub reference: PathBuf,
    /// The step of the reference that the flow begins at.
    #[arg(long, value_name = "K", default_value_t = 0)]
    pub at: usize,
    /// Begin with the density and the velocity of the reference at that step, instead of the scene's source at rest.
    #[arg(long)]
    pub from_reference: bool,
    /// The common options.
    #[command(flatten)]
    pub options: Options,
    /// The result folder [default: `output.folder` of the scene with _guided at its end].
    #[arg(short, long, value_name = "DIR")]
    pub output: Option<PathBuf>,
    /// Steps, as --set time.steps=M.
    #[arg(long, value_name = "M")]
    pub steps: Option<usize>,
    /// What becomes of what is there, and of the state.
    #[command(flatten)]
    pub keeping: Keeping,
}

/// Simulates the guided flow and writes its result folder; the answer is the exit code.
pub fn run(arguments: &GuideArguments) -> Result<u8, Failure> {
    let reference = Origin {
        option: "--reference",
        folder: arguments.reference.clone(),
        step: Some(arguments.at),
    };
    let from = arguments.from_reference.then(|| reference.clone());
    let simulation = Simulation {
        scene: &arguments.scene,
        options: &arguments.options,
        output: arguments.output.as_deref(),
        steps: arguments.steps,
        fluids: false,
        keeping: &arguments.keeping,
        sharing: Sharing::default(),
    };
    simulation.run("_guided", Method::Guide, |request| Request {
        from,
        reference: Some(reference),
        ..request
    })
}
