//! The keys of a shape, as the scene file writes them.

use std::path::{Path, PathBuf};

use schemars::JsonSchema;
use serde::Deserialize;

use super::mesh::FitKey;

/// One table of a scene that says where smoke is: the keys of one shape, or `shapes = [ ... ]`.
///
/// Deserialising refuses unknown keys and wrong types; [`rasterise`](Self::rasterise) refuses the rest.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, JsonSchema)]
#[serde(
    deny_unknown_fields,
    expecting = "a table with one shape, as in { circle = { center = [0.5, 0.5], radius = 0.2 } }"
)]
#[schemars(description = "Where smoke is: the keys of one shape, or `shapes = [ ... ]`.")]
pub struct ShapeSpec {
    /// A round body.
    pub(super) circle: Option<BallKeys>,
    /// The same, in space.
    pub(super) sphere: Option<BallKeys>,
    /// A body with straight sides along the axes.
    #[serde(rename = "box")]
    pub(super) block: Option<BlockKeys>,
    /// A ring.
    pub(super) torus: Option<TorusKeys>,
    /// All points within `radius` of a line.
    pub(super) capsule: Option<CapsuleKeys>,
    /// Letters, in one line or several.
    pub(super) text: Option<String>,
    /// A flat picture: PNG, JPEG, TIFF, WebP, EXR or SVG.
    pub(super) image: Option<PathBuf>,
    /// An array (.npy, .npz) or a volume (.vdb).
    pub(super) file: Option<PathBuf>,
    /// A body by its surface: .obj, .stl, .ply, .gltf or .glb.
    pub(super) mesh: Option<PathBuf>,
    /// Several shapes, added up.
    pub(super) shapes: Option<Vec<ShapeSpec>>,
    /// Of every shape: its density inside, 1 if not given.
    pub(super) density: Option<f64>,
    /// Of `text`: a TrueType or OpenType file.
    pub(super) font: Option<PathBuf>,
    /// Of `text`: height of a capital letter.
    pub(super) height: Option<f64>,
    /// Of `text`: the middle of the ink.
    pub(super) center: Option<Vec<f64>>,
    /// Of `text` and `image` in 3D: thickness along y.
    pub(super) depth: Option<f64>,
    /// Of `text`: by how much of the height every stroke is thickened.
    pub(super) weight: Option<f64>,
    /// Of `image`: which pixels are smoke, "light", "dark" or "alpha".
    #[schemars(extend("enum" = ["light", "dark", "alpha"]))]
    pub(super) ink: Option<String>,
    /// Of `file` = "x.npz": the array.
    pub(super) name: Option<String>,
    /// Of `file`: which entry along its first axis, where that is time.
    pub(super) entry: Option<EntryKey>,
    /// Of `mesh`: where it stands, "world" or a table.
    pub(super) fit: Option<FitKey>,
    /// Of `mesh`: the axis of the file that points up, "y" or "z".
    #[schemars(extend("enum" = ["y", "z"]))]
    pub(super) up: Option<String>,
    /// Of `file`, in a sequence: the step along its first axis.
    #[serde(skip)]
    pub(super) step: Option<usize>,
    /// Of a mesh or a volume, in a sequence: the file by whose size all are placed.
    #[serde(skip)]
    pub(super) first: Option<PathBuf>,
}

impl ShapeSpec {
    /// The same with the file at `path`, one of a sequence that begins with `first`: an array, a mesh or a picture, by its extension.
    pub(crate) fn of_file(&self, path: PathBuf, first: &Path) -> Self {
        let extension = path
            .extension()
            .map(|extension| extension.to_string_lossy().to_ascii_lowercase());
        let mut shape = self.clone();
        match extension.as_deref() {
            Some("npy" | "npz") => shape.file = Some(path),
            Some("vdb") => {
                shape.first = Some(first.to_owned());
                shape.file = Some(path);
            }
            Some("obj" | "stl" | "ply" | "gltf" | "glb") => {
                shape.first = Some(first.to_owned());
                shape.mesh = Some(path);
            }
            _ => {
                shape.first = Some(first.to_owned());
                shape.image = Some(path);
            }
        }
        shape
    }

    /// The same at a step of its array.
    pub(crate) fn of_step(&self, step: usize) -> Self {
        Self {
            step: Some(step),
            ..self.clone()
        }
    }

    /// The names of all keys, as a table that has others beside them needs to know them.
    pub(crate) const KEYS: &[&str] = &[
        "circle", "sphere", "box", "torus", "capsule", "text", "image", "file", "mesh", "shapes", "density",
        "font", "height", "center", "depth", "weight", "ink", "name", "entry", "fit", "up",
    ];

    /// The keys that name a file; `control.initial_velocity` has one of them.
    pub(crate) const FILES: &[&str] = &["image", "file", "mesh", "font"];

    /// The key of a keyframe or an emitter that names many, by a pattern.
    pub(crate) const PATTERN: &str = "files";
}

/// An entry along the first axis of an array.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(untagged, expecting = "`entry` must be a whole number from 0, or \"last\"")]
pub(super) enum EntryKey {
    Number(usize),
    Word(String),
}

/// `circle`, `sphere`.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, expecting = "{ center = [x, y], radius = r }")]
pub(super) struct BallKeys {
    /// Its middle.
    pub center: Vec<f64>,
    /// Its radius.
    pub radius: f64,
}

/// `box`.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, expecting = "{ min = [x, y], max = [x, y] }")]
pub(super) struct BlockKeys {
    /// The corner where every coordinate is smallest.
    pub min: Vec<f64>,
    /// The corner where every coordinate is largest.
    pub max: Vec<f64>,
}

/// `torus`; in 2D a ring.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(
    deny_unknown_fields,
    expecting = "{ center = [x, y, z], axis = \"z\", radius = r, tube = r }"
)]
pub(super) struct TorusKeys {
    /// Its middle.
    pub center: Vec<f64>,
    /// In 3D: the direction through its hole.
    pub axis: Option<AxisKey>,
    /// From its middle to the middle of the tube.
    pub radius: f64,
    /// The radius of the tube.
    pub tube: f64,
}

/// A direction: the name of an axis, or three numbers.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(untagged, expecting = "`axis` must be \"x\", \"y\", \"z\" or three numbers")]
pub(super) enum AxisKey {
    Name(String),
    Vector(Vec<f64>),
}

/// `capsule`.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, expecting = "{ from = [x, y], to = [x, y], radius = r }")]
pub(super) struct CapsuleKeys {
    /// Where the line begins.
    pub from: Vec<f64>,
    /// Where the line ends.
    pub to: Vec<f64>,
    /// How far it reaches around the line.
    pub radius: f64,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_keys_are_listed() {
        let refused = toml::from_str::<ShapeSpec>("no_such_key = 1").err();
        let refused = refused.map(|error| error.to_string()).unwrap_or_default();
        let listed = ShapeSpec::KEYS.join("`, `");
        assert!(
            refused.contains(&format!("expected one of `{listed}`")),
            "{refused}"
        );
    }
}
