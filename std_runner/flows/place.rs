//! Where a flow is taken to, and how: the solid cells there, the problem of that grid.

use super::known::Known;
use super::request::{Deed, Request};
use crate::exit::Failure;
use crate::keyframes::{Note, ShapeSpec};
use crate::owned::OwnedProblem;
use crate::progress::Clock;
use crate::run;
use crate::scene::Scene;
use std::path::Path;
use thurible_core::{Advection, Refinement, Scheme};

/// What is going to be done.
pub(super) struct Job<'a> {
    pub request: &'a Request,
    pub problem: OwnedProblem,
    pub refinement: Refinement,
    pub solid: Option<Vec<bool>>,
    pub clock: Clock,
}

/// The solid cells that the flow goes among: those of the result, or of the file that takes their place.
pub(super) fn solid(request: &Request, known: &Known) -> Result<Option<Vec<bool>>, Failure> {
    let Deed::Remap { solid, .. } = &request.deed else {
        return known.solid(request.deed.scale());
    };
    let canvas = known.canvas(1);
    let told = |why: String| Failure::Input(format!("--solid {}: {why}", solid.display()));
    let is_scene = solid.extension().is_some_and(|extension| extension == "toml");
    let covered = if is_scene {
        let cells = format!("grid.cells={:?}", canvas.cells);
        let scene = Scene::load_free(solid, &[cells])?;
        let drawn = run::drawn::solid_cells(&scene, &mut Vec::new())?;
        drawn.ok_or_else(|| told("has no [[obstacle]]; write one".into()))?
    } else {
        let shape = ShapeSpec::default().of_file(solid.clone(), solid);
        let mut notes: Vec<Note> = Vec::new();
        let drawn = shape.cut_noting(&canvas, Path::new("."), &mut notes);
        let drawn = drawn.map_err(|error| error.failure(format!("--solid {}: {error}", solid.display())))?;
        drawn.into_iter().map(|part| part >= 0.5).collect()
    };
    match covered.iter().filter(|&&solid| solid).count() {
        0 => Err(told(
            "covers no cell by half, so that nothing would be solid".into(),
        )),
        all if all == covered.len() => Err(told("leaves no cell to the flow".into())),
        _ => Ok(Some(covered)),
    }
}

/// The problem of the grid that the flow goes to.
pub(super) fn problem(known: &Known, request: &Request, solids: bool) -> OwnedProblem {
    let plain = OwnedProblem::new(known.canvas(request.deed.scale()).cells, Vec::new());
    // What is reported of transport elsewhere is that of `quick`, which knows no solid cells.
    let scheme = if solids { Scheme::Limited } else { Scheme::Quick };
    OwnedProblem {
        boundary: known.boundary.clone(),
        steps: known.steps() - request.at,
        length: known.length,
        dt: known.dt,
        solids,
        advection: Advection {
            scheme,
            ..plain.advection
        },
        ..plain
    }
}
