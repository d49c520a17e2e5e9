//! The door of all scenes: each goes to what plans and solves it.

use crate::exit::Failure;
use crate::plan::PlanOptions;
use crate::run::{Outcome, Request, RunOptions, unshared};
use crate::scene::Scene;
use crate::{devices, fluids, plan};

/// Solves the scene of `request` into its folder.
pub(crate) fn solve(options: &RunOptions, request: Request) -> Result<Outcome, Failure> {
    if options.ranks.is_some() {
        unshared(&request.scene)?;
    }
    if options.device.is_some() {
        devices::steers(&request.scene)?;
    }
    let others = match request.found {
        Some(_) => "-o DIR",
        None => "-o DIR or --name-by-time",
    };
    request.earlier.check(&request.folder, others)?;
    if request.scene.method.fluids.chosen {
        fluids::solve(options, request)
    } else {
        options.solve(request)
    }
}

/// Bytes of the block that a scene's solve takes, as it would choose with all memory that it asks for.
pub(crate) fn bytes(scene: &Scene, options: &PlanOptions) -> Result<usize, Failure> {
    if scene.method.fluids.chosen {
        return fluids::planned(scene, options).map(|planned| planned.plan.bytes());
    }
    plan::make(scene, options).map(|planned| planned.plan.bytes())
}

/// Refuses a scene whose solve would be refused for its plan.
pub(crate) fn check(scene: &Scene, options: &PlanOptions) -> Result<(), Failure> {
    if scene.method.fluids.chosen {
        fluids::planned(scene, options).map(drop)
    } else {
        plan::choose(scene, options).map(drop)
    }
}
