//! What a solve starts from: drawn from the scene, or read from an earlier result, one field at a time.

use super::reach::Reach;
use crate::exit::Failure;
use crate::keyframes::{Note, ShapeError, ShapeSpec, read_velocity};
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
    let mass_factors = set_keyframes(scene, solver, (masses, reach), &mut notes)?;
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
    set_emitters(scene, solver, &mut reach, notes)?;
    if let Some(path) = &scene.control.initial_velocity {
        let velocity =
            read_velocity(path, &scene.canvas()).map_err(|error| refusal(scene, "control", &error))?;
        for (axis, faces) in velocity.into_iter().enumerate() {
            solver
                .set_initial_velocity(axis, &narrowed(faces))
                .map_err(refuse(scene, "control.initial_velocity"))?;
        }
    }
    Ok(reach)
}

/// Sets all keyframes; what each was multiplied by.
fn set_keyframes<T: Real, S: Space>(
    scene: &Scene,
    solver: &mut Solver<'_, T, S>,
    (masses, reach): (Option<&[f64]>, Option<Reach>),
    notes: &mut Vec<Note>,
) -> Result<Vec<f64>, Failure> {
    let mut mass_factors = Vec::new();
    for keyframe in &scene.keyframes {
        let density: Vec<T> = drawn(scene, &keyframe.key, &keyframe.shape, notes)?;
        let numbers = || density.iter().map(|x| x.to_f64());
        let mass: f64 = numbers().sum();
        if let Some(part) = reach.as_ref().and_then(|reach| reach.cut_off(numbers())) {
            let why = format!(
                "cannot be reached: {:.0} % of it lies where obstacles let no smoke come; open a way, or put an emitter there",
                100.0 * part
            );
            return Err(scene.document.refuse(&keyframe.key, why));
        }
        let key = format!("{}.region", keyframe.key);
        let region = keyframe.region.as_ref();
        let region: Option<Vec<T>> = region
            .map(|region| drawn(scene, &key, region, notes))
            .transpose()?;
        for step in keyframe.stay().steps() {
            if let Some(region) = &region {
                solver
                    .set_region(mass_factors.len(), region)
                    .map_err(refuse(scene, &key))?;
            }
            let to_free = masses
                .and_then(|masses| masses.get(step))
                .map_or(1.0, |free| free / mass);
            let density: Vec<T> = density
                .iter()
                .map(|x| T::from_f64(x.to_f64() * to_free))
                .collect();
            let factor = solver
                .set_keyframe(mass_factors.len(), &density)
                .map_err(refuse(scene, &keyframe.key))?;
            mass_factors.push(factor * to_free);
        }
    }
    Ok(mass_factors)
}

/// Draws where force may act.
fn set_mask<T: Real, S: Space>(
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

/// Draws the obstacles: a cell of which they cover at least half is solid. Nothing where the scene has none.
pub(crate) fn solid_cells(scene: &Scene, notes: &mut Vec<Note>) -> Result<Option<Vec<bool>>, Failure> {
    if scene.obstacles.is_empty() {
        return Ok(None);
    }
    let mut solid = vec![false; scene.grid.cells.iter().product()];
    for (key, shape) in &scene.obstacles {
        let covered: Vec<f64> = drawn(scene, key, shape, notes)?;
        if !covered.iter().any(|&part| part >= 0.5) {
            let why = "covers no cell by half, so that nothing would be solid; make it larger, or thicker than a cell";
            return Err(scene.document.refuse(key, why));
        }
        solid
            .iter_mut()
            .zip(covered)
            .for_each(|(solid, part)| *solid |= part >= 0.5);
    }
    Ok(Some(solid))
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

/// Draws the shape of every emitter, and fills what it reaches with smoke.
pub(super) fn set_emitters<T: Real, S: Space>(
    scene: &Scene,
    solver: &mut Solver<'_, T, S>,
    reach: &mut Option<Reach>,
    notes: &mut Vec<Note>,
) -> Result<(), Failure> {
    for (index, emitter) in scene.emitters.iter().enumerate() {
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

/// The sentence for a field of `key` that the solver refuses.
pub(crate) fn refuse<'s>(scene: &'s Scene, key: &str) -> impl Fn(InputError) -> Failure + use<'s> {
    let key = key.to_string();
    move |error: InputError| {
        match error {
        // They were finite when they were drawn.
        InputError::NotFinite { .. } => scene.document.refuse(
            &key,
            "has numbers too large for the precision of the solve; make them smaller",
        ),
        InputError::AboveOne { .. } => scene.document.refuse(
            &key,
            "has values above 1, but here a cell counts from 0 to 1; take out its `density`, or scale its file to that",
        ),
        other => scene
            .document
            .refuse(&key, format!("cannot be used: {other}; change it in the scene")),
    }
    }
}

/// Draws a shape, which stands at `key`, on the cells of the scene.
pub(crate) fn drawn<T: Real>(
    scene: &Scene,
    key: &str,
    shape: &ShapeSpec,
    notes: &mut Vec<Note>,
) -> Result<Vec<T>, Failure> {
    let mut said = Vec::new();
    let density = shape
        .rasterise_noting(&scene.canvas(), scene.document.folder(), &mut said)
        .map_err(|error| refusal(scene, key, &error))?;
    notes.extend(said.into_iter().map(|note| note.of(key)));
    Ok(narrowed(density))
}

/// `values` rounded to the precision of the solve.
pub(super) fn narrowed<T: Real>(values: Vec<f64>) -> Vec<T> {
    values.into_iter().map(T::from_f64).collect()
}

/// The failure for a shape's error, with the place of its key in the scene.
fn refusal(scene: &Scene, table: &str, error: &ShapeError) -> Failure {
    let (ShapeError::Key { key, .. } | ShapeError::File { key, .. } | ShapeError::Read { key, .. }) = error;
    let place = scene.document.place(&format!("{table}.{key}"));
    let sentence = format!("{place}: in {table}: {error}");
    if error.is_unreadable() {
        Failure::File(sentence)
    } else {
        Failure::Input(sentence)
    }
}

/// The failure for a solver that could not be made in a block of the planned size.
pub fn solver_refusal(error: &SolverError) -> Failure {
    Failure::Memory(format!(
        "the solver refused its block of memory: {error}; this is a fault of thurible, please report it"
    ))
}
