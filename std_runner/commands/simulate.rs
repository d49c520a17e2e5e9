//! `thurible simulate SCENE`: the flow alone, from the scene's source or from where a result ends.

use super::options::Options;
use crate::exit::Failure;
use crate::problem::Precision;
use crate::progress::Clock;
use crate::run::{Outputs, Request};
use crate::scene::Scene;
use clap::Args;
use std::path::PathBuf;

/// Arguments of `simulate`.
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

/// Simulates a scene and writes its result folder; the answer is the exit code.
pub fn run(arguments: &SimulateArguments) -> Result<u8, Failure> {
    let clock = Clock::start();
    let steps = arguments.steps.map(|steps| format!("time.steps={steps}"));
    let assignments: Vec<String> = arguments.options.set.iter().cloned().chain(steps).collect();
    let scene = Scene::load_free(&arguments.scene, &assignments)?;
    let mut options = arguments.options.run(Outputs {
        arrays: true,
        images: scene.output.frames,
    });
    // Without control the forces are the residuals of the steps, which single precision would not resolve.
    options.plan.precision = arguments.options.precision.unwrap_or(Precision::F64);
    let folder = arguments.output.clone().unwrap_or_else(|| {
        let mut name = scene.output.folder.clone().into_os_string();
        name.push("_flow");
        name.into()
    });
    let outcome = options.solve(Request {
        from: arguments.from.clone(),
        ..Request::new(scene, folder, clock)
    })?;
    Ok(outcome.exit_code())
}
