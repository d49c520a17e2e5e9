//! What a solve starts from: drawn from the scene, or read from an earlier result, one field at a time.

use super::drawn::{drawn, narrowed, refusal, refuse, solid_cells};
use super::reach::Reach;
use super::targets::{Which, check_reach, set_keyframes};
use crate::exit::Failure;
use crate::keyframes::{Note, read_velocity};
use crate::scene::Scene;
use thurible_core::{InputError, Real, Solver, SolverError, Space};

/// What came of the inputs of a solve.
#[derive(Debug, Default)]
pub struct Inputs {
    /// By how much each keyframe was scaled to the mass of the source, for every step that it stands at.
    pub mass_factors: Vec<f64>,
    /// What the user should hear of the files that were read.
    pub notes: Vec<Note>,
}

/// Draws every shape of `scene`, reads the files that it names, and sets all that `solver` is given. Keyframes take `masses`, that of each
/// step, where they are there.
pub fn set_inputs<T: Real, S: Space>(
    scene: &Scene,
    solver: &mut Solver<'_, T, S>,
    masses: Option<&[f64]>,
) -> Result<Inputs, Failure> {
    let mut notes = Vec::new();
    let reach = set_smoke(scene, solver, &mut notes)?;
    set_mask(scene, solver, &mut notes)?;
    check_reach(scene, reach)?;
    let which = Which { masses, among: None };
    let mass_factors = set_keyframes(scene, solver, which, &mut notes)?;
    Ok(Inputs { mass_factors, notes })
}

/// Sets obstacles, source, emitters and the given velocity; where smoke can come to, if there are obstacles.
pub(super) fn set_smoke<T: Real, S: Space>(
    scene: &Scene,
    solver: &mut Solver<'_, T, S>,
    notes: &mut Vec<Note>,
) -> Result<Option<Reach>, Failure> {
    let mut reach = set_obstacles(scene, solver, notes)?;
    if let Some(source) = &scene.source {
        let density = drawn(scene, "source", source, notes)?;
        if let Some(reach) = &mut reach {
            reach.fill(density.iter().map(|x: &T| x.to_f64()));
        }
        solver.set_source(&density).map_err(refuse(scene, "source"))?;
    }
    set_emitters(scene, solver, None, &mut reach, notes)?;
    set_velocity(scene, solver)?;
    Ok(reach)
}

/// Sets the given velocity.
pub(super) fn set_velocity<T: Real, S: Space>(
    scene: &Scene,
    solver: &mut Solver<'_, T, S>,
) -> Result<(), Failure> {
    let Some(path) = &scene.control.initial_velocity else {
        return Ok(());
    };
    let velocity = read_velocity(path, &scene.canvas()).map_err(|error| refusal(scene, "control", &error))?;
    for (axis, faces) in velocity.into_iter().enumerate() {
        solver
            .set_initial_velocity(axis, &narrowed(faces))
            .map_err(refuse(scene, "control.initial_velocity"))?;
    }
    Ok(())
}

/// Draws where force may act.
pub(super) fn set_mask<T: Real, S: Space>(
    scene: &Scene,
    solver: &mut Solver<'_, T, S>,
    notes: &mut Vec<Note>,
) -> Result<(), Failure> {
    let key = "control.mask";
    let Some(mask) = &scene.control.mask else {
        return Ok(());
    };
    let mask: Vec<T> = drawn(scene, key, mask, notes)?;
    solver.set_mask(&mask).map_err(|error| match error {
        InputError::Empty | InputError::Buried => {
            let why = "allows force nowhere; make it larger, or leave it out where force may act everywhere";
            scene.document.refuse(key, why)
        }
        other => refuse(scene, key)(other),
    })
}

/// Sets the solid cells. What they cut off from what.
pub(super) fn set_obstacles<T: Real, S: Space>(
    scene: &Scene,
    solver: &mut Solver<'_, T, S>,
    notes: &mut Vec<Note>,
) -> Result<Option<Reach>, Failure> {
    let Some(solid) = solid_cells(scene, notes)? else {
        return Ok(None);
    };
    solver.set_solids(&solid).map_err(|error| {
        let why = format!("cannot be used: {error}; leave room for the flow");
        scene.document.refuse("obstacle[0]", why)
    })?;
    Ok(Some(Reach::new(&scene.canvas(), &solid)))
}

/// Draws the shapes of the emitters, of all or those `among` them, and fills what they reach with smoke.
pub(super) fn set_emitters<T: Real, S: Space>(
    scene: &Scene,
    solver: &mut Solver<'_, T, S>,
    among: Option<&[usize]>,
    reach: &mut Option<Reach>,
    notes: &mut Vec<Note>,
) -> Result<(), Failure> {
    let there = |(number, _): &(usize, _)| among.is_none_or(|among| among.contains(number));
    let emitters = scene.emitters.iter().enumerate().filter(there);
    for (index, (_, emitter)) in emitters.enumerate() {
        let shape: Vec<T> = drawn(scene, &emitter.key, &emitter.shape, notes)?;
        if let Some(reach) = reach {
            reach.fill(shape.iter().map(|x| x.to_f64()));
        }
        solver
            .set_emitter(index, &shape)
            .map_err(refuse(scene, &emitter.key))?;
    }
    Ok(())
}

/// The failure for a solver that could not be made in a block of the planned size.
pub fn solver_refusal(error: &SolverError) -> Failure {
    Failure::Memory(format!(
        "the solver refused its block of memory: {error}; this is a fault of thurible, please report it"
    ))
}
