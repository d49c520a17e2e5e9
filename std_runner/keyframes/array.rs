//! `file = "x.npy"` or "x.npz": densities from NumPy, of any size.

use std::path::Path;

use super::error::Fault;
use super::note::Note;
use super::npz;
use super::resample::{Edge, resample, windows_of_box};
use super::{Canvas, ShapeError};

/// The array, stretched over the box.
pub(super) fn draw(
    path: &Path,
    name: Option<&str>,
    canvas: &Canvas,
    notes: &mut Vec<Note>,
) -> Result<Vec<f64>, ShapeError> {
    densities(path, name, canvas, notes).map_err(|fault| fault.of("file", path))
}

fn densities(
    path: &Path,
    name: Option<&str>,
    canvas: &Canvas,
    notes: &mut Vec<Note>,
) -> Result<Vec<f64>, Fault> {
    let mut array = npz::read(path, name)?;
    if array.shape.len() != canvas.dimensions() || array.values.is_empty() {
        let order = if canvas.dimensions() == 3 {
            "[z, y, x]"
        } else {
            "[y, x]"
        };
        let found = format!("has the shape ({})", array.size_in_words());
        let remedy = format!(
            "a {}D grid takes an array with axes {order} and at least one value",
            canvas.dimensions()
        );
        return Err(Fault::content(found, remedy));
    }
    array.refuse_not_finite()?;
    if let Some(text) = array.clip()? {
        notes.push(Note::remark(format!("`{}` {text}", path.display())));
    }
    let shape: Vec<usize> = array.shape.iter().rev().copied().collect();
    let taps: Vec<_> = shape
        .iter()
        .zip(&canvas.cells)
        .enumerate()
        .map(|(axis, (&samples, &cells))| {
            let edge = if canvas.repeats(axis) {
                Edge::Wrap
            } else {
                Edge::Clamp
            };
            windows_of_box(cells, samples, edge)
        })
        .collect();
    Ok(resample(array.values, &shape, &taps))
}
