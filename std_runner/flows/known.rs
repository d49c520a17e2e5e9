//! A written result whose flow is known: what it is, and its arrays, read one step at a time.

use crate::exit::Failure;
use crate::keyframes::{Canvas, Series, ShapeError, resampled};
use crate::problem::Precision;
use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};
use thurible_core::{Boundary, Named};

const AXES: [&str; 3] = ["x", "y", "z"];

/// A result folder with a flow.
pub(super) struct Known {
    /// The folder.
    pub folder: PathBuf,
    /// Cells along x, y (and z).
    pub cells: Vec<usize>,
    pub boundary: Vec<Boundary>,
    pub length: f64,
    pub dt: f64,
    pub precision: Precision,
    /// Steps of the flow.
    pub steps: usize,
    /// The frames that were captured, or else the densities.
    pub density: Series,
    velocity: Vec<Series>,
    emission: Option<Series>,
    solid: Option<Series>,
}

impl Known {
    /// That of the result in `folder`.
    pub fn open(folder: &Path) -> Result<Self, Failure> {
        let path = folder.join("report.json");
        let text = fs::read_to_string(&path).map_err(|error| {
            let path = path.display();
            Failure::File(format!("cannot read {path}: {error}; name a result folder"))
        })?;
        let report: Value = serde_json::from_str(&text).unwrap_or_default();
        let foreign = |key: &str| {
            refuse(
                folder,
                &format!("has a report.json without a usable `{key}`; name a folder that thurible wrote"),
            )
        };
        let cells: Option<Vec<usize>> = report.get("cells").and_then(Value::as_array).and_then(|cells| {
            let count = |cell: &Value| cell.as_u64().and_then(|cell| usize::try_from(cell).ok());
            cells.iter().map(count).collect()
        });
        let cells = cells
            .filter(|cells| matches!(cells.len(), 2 | 3))
            .ok_or_else(|| foreign("cells"))?;
        let ends = report
            .get("boundary")
            .and_then(Value::as_array)
            .ok_or_else(|| foreign("boundary"))?;
        let real = |key: &str| {
            let number = report.get(key).and_then(Value::as_f64);
            number.filter(|&number| number > 0.0).ok_or_else(|| foreign(key))
        };
        let archive = folder.join("result.npz");
        let open =
            |name: &str| Series::open(&archive, Some(name), "result").map_err(|error| unread(folder, &error));
        let velocity: Vec<Series> = AXES
            .iter()
            .take(cells.len())
            .map(|axis| open(&format!("velocity_{axis}")))
            .collect::<Result<_, _>>()?;
        let has = |name: &str| crate::keyframes::has_array(&archive, name);
        let optional = |name: &str| has(name).then(|| open(name)).transpose();
        Ok(Self {
            folder: folder.to_owned(),
            boundary: boundary(folder, ends, cells.len())?,
            length: real("length")?,
            dt: real("dt")?,
            precision: match report.get("precision").and_then(Value::as_str) {
                Some("f64") => Precision::F64,
                _ => Precision::F32,
            },
            steps: velocity.iter().map(Series::count).min().unwrap_or(0),
            density: open(if has("captured") { "captured" } else { "density" })?,
            velocity,
            emission: optional("emission")?,
            solid: optional("solid")?,
            cells,
        })
    }

    /// The cells that are there on a grid `scale` times as fine.
    pub fn canvas(&self, scale: usize) -> Canvas {
        Canvas {
            cells: self.cells.iter().map(|count| count * scale).collect(),
            length: self.length,
            periodic: self
                .boundary
                .iter()
                .map(|&end| end == Boundary::Periodic)
                .collect(),
        }
    }

    /// A component of the flow of a step.
    pub fn flow(&mut self, axis: usize, step: usize) -> Result<Vec<f64>, Failure> {
        let read = self.velocity.get_mut(axis).map(|series| series.read(step));
        read.unwrap_or_else(|| Ok(Vec::new()))
            .map_err(|error| unread(&self.folder, &error))
    }

    /// The density of a step, no less than 0 anywhere.
    pub fn smoke(&mut self, step: usize) -> Result<Vec<f64>, Failure> {
        let read = self
            .density
            .read(step)
            .map_err(|error| unread(&self.folder, &error))?;
        if let Some(place) = read.iter().position(|value| !value.is_finite()) {
            let why =
                format!("has a density of step {step} that is not finite at cell {place}; make it again");
            return Err(refuse(&self.folder, &why));
        }
        Ok(read.into_iter().map(|value| value.max(0.0)).collect())
    }

    /// A density on cells `scale` times as fine, linear between the cells.
    pub fn finer(&self, smoke: &[f64], scale: usize) -> Vec<f64> {
        resampled(smoke.to_vec(), &self.cells, &self.canvas(scale))
    }

    /// What emitters added after a step.
    pub fn emission(&mut self, step: usize) -> Result<Option<Vec<f64>>, Failure> {
        let read = self.emission.as_mut().map(|series| series.read(step));
        read.transpose().map_err(|error| unread(&self.folder, &error))
    }

    /// Whether emitters added smoke.
    pub fn emits(&self) -> bool {
        self.emission.is_some()
    }

    /// The solid cells on a grid `scale` times as fine, if there are any.
    pub fn solid(&mut self, scale: usize) -> Result<Option<Vec<bool>>, Failure> {
        let Some(series) = &mut self.solid else {
            return Ok(None);
        };
        // An array of cells is a series of planes.
        let planes = (0..series.count()).map(|plane| series.read(plane));
        let read: Result<Vec<Vec<f64>>, ShapeError> = planes.collect();
        let coarse = read.map_err(|error| unread(&self.folder, &error))?.concat();
        let n: Vec<usize> = self.cells.clone();
        let fine: Vec<usize> = n.iter().map(|count| count * scale).collect();
        let of = |index: usize| {
            let (mut rest, mut place, mut stride) = (index, 0, 1);
            for (fine, coarse) in fine.iter().zip(&n) {
                place += rest % fine / scale * stride;
                rest /= fine;
                stride *= coarse;
            }
            coarse.get(place).is_some_and(|&solid| solid != 0.0)
        };
        Ok(Some((0..fine.iter().product()).map(of).collect()))
    }
}

/// How the axes end, by the words of a report.
fn boundary(folder: &Path, ends: &[Value], axes: usize) -> Result<Vec<Boundary>, Failure> {
    let end = |end: &Value| end.as_str().and_then(|word| Boundary::from_name(word).ok());
    let ends: Option<Vec<Boundary>> = ends.iter().map(end).collect();
    let closed = |ends: &Vec<Boundary>| ends.len() == axes && !ends.iter().any(|end| end.is_open());
    ends.filter(closed).ok_or_else(|| {
        refuse(folder, "has open sides, through which its flow cannot be taken further; give a result between walls or on rings")
    })
}

/// A refusal of a result folder.
pub(super) fn refuse(folder: &Path, why: &str) -> Failure {
    Failure::Input(format!("{} {why}", folder.display()))
}

fn unread(folder: &Path, error: &ShapeError) -> Failure {
    let sentence = format!("{}: {error}", folder.display());
    if error.is_unreadable() {
        Failure::File(sentence)
    } else {
        Failure::Input(sentence)
    }
}
