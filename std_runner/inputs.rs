//! What a solve starts from, drawn from the scene before any large memory is taken.

use crate::exit::Failure;
use crate::keyframes::{ShapeError, ShapeSpec, read_last, read_velocity};
use crate::scene::Scene;
use std::path::Path;
use thurible_core::{InputError, Real, Solver, SolverError, Space};

/// Source, keyframes and initial velocity in double precision.
#[derive(Clone, Debug)]
pub struct Inputs {
    source: Vec<f64>,
    keyframes: Vec<Vec<f64>>,
    velocity: Option<Vec<Vec<f64>>>,
}

impl Inputs {
    /// Draws every shape of `scene` and reads the files that it names.
    pub fn draw(scene: &Scene) -> Result<Self, Failure> {
        let source = drawn(scene, "source", &scene.source)?;
        let keyframes = scene.keyframes.iter().map(|keyframe| drawn(scene, &keyframe.key, &keyframe.shape));
        let keyframes = keyframes.collect::<Result<_, _>>()?;
        let file = scene.control.initial_velocity.as_ref();
        let velocity = file.map(|path| read_velocity(path, &scene.canvas())).transpose();
        let velocity = velocity.map_err(|error| refusal(scene, "control", &error))?;
        Ok(Inputs { source, keyframes, velocity })
    }

    /// The last density and velocity of the result in `folder`; what little of the density is negative is set to 0.
    pub fn last_of(scene: &Scene, folder: &Path) -> Result<Self, Failure> {
        let failure = |error: ShapeError| {
            let sentence = format!("--from {}: {error}", folder.display());
            if error.is_unreadable() { Failure::File(sentence) } else { Failure::Input(sentence) }
        };
        let (density, velocity) = read_last(&folder.join("result.npz"), &scene.canvas()).map_err(failure)?;
        let source = density.into_iter().map(|value| value.max(0.0)).collect();
        Ok(Inputs { source, keyframes: Vec::new(), velocity: Some(velocity) })
    }

    /// Hands everything to `solver`, source first; the answer is the mass factor of each keyframe.
    pub fn hand_over<T: Real, S: Space>(&self, scene: &Scene, solver: &mut Solver<'_, T, S>) -> Result<Vec<f64>, Failure> {
        let narrowed = |values: &[f64]| -> Vec<T> { values.iter().map(|&value| T::from_f64(value)).collect() };
        let refuse = |key: &str| {
            let key = key.to_string();
            move |error: InputError| scene.document.refuse(&key, format!("cannot be used: {error}; change it in the scene"))
        };
        solver.set_source(&narrowed(&self.source)).map_err(refuse("source"))?;
        for (axis, faces) in self.velocity.iter().flatten().enumerate() {
            solver.set_initial_velocity(axis, &narrowed(faces)).map_err(refuse("control.initial_velocity"))?;
        }
        let targets = self.keyframes.iter().zip(&scene.keyframes).enumerate();
        targets.map(|(index, (density, keyframe))| solver.set_keyframe(index, &narrowed(density)).map_err(refuse(&keyframe.key))).collect()
    }
}

fn drawn(scene: &Scene, key: &str, shape: &ShapeSpec) -> Result<Vec<f64>, Failure> {
    shape.rasterise(&scene.canvas(), scene.document.folder()).map_err(|error| refusal(scene, key, &error))
}

/// The sentence of a shape's error with the place of its key in the scene.
fn refusal(scene: &Scene, table: &str, error: &ShapeError) -> Failure {
    let (ShapeError::Key { key, .. } | ShapeError::File { key, .. } | ShapeError::Read { key, .. }) = error;
    let place = scene.document.place(&format!("{table}.{key}"));
    let sentence = format!("{place}: in {table}: {error}");
    if error.is_unreadable() { Failure::File(sentence) } else { Failure::Input(sentence) }
}

/// The sentence for a solver that could not be made in a block of the planned size.
pub fn solver_refusal(error: &SolverError) -> Failure {
    Failure::Memory(format!("the solver refused its block of memory: {error}; this is a fault of thurible, please report it"))
}
