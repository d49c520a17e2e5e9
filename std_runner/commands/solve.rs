//! `thurible solve SCENE`: plan, allocate once, solve, make feasible, write.

use super::options::{Keeping, OnDevice, SceneArguments, Sharing};
use crate::exit::Failure;
use crate::progress::Clock;
use crate::run::{Outputs, Request, RunOptions};
use crate::scene::Scene;
use crate::solves::solve;
use clap::Args;
use std::path::PathBuf;

/// Arguments of `solve`.
#[derive(Args, Debug)]
pub struct SolveArguments {
    /// The scene and the common options.
    #[command(flatten)]
    pub common: SceneArguments,
    /// The result folder [default: `output.folder` of the scene].
    #[arg(short, long, value_name = "DIR")]
    pub output: Option<PathBuf>,
    /// Where the search goes.
    #[command(flatten)]
    pub on: OnDevice,
    /// What becomes of what is there, and of the state.
    #[command(flatten)]
    pub keeping: Keeping,
    /// How ranks cut the box.
    #[command(flatten)]
    pub sharing: Sharing,
}

/// Solves a scene and writes its result folder; the answer is the exit code.
pub fn run(arguments: &SolveArguments) -> Result<u8, Failure> {
    let common = &arguments.common;
    let clock = Clock::start();
    let scene = Scene::load(&common.scene, &common.options.set, common.method.as_deref())?;
    let outputs = Outputs {
        arrays: true,
        images: scene.output.frames,
    };
    let options = RunOptions {
        device: arguments.on.open(common.options.resources.ranks.is_some())?,
        ..arguments.sharing.of(common.options.run(outputs))?
    };
    let folder = arguments.output.as_ref().unwrap_or(&scene.output.folder).clone();
    let request = Request::new(scene, folder, clock);
    if options.follows() {
        return options.follow(request);
    }
    let request = arguments.keeping.keep(request)?;
    let outcome = solve(&options, request)?;
    Ok(outcome.exit_code())
}
