//! What is said of a flow that was taken further: `report.json` and `report.html`.

use crate::keyframes::Series;
use crate::output::{OutputError, Smoke, write_bytes};
use crate::report::{
    Block, Chart, Curve, Document, Shot, Table, by_name, by_side, bytes, evenly, number, seconds,
};
use serde::Serialize;
use std::path::Path;
use thurible_core::{Boundary, Named, Scheme, Status};

/// Pictures in a row, at most.
const SHOWN: usize = 8;

/// Everything that a program needs to know of the result.
#[derive(Clone, Debug, Serialize)]
pub(super) struct Record {
    pub format: u32,
    pub kind: &'static str,
    pub cells: Vec<usize>,
    #[serde(serialize_with = "by_side")]
    pub boundary: Vec<Boundary>,
    pub length: f64,
    pub dt: f64,
    pub steps: usize,
    /// The step of the earlier result that it begins with.
    pub from: usize,
    pub solid: bool,
    /// Strength and seed of turbulence that was added.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub turbulence: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub seed: Option<u64>,
    /// How dear the vorticity of the change was, if it had a price.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub smoothness: Option<f64>,
    #[serde(serialize_with = "by_name")]
    pub advection: Scheme,
    pub precision: &'static str,
    pub threads: usize,
    pub version: &'static str,
    #[serde(serialize_with = "by_name")]
    pub status: Status,
    pub seconds: f64,
    pub planned_bytes: usize,
    pub used_bytes: usize,
    /// What the user should know of it.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub remarks: Vec<String>,
    pub history: Vec<StepRecord>,
    /// None: other programs of the project look for them.
    pub keyframes: [(); 0],
    pub command: String,
}

/// What is said of a step.
#[derive(Clone, Debug, Serialize)]
pub(super) struct StepRecord {
    pub step: usize,
    /// The step of the earlier result that it stands beside.
    pub frame: usize,
    /// That it took.
    pub seconds: f64,
    /// How far its density is from the earlier result's, in parts of that.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub relative_l2: Option<f64>,
    /// By what part of itself the flow changed: everywhere, and where there is smoke.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub changed: Option<[f64; 2]>,
    /// Iterations in which the flow gave way, smoothly.
    #[serde(skip_serializing_if = "is_none")]
    pub iterations: usize,
    /// The kinetic energy of the finer flow without the turbulence and with it, 1/2 the mean of |v|^2.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub energy: Option<[f64; 2]>,
}

/// Whether there were none.
fn is_none(count: &usize) -> bool {
    *count == 0
}

/// Writes the page of the result in `folder`.
pub(super) fn write(folder: &Path, record: &Record) -> Result<(), OutputError> {
    let document = Document {
        title: record.kind.to_owned(),
        lead: format!(
            "{} steps of {} cells in {} and {} of memory, whatever the number of steps.",
            record.steps,
            crate::plan::size_in_words(&record.cells),
            seconds(record.seconds),
            bytes(record.planned_bytes)
        ),
        blocks: vec![
            Block::Strip(strip(folder, record)?),
            Block::Table(facts(record)),
            Block::Charts(charts(record)),
            Block::Heading("The command".into()),
            Block::Code(record.command.clone()),
        ],
        pictures: false,
    };
    write_bytes(&folder.join("report.html"), document.html().as_bytes())
}

/// Some steps, first and last among them.
fn strip(folder: &Path, record: &Record) -> Result<Vec<Shot>, OutputError> {
    let archive = folder.join("result.npz");
    let mut density = Series::open(&archive, Some("density"), "result").map_err(OutputError::unusable)?;
    let picked: Vec<usize> = evenly(record.steps + 1, SHOWN).collect();
    let mut full = 0.0f64;
    for &step in &picked {
        full = density
            .read(step)
            .map_err(OutputError::unusable)?
            .into_iter()
            .fold(full, f64::max);
    }
    picked
        .into_iter()
        .map(|step| {
            let values = density.read(step).map_err(OutputError::unusable)?;
            let values = values.into_iter().map(|value| value as f32).collect();
            let picture = Smoke::new(&record.cells, values, full as f32, None).photograph();
            let png = picture.to_png().map_err(OutputError::of(&archive))?;
            let caption = format!("step {}", record.from + step);
            Ok(Shot { caption, png })
        })
        .collect()
}

fn facts(record: &Record) -> Table {
    let last = record.history.last();
    let mean = |of: fn(&[f64; 2]) -> f64| {
        let all: Vec<f64> = record
            .history
            .iter()
            .filter_map(|step| step.changed.as_ref().map(of))
            .collect();
        (!all.is_empty()).then(|| number(all.iter().sum::<f64>() / all.len() as f64))
    };
    let rows = [
        ("density carried by", Some(record.advection.name().to_owned())),
        (
            "from the earlier result at the end, in parts of it",
            last.and_then(|step| step.relative_l2).map(number),
        ),
        (
            "change of the flow, in parts of it, mean of all steps",
            mean(|changed| changed[0]),
        ),
        ("the same where there is smoke", mean(|changed| changed[1])),
        (
            "price of the change's vorticity, alpha",
            record.smoothness.map(number),
        ),
        (
            "turbulence, 1 as the spectrum goes on",
            record.turbulence.map(number),
        ),
        ("its seed", record.seed.map(|seed| seed.to_string())),
        (
            "kinetic energy that it adds, in parts of the flow's, mean of all steps",
            added(&record.history),
        ),
    ];
    Table::of_facts(rows.into_iter().filter_map(|(name, value)| Some((name, value?))))
}

/// By what part of itself turbulence raised the kinetic energy, in the mean of all steps.
fn added(history: &[StepRecord]) -> Option<String> {
    let sums = history.iter().filter_map(|step| step.energy);
    let [before, after] = sums.fold([0.0; 2], |sum, energy| [sum[0] + energy[0], sum[1] + energy[1]]);
    (before > 0.0).then(|| number(after / before - 1.0))
}

fn charts(record: &Record) -> Vec<Chart> {
    let curve = |name: &str, colour: usize, of: &dyn Fn(&StepRecord) -> Option<f64>| {
        let points = record.history.iter().map(|step| (step.frame as f64, of(step)));
        Curve::above_zero(name, colour, points)
    };
    let chart = |title, note: &str, curves: Vec<Curve>| Chart::of_counts(title, note, "step", curves);
    let all = [
        chart(
            "Density beside the earlier result's",
            "distance, in parts of it",
            vec![curve("apart", 1, &|step| step.relative_l2)],
        ),
        chart(
            "Kinetic energy",
            "1/2 the mean of |v|^2",
            vec![
                curve("flow on finer cells", 2, &|step| {
                    step.energy.map(|energy| energy[0])
                }),
                curve("with turbulence", 1, &|step| step.energy.map(|energy| energy[1])),
            ],
        ),
        chart(
            "Change of the flow",
            "in parts of it",
            vec![
                curve("everywhere", 2, &|step| step.changed.map(|changed| changed[0])),
                curve("where there is smoke", 1, &|step| {
                    step.changed.map(|changed| changed[1])
                }),
            ],
        ),
    ];
    all.into_iter().flatten().collect()
}
