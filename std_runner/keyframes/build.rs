//! From the keys of a shape to the body that they describe.

use std::path::Path;

use super::solid::{Ball, Block, Capsule, Solid, Torus, norm};
use super::spec::{AxisKey, TorusKeys};
use super::{Canvas, ShapeError, ShapeSpec, check, text};

/// Sides of a box that are shorter than those of a periodic one by no more than this part of them go all the way round.
const ROUNDED: f64 = 1e-9;

/// The body that `spec` describes.
pub(super) fn solid(spec: &ShapeSpec, canvas: &Canvas, base: &Path) -> Result<Box<dyn Solid>, ShapeError> {
    for (key, keys) in [("circle", &spec.circle), ("sphere", &spec.sphere)] {
        if let Some(ball) = keys {
            let center = check::point(&format!("{key}.center"), &ball.center, canvas)?;
            let radius = check::positive(&format!("{key}.radius"), ball.radius, canvas)?;
            return Ok(Box::new(Ball { center, radius }));
        }
    }
    if let Some(keys) = &spec.block {
        return block(&keys.min, &keys.max, canvas);
    }
    if let Some(keys) = &spec.torus {
        return torus(keys, canvas);
    }
    if let Some(keys) = &spec.capsule {
        let from = check::point("capsule.from", &keys.from, canvas)?;
        let to = check::point("capsule.to", &keys.to, canvas)?;
        let radius = check::positive("capsule.radius", keys.radius, canvas)?;
        return Ok(Box::new(Capsule { from, to, radius }));
    }
    Ok(Box::new(text::solid(spec, canvas, base)?))
}

fn block(min: &[f64], max: &[f64], canvas: &Canvas) -> Result<Box<dyn Solid>, ShapeError> {
    let low = check::full_point("box.min", min, canvas)?;
    let high = check::full_point("box.max", max, canvas)?;
    let mut half = [f64::INFINITY; 3];
    for (axis, side) in half.iter_mut().enumerate().take(canvas.dimensions()) {
        *side = 0.5 * (high[axis] - low[axis]);
        if *side <= 0.0 {
            let found = format!(
                "is {} along axis {}, not above `box.min` = {}",
                high[axis],
                ["x", "y", "z"][axis],
                low[axis]
            );
            return Err(ShapeError::key(
                "box.max",
                found,
                "`min` is the lower corner, `max` the upper one",
            ));
        }
        // All the way round there is no side.
        if canvas.repeats(axis) && high[axis] - low[axis] >= canvas.extent()[axis] * (1.0 - ROUNDED) {
            *side = f64::INFINITY;
        }
    }
    let center = core::array::from_fn(|axis| 0.5 * (low[axis] + high[axis]));
    Ok(Box::new(Block { center, half }))
}

fn torus(keys: &TorusKeys, canvas: &Canvas) -> Result<Box<dyn Solid>, ShapeError> {
    Ok(Box::new(Torus {
        center: check::point("torus.center", &keys.center, canvas)?,
        axis: direction(keys.axis.as_ref(), canvas)?,
        radius: check::positive("torus.radius", keys.radius, canvas)?,
        tube: check::positive("torus.tube", keys.tube, canvas)?,
    }))
}

/// The unit vector that `torus.axis` names; z if it names none.
fn direction(axis: Option<&AxisKey>, canvas: &Canvas) -> Result<[f64; 3], ShapeError> {
    const ALLOWED: &str = "write \"x\", \"y\", \"z\" or three numbers that are not all 0";
    let refuse = |found: String| Err(ShapeError::key("torus.axis", found, ALLOWED));
    let vector = match axis {
        None => [0.0, 0.0, 1.0],
        Some(AxisKey::Name(name)) => match name.as_str() {
            "x" => [1.0, 0.0, 0.0],
            "y" => [0.0, 1.0, 0.0],
            "z" => [0.0, 0.0, 1.0],
            other => return refuse(format!("is \"{other}\"")),
        },
        Some(AxisKey::Vector(given)) => match given.as_slice() {
            &[x, y, z] => [x, y, z],
            other => return refuse(format!("has {} numbers", other.len())),
        },
    };
    let size = norm(vector);
    if !(size > 1e-100 && size < 1e100) {
        return refuse(format!("is {vector:?}"));
    }
    if canvas.dimensions() == 2 && (vector[0], vector[1]) != (0.0, 0.0) {
        return Err(ShapeError::key(
            "torus.axis",
            "tilts out of a 2D grid",
            "leave it out: in 2D a torus is a ring",
        ));
    }
    Ok(vector.map(|component| component / size))
}
