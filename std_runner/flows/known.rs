//! A written result whose flow is known: what it is, and its arrays, read one step at a time.

use crate::exit::Failure;
use crate::keyframes::{Canvas, Earlier, Series, ShapeError, has_array, measured};
use crate::problem::Precision;
use crate::report::{ARCHIVE, CENTRED, Said};
use serde_json::Value;
use std::path::{Path, PathBuf};
use thurible_core::{Boundary, Named};

const KEY: &str = "result";

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
    /// Frames that were captured, or else densities, and the flow.
    earlier: Earlier,
    emission: Option<Series>,
}

impl Known {
    /// That of the result in `folder`.
    pub fn open(folder: &Path) -> Result<Self, Failure> {
        let said = Said::of(folder)?;
        if said.centred {
            return Err(refuse(folder, CENTRED));
        }
        let boundary = boundary(folder, &said.boundary, said.cells.len())?;
        let (archive, length, cells) = (folder.join(ARCHIVE), said.length, said.cells);
        let canvas = canvas(&cells, &boundary, length, 1);
        let earlier = Earlier::open(&archive, canvas).map_err(|error| unread(folder, &error))?;
        let earlier = earlier.until(said.simulated);
        let emission = has_array(&archive, "emission").then(|| Series::open(&archive, Some("emission"), KEY));
        Ok(Self {
            folder: folder.to_owned(),
            length,
            dt: said.dt,
            precision: if said.double {
                Precision::F64
            } else {
                Precision::F32
            },
            earlier,
            emission: emission.transpose().map_err(|error| unread(folder, &error))?,
            cells,
            boundary,
        })
    }

    /// Steps of the flow.
    pub fn steps(&self) -> usize {
        self.earlier.flows()
    }

    /// The cells that are there on a grid `scale` times as fine.
    pub fn canvas(&self, scale: usize) -> Canvas {
        canvas(&self.cells, &self.boundary, self.length, scale)
    }

    /// A component of the flow of a step.
    pub fn flow(&mut self, axis: usize, step: usize) -> Result<Vec<f64>, Failure> {
        let read = self.earlier.velocity(Some(step), axis);
        read.map_err(|error| unread(&self.folder, &error))
    }

    /// The density of a step, no less than 0 anywhere, if there is one.
    pub fn smoke(&mut self, step: usize) -> Result<Option<Vec<f64>>, Failure> {
        if step >= self.earlier.densities() {
            return Ok(None);
        }
        let read = self.earlier.frame(Some(step));
        let read = read.map_err(|error| unread(&self.folder, &error))?;
        Ok(Some(read.into_iter().map(|value| value.max(0.0)).collect()))
    }

    /// What emitters added after a step.
    pub fn emission(&mut self, step: usize) -> Result<Option<Vec<f64>>, Failure> {
        let read = self.emission.as_mut().map(|series| series.read(step));
        read.transpose().map_err(|error| unread(&self.folder, &error))
    }

    /// The solid cells on a grid `scale` times as fine, if there are any.
    pub fn solid(&self, scale: usize) -> Result<Option<Vec<bool>>, Failure> {
        let archive = self.folder.join(ARCHIVE);
        if !has_array(&archive, "solid") {
            return Ok(None);
        }
        let coarse = measured(KEY, &archive, Some("solid"));
        let coarse = coarse.map_err(|error| unread(&self.folder, &error))?.values;
        let fine: Vec<usize> = self.cells.iter().map(|count| count * scale).collect();
        let of = |index: usize| {
            let (mut rest, mut place, mut stride) = (index, 0, 1);
            for (fine, coarse) in fine.iter().zip(&self.cells) {
                place += rest % fine / scale * stride;
                rest /= fine;
                stride *= coarse;
            }
            coarse.get(place).is_some_and(|&solid| solid != 0.0)
        };
        Ok(Some((0..fine.iter().product()).map(of).collect()))
    }
}

/// The cells of a box `scale` times as fine as `cells`.
fn canvas(cells: &[usize], boundary: &[Boundary], length: f64, scale: usize) -> Canvas {
    Canvas {
        cells: cells.iter().map(|count| count * scale).collect(),
        length,
        periodic: boundary.iter().map(|&end| end == Boundary::Periodic).collect(),
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
    error.failure(format!("{}: {error}", folder.display()))
}
