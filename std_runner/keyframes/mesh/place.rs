//! Where a mesh stands in the box: as large as the box allows, at a place of the scene, or as its own coordinates say.

use schemars::JsonSchema;
use serde::Deserialize;

use super::surface::{Point, Surface};
use crate::keyframes::{Canvas, ShapeError, check};

/// A mesh fills this part of the box where nothing is said.
const USUAL: f64 = 0.8;

/// The key `fit`.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(
    untagged,
    expecting = "`fit` must be \"world\", or a table, as in { center = [0.5, 0.5, 0.5], size = 0.5 }"
)]
pub(in crate::keyframes) enum FitKey {
    Word(String),
    Place(FitPlace),
}

/// `fit = { center, size }`.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(in crate::keyframes) struct FitPlace {
    /// Where the middle of the mesh goes; the middle of the box if not given.
    pub center: Option<Vec<f64>>,
    /// Length of the longest side of the mesh.
    pub size: Option<f64>,
}

/// Which axis of a file points up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::keyframes) enum Up {
    Y,
    Z,
}

impl Up {
    /// The meaning of the key `up`.
    pub fn parse(word: &str) -> Result<Self, ShapeError> {
        match word {
            "y" => Ok(Self::Y),
            "z" => Ok(Self::Z),
            other => {
                let remedy = "write \"y\" or \"z\": the axis of the file that points up";
                Err(ShapeError::key("up", format!("is {other:?}"), remedy))
            }
        }
    }

    pub fn name(self) -> &'static str {
        match self {
            Self::Y => "y",
            Self::Z => "z",
        }
    }
}

/// Turns a surface so that z points up, as in the box.
pub(super) fn turn(surface: &mut Surface, up: Up) {
    if up == Up::Y {
        for point in &mut surface.points {
            let [x, y, z] = *point;
            *point = [x, -z, y];
        }
    }
}

/// A change of size, then of place.
pub(in crate::keyframes) struct Fit {
    pub scale: f64,
    pub shift: Point,
}

impl Fit {
    /// What takes a mesh with these `bounds` to where `key` wants it.
    pub fn of(key: Option<&FitKey>, bounds: [Point; 2], canvas: &Canvas) -> Result<Self, ShapeError> {
        let [low, high] = bounds;
        let sides: Point = core::array::from_fn(|axis| high[axis] - low[axis]);
        let longest = sides.into_iter().fold(0.0, f64::max);
        let given = match key {
            Some(FitKey::Word(word)) if word == "world" => {
                return Ok(Self {
                    scale: 1.0,
                    shift: [0.0; 3],
                });
            }
            Some(FitKey::Word(other)) => {
                let remedy = "write \"world\" for the file's own coordinates, or a table { center = [x, y, z], size = s }";
                return Err(ShapeError::key("fit", format!("is {other:?}"), remedy));
            }
            Some(FitKey::Place(place)) => Some(place),
            None => None,
        };
        if !(longest > 0.0) {
            return Err(ShapeError::key(
                "mesh",
                "has no size",
                "name a file with a body in it",
            ));
        }
        let center = match given.and_then(|place| place.center.as_deref()) {
            Some(center) => check::point("fit.center", center, canvas)?,
            None => canvas.middle(),
        };
        let scale = match given.and_then(|place| place.size) {
            Some(size) => check::positive("fit.size", size, canvas)? / longest,
            None => {
                let room = canvas
                    .extent()
                    .into_iter()
                    .zip(sides)
                    .filter(|&(_, side)| side > 0.0);
                room.map(|(extent, side)| USUAL * extent / side)
                    .fold(f64::INFINITY, f64::min)
            }
        };
        let shift = core::array::from_fn(|axis| center[axis] - scale * 0.5 * (low[axis] + high[axis]));
        Ok(Self { scale, shift })
    }

    /// Where a point goes.
    pub fn of_point(&self, point: Point) -> Point {
        core::array::from_fn(|axis| self.scale * point[axis] + self.shift[axis])
    }

    pub(super) fn apply(&self, surface: &mut Surface) {
        for point in &mut surface.points {
            *point = self.of_point(*point);
        }
    }
}
