//! An initial velocity from a file, laid out as a result is.

use std::path::Path;

use super::error::Fault;
use super::npz;
use super::{Canvas, ShapeError};

/// Reads `velocity_x`, `velocity_y` (and `velocity_z`) of a `.npz` file, one list of faces an axis, x fastest.
///
/// A component has one face more than cells along its own axis if that axis is a wall. A leading axis of length 1
/// (one step of a result) is allowed.
///
/// # Errors
/// A file that cannot be read, lacks a component, has another size, or holds a value that is not finite.
pub fn read_velocity(path: &Path, canvas: &Canvas) -> Result<Vec<Vec<f64>>, ShapeError> {
    let component = |axis: usize| component(path, axis, canvas).map_err(|fault| fault.of("initial_velocity", path));
    (0..canvas.dimensions()).map(component).collect()
}

fn component(path: &Path, axis: usize, canvas: &Canvas) -> Result<Vec<f64>, Fault> {
    let (name, expected) = faces(axis, canvas);
    let array = npz::read(path, Some(name))?;
    let one_step = array.shape.len() == expected.len() + 1 && array.shape.first() == Some(&1);
    if array.shape.get(usize::from(one_step)..) != Some(expected.as_slice()) {
        let found = format!("has {name} of shape ({})", array.size_in_words());
        let remedy = format!("its faces on this grid are {expected:?}; save one step of a result with the same cells");
        return Err(Fault::content(found, remedy));
    }
    array.refuse_not_finite()?;
    Ok(array.values)
}

/// The name of a velocity's component and its shape, x last.
fn faces(axis: usize, canvas: &Canvas) -> (&'static str, Vec<usize>) {
    let name = ["velocity_x", "velocity_y", "velocity_z"].get(axis).copied().unwrap_or_default();
    let mut shape = canvas.cells.clone();
    if let Some(faces) = shape.get_mut(axis) {
        *faces += usize::from(!canvas.repeats(axis));
    }
    shape.reverse();
    (name, shape)
}

/// Reads the last `density` and the last velocity of a `result.npz`.
///
/// # Errors
/// As [`read_velocity`].
pub fn read_last(path: &Path, canvas: &Canvas) -> Result<(Vec<f64>, Vec<Vec<f64>>), ShapeError> {
    let cells: Vec<usize> = canvas.cells.iter().rev().copied().collect();
    let last = |name: &str, shape: &[usize]| last(path, name, shape).map_err(|fault| fault.of("result", path));
    let density = last("density", &cells)?;
    let velocity = (0..canvas.dimensions()).map(|axis| faces(axis, canvas)).map(|(name, shape)| last(name, &shape));
    Ok((density, velocity.collect::<Result<_, _>>()?))
}

/// The last step of the array `name`, whose steps have the shape `expected`.
fn last(path: &Path, name: &str, expected: &[usize]) -> Result<Vec<f64>, Fault> {
    let mut array = npz::read(path, Some(name))?;
    if array.shape.get(1..) != Some(expected) || array.shape.first() == Some(&0) {
        let found = format!("has {name} of shape ({})", array.size_in_words());
        return Err(Fault::content(found, format!("each of its steps on this grid is {expected:?}; give a result with the same cells and boundary")));
    }
    array.refuse_not_finite()?;
    let count: usize = expected.iter().product();
    Ok(array.values.split_off(array.values.len() - count))
}
