//! An initial velocity from a file, laid out as a result is.

use std::path::Path;

use super::ending::ends_with;
use super::error::Fault;
use super::npz;
use super::{Canvas, ShapeError};

/// The names of a velocity's components in files.
pub(crate) const VELOCITY: [&str; 3] = ["velocity_x", "velocity_y", "velocity_z"];

/// Reads `velocity_x`, `velocity_y` (and `velocity_z`) of a `.npz` file, one list of faces an axis, x fastest.
///
/// A component has one face more than cells along its own axis if that axis is a wall. A leading axis of length 1
/// (one step of a result) is allowed.
///
/// # Errors
/// A file that cannot be read, lacks a component, has another size, or holds a value that is not finite.
pub fn read_velocity(path: &Path, canvas: &Canvas) -> Result<Vec<Vec<f64>>, ShapeError> {
    read(path, canvas, faces)
}

/// The same at the centres of cells, where a component has as many numbers as there are cells.
///
/// # Errors
/// As [`read_velocity`].
pub fn read_centered_velocity(path: &Path, canvas: &Canvas) -> Result<Vec<Vec<f64>>, ShapeError> {
    read(path, canvas, |axis, canvas| {
        let (name, _) = faces(axis, canvas);
        (name, canvas.cells.iter().rev().copied().collect())
    })
}

/// The name and the shape of a component on the cells of a box.
type Shape = fn(usize, &Canvas) -> (&'static str, Vec<usize>);

fn read(path: &Path, canvas: &Canvas, shape: Shape) -> Result<Vec<Vec<f64>>, ShapeError> {
    let component = |axis: usize| {
        component(path, shape(axis, canvas)).map_err(|fault| fault.of("initial_velocity", path))
    };
    (0..canvas.dimensions()).map(component).collect()
}

fn component(path: &Path, (name, expected): (&'static str, Vec<usize>)) -> Result<Vec<f64>, Fault> {
    if ends_with(path, "npy") {
        return Err(Fault::content(
            "is one array",
            "save velocity_x, velocity_y (and velocity_z) together by numpy.savez",
        ));
    }
    let array = npz::read(path, Some(name))?;
    let one_step = array.shape.len() == expected.len() + 1 && array.shape.first() == Some(&1);
    if array.shape.get(usize::from(one_step)..) != Some(expected.as_slice()) {
        let found = format!("has {name} of shape ({})", array.size_in_words());
        let remedy =
            format!("on this grid it is {expected:?}; save one step of a result with the same cells");
        return Err(Fault::content(found, remedy));
    }
    array.refuse_not_finite()?;
    Ok(array.values)
}

/// The name of a velocity's component and its shape, x last.
pub(super) fn faces(axis: usize, canvas: &Canvas) -> (&'static str, Vec<usize>) {
    let name = VELOCITY.get(axis).copied().unwrap_or_default();
    let mut shape = canvas.cells.clone();
    if let Some(faces) = shape.get_mut(axis) {
        *faces += usize::from(!canvas.repeats(axis));
    }
    shape.reverse();
    (name, shape)
}
