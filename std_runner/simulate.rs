//! `thurible simulate SCENE`: the flow alone, from the scene's source or from where a result ends.

use crate::cli::SimulateArguments;
use crate::exit::Failure;
use crate::plan::{self, Wishes};
use crate::problem::Precision;
use crate::progress::Clock;
use crate::scene::Scene;
use crate::solve::carry_out;

/// Runs `simulate`.
pub fn run(arguments: &SimulateArguments) -> Result<u8, Failure> {
    let common = &arguments.common;
    let clock = Clock::start();
    if let Some(method) = &common.method {
        return Err(Failure::Input(format!("--method {method}: a simulation has no method; take the option out, or use `thurible solve`")));
    }
    let steps = arguments.steps.map(|steps| format!("time.steps={steps}"));
    let assignments: Vec<String> = common.set.iter().cloned().chain(steps).collect();
    let scene = Scene::load_free(&common.scene, &assignments)?;
    // Without control the forces are the residuals of the steps, which single precision would not resolve.
    let wishes = Wishes { precision: common.precision.unwrap_or(Precision::F64), ..common.wishes() };
    let planned = plan::choose(&scene, &wishes)?;
    let folder = arguments.output.clone().unwrap_or_else(|| {
        let mut name = scene.output.folder.clone().into_os_string();
        name.push("_flow");
        name.into()
    });
    carry_out(common, clock, scene, planned, arguments.from.clone(), folder)
}
