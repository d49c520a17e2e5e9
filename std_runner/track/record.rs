//! The facts of a run of `track`, as `report.json` holds them.

use super::errors::Errors;
use super::plan::Planned;
use super::scene::CaptureScene;
use crate::report::{LedgerLine, by_name, by_side};
use serde::Serialize;
use serde_json::{Value, json};
use thurible_core::choices::{Choices, Value as Chosen};
use thurible_core::track::Pair;
use thurible_core::{Boundary, Status, TrackParams};

/// Everything that a program needs to check a result without its capture.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct TrackRecord {
    pub format: u32,
    pub kind: &'static str,
    pub cells: Vec<usize>,
    #[serde(serialize_with = "by_side")]
    pub boundary: Vec<Boundary>,
    pub length: f64,
    pub dt: f64,
    /// N, the pairs.
    pub steps: usize,
    pub density_scale: f64,
    pub precision: &'static str,
    pub threads: usize,
    pub version: &'static str,
    #[serde(serialize_with = "by_name")]
    pub status: Status,
    pub seconds: f64,
    pub memory: Memory,
    /// What was chosen, by name.
    pub track: Value,
    pub history: Vec<PairRecord>,
    /// None: other programs of the project look for them.
    pub keyframes: [(); 0],
    pub scene: String,
    pub overrides: Vec<String>,
    pub command: String,
    pub remarks: Vec<String>,
}

/// Bytes planned and used, and what for.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Memory {
    pub planned_bytes: usize,
    pub used_bytes: usize,
    pub ledger: Vec<LedgerLine>,
}

/// What is said of a pair.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct PairRecord {
    /// k, of the pair of frames k and k + 1.
    pub frame: usize,
    /// That it took.
    pub seconds: f64,
    pub data: f64,
    pub smoothness: f64,
    pub kinetic: f64,
    pub optimality: f64,
    /// Products by A on each grid, finest first.
    pub cg: Vec<usize>,
    /// Squared distance of frame k + 1 pulled back from frame k: by the prediction, and by the flow.
    pub misfit_predicted: f64,
    pub misfit: f64,
    /// The largest velocity, in cells a frame.
    pub fastest: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub readvection_error: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub velocity_rms_error: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub velocity_relative_error: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub angular_error: Option<f64>,
}

impl PairRecord {
    pub fn new(frame: usize, seconds: f64, pair: &Pair, readvect: bool, errors: Option<Errors>) -> Self {
        Self {
            frame,
            seconds,
            data: pair.terms.data,
            smoothness: pair.terms.smoothness,
            kinetic: pair.terms.kinetic,
            optimality: pair.terms.optimality,
            cg: pair.efforts.to_vec(),
            misfit_predicted: pair.misfit[0],
            misfit: pair.misfit[1],
            fastest: pair.fastest,
            readvection_error: readvect.then_some(pair.readvection),
            velocity_rms_error: errors.map(|errors| errors.rms),
            velocity_relative_error: errors.and_then(|errors| errors.relative),
            angular_error: errors.map(|errors| errors.angular),
        }
    }
}

/// How a run ended.
pub(super) struct Ended {
    pub status: Status,
    pub seconds: f64,
    /// Bytes that the block takes from the system.
    pub footprint: usize,
    pub history: Vec<PairRecord>,
}

impl TrackRecord {
    pub fn new(scene: &CaptureScene, planned: &Planned, ended: Ended) -> Self {
        let (given, plan) = (&planned.given, &planned.plan);
        let line = |entry: &thurible_core::Entry| LedgerLine {
            name: entry.name.into(),
            bytes: entry.bytes,
            depth: entry.depth,
        };
        Self {
            format: 1,
            kind: "track",
            cells: given.cells.clone(),
            boundary: given.boundary.clone(),
            length: given.length,
            dt: given.dt,
            steps: ended.history.len(),
            density_scale: given.density_scale,
            precision: planned.precision.name(),
            threads: planned.params.threads,
            version: env!("CARGO_PKG_VERSION"),
            status: ended.status,
            seconds: ended.seconds,
            memory: Memory {
                planned_bytes: plan.bytes(),
                used_bytes: ended.footprint,
                ledger: plan.entries().iter().map(line).collect(),
            },
            track: chosen(&planned.params, scene.buoyancy),
            history: ended.history,
            keyframes: [],
            scene: scene.document.text().into(),
            overrides: scene.document.assignments().map(Into::into).collect(),
            command: crate::run::command_line(),
            remarks: given.remarks.clone(),
        }
    }
}

/// The choices by name.
fn chosen(params: &TrackParams, buoyancy: f64) -> Value {
    let table = params.table().iter().enumerate();
    let mut all: serde_json::Map<String, Value> = table
        .filter_map(|(index, choice)| {
            let value = match params.get(index)? {
                Chosen::Number(number) => json!(number),
                Chosen::Count(count) => json!(count),
                Chosen::Automatic => json!("auto"),
                Chosen::Flag(flag) => json!(flag),
                Chosen::Word(word) => json!(word),
            };
            Some((choice.name.to_owned(), value))
        })
        .collect();
    all.insert("buoyancy".into(), json!(buoyancy));
    if params.independent {
        // Pairs on their own begin at rest, whatever predicts others.
        all.insert("predict".into(), json!("none"));
    }
    Value::Object(all)
}
