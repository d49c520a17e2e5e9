//! What a solve starts from: drawn from the scene, or read from an earlier result, one field at a time.

use crate::exit::Failure;
use crate::keyframes::{ShapeError, ShapeSpec, read_last_density, read_last_velocity, read_velocity};
use crate::scene::{Keyframe, Scene};
use std::path::Path;
use thurible_core::{InputError, Real, Solver, SolverError, Space};

/// Draws every shape of `scene`, reads the files that it names, and sets source, velocity and keyframes of `solver`. Returns the
/// mass factor of each keyframe.
pub fn set_inputs<T: Real, S: Space>(
    scene: &Scene,
    solver: &mut Solver<'_, T, S>,
) -> Result<Vec<f64>, Failure> {
    let refuse = |key: &str| {
        let key = key.to_string();
        move |error: InputError| match error {
            // They were finite when they were drawn.
            InputError::NotFinite { .. } => scene.document.refuse(
                &key,
                "has numbers too large for the precision of the solve; make them smaller",
            ),
            other => scene
                .document
                .refuse(&key, format!("cannot be used: {other}; change it in the scene")),
        }
    };
    solver
        .set_source(&drawn(scene, "source", &scene.source)?)
        .map_err(refuse("source"))?;
    if let Some(path) = &scene.control.initial_velocity {
        let velocity =
            read_velocity(path, &scene.canvas()).map_err(|error| refusal(scene, "control", &error))?;
        for (axis, faces) in velocity.into_iter().enumerate() {
            solver
                .set_initial_velocity(axis, &narrowed(faces))
                .map_err(refuse("control.initial_velocity"))?;
        }
    }
    let target = |(index, keyframe): (usize, &Keyframe)| {
        let density = drawn(scene, &keyframe.key, &keyframe.shape)?;
        solver
            .set_keyframe(index, &density)
            .map_err(refuse(&keyframe.key))
    };
    scene.keyframes.iter().enumerate().map(target).collect()
}

/// Hands the last density and velocity of the result in `folder` to `solver`; what little of the density is negative becomes 0.
pub fn set_inputs_from_result<T: Real, S: Space>(
    scene: &Scene,
    folder: &Path,
    solver: &mut Solver<'_, T, S>,
) -> Result<(), Failure> {
    let unusable = |error: InputError| {
        Failure::Input(format!(
            "--from {}: its last step cannot be used: {error}; give another result",
            folder.display()
        ))
    };
    let unread = |error: ShapeError| {
        let sentence = format!("--from {}: {error}", folder.display());
        if error.is_unreadable() {
            Failure::File(sentence)
        } else {
            Failure::Input(sentence)
        }
    };
    let (path, canvas) = (folder.join("result.npz"), scene.canvas());
    let density = read_last_density(&path, &canvas).map_err(unread)?;
    solver
        .set_source(&narrowed(
            density.into_iter().map(|value| value.max(0.0)).collect(),
        ))
        .map_err(unusable)?;
    (0..S::DIM).try_for_each(|axis| {
        let faces = read_last_velocity(&path, axis, &canvas).map_err(unread)?;
        solver
            .set_initial_velocity(axis, &narrowed(faces))
            .map_err(unusable)
    })
}

fn drawn<T: Real>(scene: &Scene, key: &str, shape: &ShapeSpec) -> Result<Vec<T>, Failure> {
    let density = shape
        .rasterise(&scene.canvas(), scene.document.folder())
        .map_err(|error| refusal(scene, key, &error))?;
    Ok(narrowed(density))
}

/// `values` rounded to the precision of the solve.
fn narrowed<T: Real>(values: Vec<f64>) -> Vec<T> {
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
