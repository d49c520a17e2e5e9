//! `thurible simulate SCENE`: the flow alone, from the scene's source or from where a result ends.

use super::options::{Keeping, Options, Sharing, longer};
use crate::exit::Failure;
use crate::progress::Clock;
use crate::run::{Origin, Outputs, Request, RunOptions};
use crate::scene::Scene;
use crate::solves::solve;
use clap::Args;
use std::path::{Path, PathBuf};
use thurible_core::{Method, stable_fluids};

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
    /// Go on from the last velocity of a result with the same cells, and the density of its step, the one before the end.
    #[arg(long, value_name = "DIR")]
    pub from: Option<PathBuf>,
    /// With --from, go on from step K of it instead, and tell how far the densities are from those that follow there.
    #[arg(long, value_name = "K", requires = "from")]
    pub at: Option<usize>,
    /// Which simulator: the staggered one, or Stam's at cell centres, with `[method.stable_fluids]`.
    #[arg(long, value_name = "NAME", value_parser = ["staggered", stable_fluids::NAME], default_value = "staggered", conflicts_with = "from")]
    pub solver: String,
    /// Steps, as --set time.steps=M.
    #[arg(long, value_name = "M")]
    pub steps: Option<usize>,
    /// What becomes of what is there, and of the state.
    #[command(flatten)]
    pub keeping: Keeping,
    /// How ranks cut the box.
    #[command(flatten)]
    pub sharing: Sharing,
}

/// Simulates a scene and writes its result folder; the answer is the exit code.
pub fn run(arguments: &SimulateArguments) -> Result<u8, Failure> {
    let from = arguments.from.clone().map(|folder| Origin {
        option: "--from",
        folder,
        step: arguments.at,
    });
    let simulation = Simulation {
        scene: &arguments.scene,
        options: &arguments.options,
        output: arguments.output.as_deref(),
        steps: arguments.steps,
        fluids: arguments.solver == stable_fluids::NAME,
        keeping: &arguments.keeping,
        sharing: arguments.sharing,
    };
    simulation.run("_flow", Method::Simulate, |request| Request { from, ..request })
}

/// A scene whose flow is simulated, free or guided.
pub(super) struct Simulation<'a> {
    /// The scene file.
    pub scene: &'a Path,
    /// The common options.
    pub options: &'a Options,
    /// The result folder.
    pub output: Option<&'a Path>,
    /// Steps, instead of the scene's.
    pub steps: Option<usize>,
    /// Whether Stable Fluids simulate it.
    pub fluids: bool,
    /// What becomes of what is there, and of the state.
    pub keeping: &'a Keeping,
    /// How ranks cut the box.
    pub sharing: Sharing,
}

impl Simulation<'_> {
    /// Simulates what `change` makes of the request; the folder is the scene's with `end` at its end, where none is given.
    pub fn run(
        &self,
        end: &str,
        method: Method,
        change: impl FnOnce(Request) -> Request,
    ) -> Result<u8, Failure> {
        let clock = Clock::start();
        let steps = self.steps.map(|steps| format!("time.steps={steps}"));
        let assignments: Vec<String> = self.options.set.iter().cloned().chain(steps).collect();
        let scene = Scene::load_free(self.scene, &assignments)?.flow_by(method, self.fluids);
        let outputs = Outputs {
            arrays: true,
            images: scene.output.frames,
        };
        let options = self.sharing.of(RunOptions {
            plan: self.options.plan_of_a_flow(),
            ..self.options.run(outputs)
        })?;
        let beside = || longer(&scene.output.folder, end);
        let folder = self.output.map_or_else(beside, Path::to_owned);
        let request = change(Request::new(scene, folder, clock));
        if options.follows() {
            return options.follow(request);
        }
        let request = self.keeping.keep(Request {
            free: true,
            ..request
        })?;
        let outcome = solve(&options, request)?;
        Ok(outcome.exit_code())
    }
}
