//! What the `report.json` of a result folder says of its arrays, and of the scene that it is of.

use crate::exit::Failure;
use serde_json::{Value, json};
use std::fs;
use std::path::Path;

/// What is said of a result where its flow is asked for at faces.
pub(crate) const CENTRED: &str =
    "has the flow of stable_fluids, which is that of cells, not of faces; give a result of another method";

/// The box of a result, its steps and its precision.
#[derive(Clone, Debug)]
pub(crate) struct Said {
    /// Cells along x, y (and z).
    pub cells: Vec<usize>,
    /// How each axis ends, as the report has it.
    pub boundary: Vec<Value>,
    pub length: f64,
    pub dt: f64,
    /// The last step, and the steps of the keyframes, where the report has them.
    pub steps: Option<usize>,
    /// Of a simulation that was stopped the steps that were simulated.
    pub simulated: Option<usize>,
    pub keyframes: Option<Vec<usize>>,
    /// The largest density of all steps, where the report has it.
    pub densest: Option<f64>,
    /// Whether its numbers have 64 bits.
    pub double: bool,
    /// Whether velocities are those of cells, and not of faces.
    pub centred: bool,
}

impl Said {
    /// That of the result in `folder`.
    ///
    /// # Errors
    /// A report that cannot be read, or is not ours.
    pub fn of(folder: &Path) -> Result<Self, Failure> {
        let path = folder.join("report.json");
        let text = fs::read_to_string(&path).map_err(|error| {
            let path = path.display();
            Failure::File(format!("cannot read {path}: {error}; name a result folder"))
        })?;
        let report: Value = serde_json::from_str(&text).unwrap_or_default();
        let foreign = |key: &str| {
            Failure::Input(format!(
                "{} has a report.json without a usable `{key}`; name a folder that thurible wrote",
                folder.display()
            ))
        };
        let list = |key: &str| report.get(key).and_then(Value::as_array);
        let count = |cell: &Value| cell.as_u64().and_then(|cell| usize::try_from(cell).ok());
        let cells: Option<Vec<usize>> = list("cells").and_then(|cells| cells.iter().map(count).collect());
        let real = |key: &str| {
            let number = report.get(key).and_then(Value::as_f64);
            number
                .filter(|&number| number > 0.0 && number.is_finite())
                .ok_or_else(|| foreign(key))
        };
        let step = |keyframe: &Value| keyframe.get("step").and_then(count);
        let word = |key: &str| report.get(key).and_then(Value::as_str);
        Ok(Self {
            cells: cells
                .filter(|cells| matches!(cells.len(), 2 | 3) && !cells.contains(&0))
                .ok_or_else(|| foreign("cells"))?,
            boundary: list("boundary").ok_or_else(|| foreign("boundary"))?.clone(),
            length: real("length")?,
            dt: real("dt")?,
            steps: report.get("steps").and_then(count),
            simulated: report.get("simulated_steps").and_then(count),
            keyframes: list("keyframes").map(|all| all.iter().filter_map(step).collect()),
            densest: report.get("density_max").and_then(Value::as_f64),
            double: word("precision") == Some("f64"),
            centred: word("velocity_location") == Some("center"),
        })
    }

    /// Whether `axis` is periodic.
    pub fn repeats(&self, axis: usize) -> bool {
        self.boundary.get(axis).is_some_and(|end| end == "periodic")
    }

    /// The side of a cell.
    pub fn side(&self) -> f64 {
        self.length / self.cells.iter().copied().max().unwrap_or(1) as f64
    }
}

/// Whether a report is that of a scene of this text, with all that was set, in this precision.
pub(crate) fn is_said_of<'a>(
    report: &Value,
    (text, set): (&str, impl Iterator<Item = &'a str>),
    precision: &str,
) -> bool {
    report["scene"] == text
        && report["overrides"] == json!(set.collect::<Vec<_>>())
        && report["precision"] == precision
}
