//! The arrays of a result, and the flow that a capture may begin with.

use super::files::refused;
use super::plan::Planned;
use super::scene::CaptureScene;
use crate::exit::Failure;
use crate::keyframes::Series;
use crate::output::Store;
use thurible_core::{Real, Space, Tracker};

/// The ends of the names of components.
const AXES: [&str; 3] = ["x", "y", "z"];
/// The names of what a pair hands out, in its order.
const PARTS: [&str; 4] = ["predicted", "correction", "velocity", "force"];

/// The numbers of the arrays in the store; none of those that there are not.
pub(super) struct Arrays {
    pub captured: usize,
    pub density: usize,
    pub emission: usize,
    /// Predicted, correction, velocity and force, by axis.
    pub faces: [[usize; 3]; 4],
    pub truth: [usize; 3],
}

impl Arrays {
    /// Begins the arrays of the result.
    pub fn begin<S: Space>(planned: &Planned, store: &mut Store) -> Result<Self, Failure> {
        let given = &planned.given;
        let cells: Vec<usize> = given.cells.iter().rev().copied().collect();
        let captured = store.begin("captured", cells.clone())?;
        let density = if planned.params.readvect {
            store.begin("density", cells.clone())?
        } else {
            usize::MAX
        };
        let emission = if given.has_emission() {
            store.begin("emission", cells)?
        } else {
            usize::MAX
        };
        let mut faces = [[usize::MAX; 3]; 4];
        let mut truth = [usize::MAX; 3];
        let handed_out = if planned.params.forces { 4 } else { 3 };
        let parts = PARTS.into_iter().zip(&mut faces).take(handed_out);
        let truths = given.has_truth().then_some(("truth", &mut truth));
        for (name, places) in parts.chain(truths) {
            for (axis, place) in places.iter_mut().enumerate().take(S::DIM) {
                *place = store.begin(&format!("{name}_{}", AXES[axis]), given.faces(axis))?;
            }
        }
        Ok(Self {
            captured,
            density,
            emission,
            faces,
            truth,
        })
    }
}

/// Gives the velocity of the first pair, where one is given.
pub(super) fn give_initial_velocity<T: Real, S: Space>(
    scene: &CaptureScene,
    tracker: &mut Tracker<'_, T, S>,
) -> Result<(), Failure> {
    let Some(path) = &scene.initial_velocity else {
        return Ok(());
    };
    let key = "track.initial_velocity";
    for (axis, name) in AXES.iter().enumerate().take(S::DIM) {
        let name = format!("velocity_{name}");
        let refuse = |why: String| {
            Failure::Input(format!(
                "{}: `{key}` file `{}` {why}",
                scene.document.place(key),
                path.display()
            ))
        };
        let mut series =
            Series::open(path, Some(&name), key).map_err(|error| refused(&scene.document, key, &error))?;
        // A velocity alone has an axis for each of the box; with one more it is of steps, and the first counts.
        let alone = series.shape().len() < S::DIM;
        let mut faces: Vec<T> = Vec::new();
        for entry in 0..if alone { series.count() } else { 1 } {
            let read = series.read(entry);
            let read = read.map_err(|error| refused(&scene.document, key, &error))?;
            faces.extend(read.into_iter().map(T::from_f64));
        }
        let taken = tracker.set_initial_velocity(axis, &faces);
        taken.map_err(|error| {
            refuse(format!(
                "has {name} that is refused: {error}; give that of the same cells and boundary"
            ))
        })?;
    }
    Ok(())
}
