//! The keys of a scene and their types.

use serde::Deserialize;
use toml::Value;

#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawScene {
    pub mesh: Option<RawMesh>,
    pub material: Option<RawMaterial>,
    pub time: Option<RawTime>,
    #[serde(default)]
    pub hold: Vec<RawHold>,
    #[serde(default)]
    pub spring: Vec<RawSpring>,
    pub load: Option<RawLoad>,
    pub solver: Option<RawSolver>,
    /// Read before, by `cases`.
    #[serde(rename = "sweep")]
    pub _sweep: Option<Value>,
}

#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawMesh {
    pub grid: Option<Vec<i64>>,
    pub size: Option<Vec<f64>>,
    pub file: Option<String>,
    pub rod: Option<i64>,
    pub length: Option<f64>,
    pub area: Option<f64>,
}

#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawMaterial {
    pub young: Option<f64>,
    pub poisson: Option<f64>,
    pub density: Option<f64>,
}

#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawTime {
    pub steps: Option<i64>,
    pub dt: Option<f64>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawHold {
    #[serde(rename = "box")]
    pub bounds: RawBox,
    #[serde(rename = "move")]
    pub by: Option<Vec<f64>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawBox {
    pub min: Vec<f64>,
    pub max: Vec<f64>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawSpring {
    pub from: Vec<f64>,
    pub to: Vec<f64>,
    pub stiffness: f64,
    pub rest_length: f64,
    pub in_basis: Option<bool>,
}

#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawLoad {
    pub gravity: Option<Vec<f64>>,
    pub impulse: Option<RawImpulse>,
    pub bump: Option<f64>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawImpulse {
    pub at: Vec<f64>,
    pub value: Vec<f64>,
}

#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawSolver {
    pub methods: Option<Vec<String>>,
    pub basis: Option<Value>,
    pub rebuild: Option<i64>,
    pub block: Option<String>,
    pub order: Option<String>,
    pub tolerance: Option<f64>,
    pub cap: Option<i64>,
    pub search: Option<bool>,
    pub radius: Option<i64>,
    pub noise: Option<f64>,
    pub seed: Option<i64>,
}

/// A key that takes several values, one after the other.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawSweep {
    pub key: String,
    pub values: Vec<Value>,
}
