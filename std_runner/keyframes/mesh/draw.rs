//! A mesh file on the cells of a box.

use std::path::Path;

use super::found;
use super::place::{Fit, FitKey, Up, turn};
use super::read::{has_y_up, read};
use super::voxels::{Edge, fill};
use crate::keyframes::check::FAINTEST;
use crate::keyframes::error::Fault;
use crate::keyframes::note::Note;
use crate::keyframes::{Canvas, ShapeError};

/// How a mesh is placed.
pub(in crate::keyframes) struct Placed<'a> {
    /// The key `fit`.
    pub fit: Option<&'a FitKey>,
    /// The key `up`.
    pub up: Option<&'a str>,
    /// The file whose size and place count, where that is another one: a mesh of a sequence moves as its first one was placed.
    pub first: Option<&'a Path>,
    /// How a mesh ends.
    pub edge: Edge,
}

/// The body of the surface in the file at `path`; what was found of it is added to `notes`.
pub(in crate::keyframes) fn draw(
    path: &Path,
    placed: &Placed<'_>,
    canvas: &Canvas,
    notes: &mut Vec<Note>,
) -> Result<Vec<f64>, ShapeError> {
    if canvas.dimensions() != 3 {
        let remedy = "use `image`, `text`, `file` or the flat shapes in 2D";
        return Err(ShapeError::key("mesh", "is a body, and the grid is 2D", remedy));
    }
    let up = match placed.up {
        Some(word) => Up::parse(word)?,
        None if has_y_up(path) => Up::Y,
        None => Up::Z,
    };
    let surface = |path: &Path| {
        let mut surface = read(path).map_err(|fault| fault.of("mesh", path))?;
        turn(&mut surface, up);
        Ok::<_, ShapeError>(surface)
    };
    let mut body = surface(path)?;
    let bounds = match placed.first {
        Some(first) if first != path => surface(first)?.bounds(),
        _ => body.bounds(),
    };
    Fit::of(placed.fit, bounds, canvas)?.apply(&mut body);
    let filled = fill(&body, canvas, placed.edge);
    let (said, shown) = (found::sentence(&body, &filled), path.display());
    notes.push(Note::remark(format!("mesh `{shown}`, {} up, {said}", up.name())));
    if let Some(sides) = canvas.left(body.bounds()) {
        notes.push(Note::warning(format!(
            "a part of the mesh `{shown}` lies outside of the box, {sides}, and is cut off; move it inwards, or make it smaller"
        )));
    } else if filled.density.iter().all(|&density| density < FAINTEST) {
        let remedy = "an open sheet or a body thinner than a cell has no inside: give it thickness (Solidify in Blender, Thicken of PolyExtrude in Houdini), or more cells";
        return Err(Fault::content("encloses no cell", remedy).of("mesh", path));
    }
    Ok(filled.density)
}
