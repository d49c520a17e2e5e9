//! Shapes of a scene on its cells, and the sentences where they cannot be used.

use crate::exit::Failure;
use crate::keyframes::{Canvas, Note, ShapeError, ShapeSpec};
use crate::scene::Scene;
use std::path::Path;
use thurible_core::{InputError, Real};

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
    drawn_by(ShapeSpec::rasterise_noting, scene, (key, shape), notes).map(narrowed)
}

/// Draws a shape, which stands at `key`, for cells that are in it from 0.5 on.
fn cut(scene: &Scene, key: &str, shape: &ShapeSpec, notes: &mut Vec<Note>) -> Result<Vec<f64>, Failure> {
    drawn_by(ShapeSpec::cut_noting, scene, (key, shape), notes)
}

/// Draws the obstacles: a cell of which they cover at least half is solid. Nothing where the scene has none.
pub(crate) fn solid_cells(scene: &Scene, notes: &mut Vec<Note>) -> Result<Option<Vec<bool>>, Failure> {
    if scene.obstacles.is_empty() {
        return Ok(None);
    }
    let mut solid = vec![false; scene.grid.cells.iter().product()];
    for (key, shape) in &scene.obstacles {
        let covered = cut(scene, key, shape, notes)?;
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

/// A way to draw a shape.
type How = fn(&ShapeSpec, &Canvas, &Path, &mut Vec<Note>) -> Result<Vec<f64>, ShapeError>;

fn drawn_by(
    how: How,
    scene: &Scene,
    (key, shape): (&str, &ShapeSpec),
    notes: &mut Vec<Note>,
) -> Result<Vec<f64>, Failure> {
    let mut said = Vec::new();
    let density = how(shape, &scene.canvas(), scene.document.folder(), &mut said)
        .map_err(|error| refusal(scene, key, &error))?;
    notes.extend(said.into_iter().map(|note| note.of(key)));
    Ok(density)
}

/// `values` rounded to the precision of the solve.
pub(crate) fn narrowed<T: Real>(values: Vec<f64>) -> Vec<T> {
    values.into_iter().map(T::from_f64).collect()
}

/// The failure for a shape's error, with the place of its key in the scene.
pub(crate) fn refusal(scene: &Scene, table: &str, error: &ShapeError) -> Failure {
    let (ShapeError::Key { key, .. } | ShapeError::File { key, .. } | ShapeError::Read { key, .. }) = error;
    let place = scene.document.place(&format!("{table}.{key}"));
    let sentence = format!("{place}: in {table}: {error}");
    error.failure(sentence)
}
