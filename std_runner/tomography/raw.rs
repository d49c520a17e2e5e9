//! The file of views as TOML spells it; serde refuses unknown keys and wrong types.

use serde::Deserialize;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawViews {
    pub r#box: RawBox,
    #[serde(default)]
    pub pictures: RawPictures,
    pub camera: Vec<RawCamera>,
    #[serde(default)]
    pub novel: Vec<RawCamera>,
    #[serde(default)]
    pub tomography: RawSettings,
    pub truth: Option<RawTruth>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawBox {
    pub cells: Vec<i64>,
    pub length: Option<f64>,
    pub origin: Option<Vec<f64>>,
}

#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawPictures {
    pub scale: Option<f64>,
    pub light: Option<String>,
    pub dt: Option<f64>,
    pub first: Option<usize>,
    pub last: Option<usize>,
}

/// What a camera sees without smoke: the same everywhere, or a picture.
#[derive(Deserialize)]
#[serde(untagged)]
pub(super) enum RawBackground {
    Level(f64),
    File(String),
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawCamera {
    pub name: Option<String>,
    pub kind: Option<String>,
    pub azimuth: Option<f64>,
    pub elevation: Option<f64>,
    pub direction: Option<Vec<f64>>,
    pub up: Option<Vec<f64>>,
    pub center: Option<Vec<f64>>,
    pub pitch: Option<f64>,
    pub position: Option<Vec<f64>>,
    pub target: Option<Vec<f64>>,
    pub field_of_view: Option<f64>,
    pub matrix: Option<Vec<Vec<f64>>>,
    pub file: Option<String>,
    pub array: Option<String>,
    pub files: Option<String>,
    pub background: Option<RawBackground>,
    pub scale: Option<f64>,
    /// Of a novel view without pictures.
    pub size: Option<Vec<usize>>,
}

#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawSettings {
    pub method: Option<String>,
    pub prior: Option<String>,
    pub gamma: Option<toml::Value>,
    pub nonnegative: Option<bool>,
    pub volume: Option<bool>,
    pub sigma: Option<f64>,
    pub length: Option<u64>,
    pub budget: Option<f64>,
    pub eps: Option<toml::Value>,
    pub accept: Option<f64>,
    pub tolerance: Option<f64>,
    pub walk: Option<String>,
    pub hull_threshold: Option<f64>,
    pub seed: Option<u64>,
    pub warm: Option<bool>,
    pub warm_budget: Option<f64>,
    pub sweeps: Option<usize>,
    pub relax: Option<f64>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawTruth {
    pub file: String,
    pub array: Option<String>,
}
