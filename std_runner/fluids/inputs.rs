//! What a run starts from: drawn from the scene, one field at a time.

use crate::exit::Failure;
use crate::keyframes::{Note, read_centered_velocity};
use crate::run::drawn::{drawn, narrowed, refusal, refuse};
use crate::scene::Scene;
use thurible_core::{Fluids, Real, Space};

/// What came of the inputs.
#[derive(Default)]
pub(super) struct Inputs {
    /// By how much each keyframe was scaled to the mass of the source, for every step that it stands at.
    pub mass_factors: Vec<f64>,
    /// What the user should hear of the files that were read.
    pub notes: Vec<Note>,
}

/// Draws source and keyframes, and reads the velocity at the start.
pub(super) fn set<T: Real, S: Space>(
    scene: &Scene,
    fluids: &mut Fluids<'_, T, S>,
) -> Result<Inputs, Failure> {
    let (mut notes, mut mass_factors) = (Vec::new(), Vec::new());
    if let Some(source) = &scene.source {
        let density: Vec<T> = drawn(scene, "source", source, &mut notes)?;
        fluids.set_source(&density).map_err(refuse(scene, "source"))?;
    }
    for keyframe in &scene.keyframes {
        let density: Vec<T> = drawn(scene, &keyframe.key, &keyframe.shape, &mut notes)?;
        for _ in keyframe.stay().steps() {
            let set = fluids.set_keyframe(mass_factors.len(), &density);
            mass_factors.push(set.map_err(refuse(scene, &keyframe.key))?);
        }
    }
    if let Some(path) = &scene.control.initial_velocity {
        let read = read_centered_velocity(path, &scene.canvas());
        for (axis, velocity) in read
            .map_err(|error| refusal(scene, "control", &error))?
            .into_iter()
            .enumerate()
        {
            fluids
                .set_initial_velocity(axis, &narrowed(velocity))
                .map_err(refuse(scene, "control.initial_velocity"))?;
        }
    }
    Ok(Inputs { mass_factors, notes })
}
