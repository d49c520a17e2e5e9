//! `thurible simulate SCENE`: the flow alone, from the scene's source or from where a result ends.

use crate::cli::SimulateArguments;
use crate::exit::{Failure, code_of};
use crate::plan::Wishes;
use crate::problem::Precision;
use crate::progress::Clock;
use crate::scene::Scene;
use crate::solve::{Order, Parts, Start};

/// Runs `simulate`.
pub fn run(arguments: &SimulateArguments) -> Result<u8, Failure> {
    let clock = Clock::start();
    let options = &arguments.options;
    let steps = arguments.steps.map(|steps| format!("time.steps={steps}"));
    let assignments: Vec<String> = options.set.iter().cloned().chain(steps).collect();
    let scene = Scene::load_free(&arguments.scene, &assignments)?;
    // Without control the forces are the residuals of the steps, which single precision would not resolve.
    let wishes = Wishes {
        precision: options.precision.unwrap_or(Precision::F64),
        ..options.wishes()
    };
    let parts = Parts {
        arrays: true,
        images: scene.output.frames,
    };
    let folder = arguments.output.clone().unwrap_or_else(|| {
        let mut name = scene.output.folder.clone().into_os_string();
        name.push("_flow");
        name.into()
    });
    let start = Start {
        from: arguments.from.clone(),
        ..Start::default()
    };
    Order {
        wishes,
        mode: options.mode(),
        parts,
    }
    .solve(scene, folder, clock, start)
    .map(|finished| code_of(finished.status))
}
