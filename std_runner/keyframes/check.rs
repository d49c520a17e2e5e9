//! Numbers of a scene, refused at the door.

use super::{Canvas, ShapeError};

/// Coordinates and sizes beyond this many lengths of the box are refused, so that nothing overflows.
const FARTHEST: f64 = 1e6;

/// A shape whose largest density stays below this puts nothing into the box.
pub(super) const FAINTEST: f64 = 0.01;

/// A point with as many coordinates as the grid; in 3D a missing third one is the middle.
pub(super) fn point(key: &str, given: &[f64], canvas: &Canvas) -> Result<[f64; 3], ShapeError> {
    let mut point = canvas.middle();
    let dimensions = canvas.dimensions();
    if given.len() != dimensions && !(dimensions == 3 && given.len() == 2) {
        let remedy = if dimensions == 3 {
            "write three, [x, y, z] (or [x, y]; z is then the middle)"
        } else {
            "the grid is 2D, write two: [x, y]"
        };
        return Err(ShapeError::key(
            key,
            format!("has {} numbers", given.len()),
            remedy,
        ));
    }
    for (coordinate, &value) in point.iter_mut().zip(given) {
        *coordinate = within(key, value, canvas)?;
    }
    Ok(point)
}

/// A point all of whose coordinates must be written.
pub(super) fn full_point(key: &str, given: &[f64], canvas: &Canvas) -> Result<[f64; 3], ShapeError> {
    if given.len() != canvas.dimensions() {
        let remedy = format!("the grid is {0}D, write {0}", canvas.dimensions());
        return Err(ShapeError::key(
            key,
            format!("has {} numbers", given.len()),
            remedy,
        ));
    }
    point(key, given, canvas)
}

/// A length above 0.
pub(super) fn positive(key: &str, value: f64, canvas: &Canvas) -> Result<f64, ShapeError> {
    if within(key, value, canvas)? <= 0.0 {
        let remedy = format!(
            "it must be above 0, in the unit of `grid.length` (the longest side is {})",
            canvas.length
        );
        return Err(ShapeError::key(key, format!("is {value:?}"), remedy));
    }
    Ok(value)
}

fn within(key: &str, value: f64, canvas: &Canvas) -> Result<f64, ShapeError> {
    if !value.is_finite() || value.abs() > FARTHEST * canvas.length {
        let remedy = format!(
            "write a number within the box, whose longest side is {}",
            canvas.length
        );
        return Err(ShapeError::key(key, format!("is {value:?}"), remedy));
    }
    Ok(value)
}
