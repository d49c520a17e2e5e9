//! `report.html` of a tracked capture: frames, flow as arrows and colours, error curves, re-advection beside the truth.

use super::errors::faces;
use super::record::{PairRecord, TrackRecord};
use super::wheel::{self, Plane};
use crate::keyframes::Series;
use crate::output::{Angles, Field, Over, OutputError, Picture, Shot, Smoke, arrow_side, write_bytes};
use crate::report::{Block, Chart, Curve, Document, Scale, Shot as Shown, Table, bytes, number, seconds};
use std::path::Path;
use thurible_core::{Boundary, Named, Status};

/// Pictures in a row, at most.
const SHOWN: usize = 6;
/// The longer side of a picture with arrows, in pixels.
const LONGEST: usize = 420;
const AXES: [&str; 3] = ["x", "y", "z"];

/// Writes the page of the result in `result` into `folder`.
pub(super) fn write(result: &Path, folder: &Path, record: &TrackRecord) -> Result<(), OutputError> {
    let mut album = Album::open(result, record)?;
    let name = result.file_name().map_or_else(|| "result".into(), |name| name.to_string_lossy());
    let mut blocks: Vec<Block> = record.remarks.iter().map(|remark| Block::Text(format!("Note: {remark}."))).collect();
    blocks.push(Block::Table(facts(record)));
    blocks.push(Block::Heading("Frames, and the first one carried by the flow".into()));
    album.frames(&mut blocks)?;
    blocks.push(Block::Heading("The flow".into()));
    album.flows(&mut blocks)?;
    blocks.push(Block::Heading("Pair by pair".into()));
    blocks.push(Block::Charts(charts(record)));
    blocks.push(Block::Heading("Memory".into()));
    blocks.push(Block::Table(ledger(record)));
    blocks.push(Block::Heading("The capture and the command".into()));
    blocks.push(Block::Code(record.scene.trim_end().to_owned()));
    blocks.push(Block::Code(record.command.clone()));
    let document = Document {
        title: name.into_owned(),
        lead: lead(record),
        blocks,
        pictures: false,
    };
    write_bytes(&folder.join("report.html"), document.html().as_bytes())
}

/// How it went, in a sentence.
fn lead(record: &TrackRecord) -> String {
    let how = match record.status {
        Status::Cancelled => "Interrupted; so far the flow",
        Status::NotFinite => "Stopped where it was no longer finite; before that the flow",
        _ => "The flow",
    };
    let method = record.track.get("method").and_then(serde_json::Value::as_str).unwrap_or_default();
    format!(
        "{how} behind {} frames, tracked by {method} in {} and {} of memory.",
        record.steps + 1,
        seconds(record.seconds),
        bytes(record.memory.planned_bytes)
    )
}

fn mean(history: &[PairRecord], of: impl Fn(&PairRecord) -> Option<f64>) -> Option<f64> {
    let values: Vec<f64> = history.iter().filter_map(of).collect();
    (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
}

fn facts(record: &TrackRecord) -> Table {
    let history = &record.history;
    let fastest = history.iter().map(|pair| pair.fastest).fold(0.0, f64::max);
    let cells: Vec<String> = record.cells.iter().map(ToString::to_string).collect();
    let ends: Vec<&str> = record.boundary.iter().map(|end| end.name()).collect();
    let kept = mean(history, |pair| Some(pair.misfit / pair.misfit_predicted.max(f64::MIN_POSITIVE)));
    let mut rows = vec![
        ("cells", cells.join(" x ")),
        ("axes end in", ends.join(", ")),
        ("precision", record.precision.to_owned()),
        ("largest velocity, cells a frame", number(fastest)),
        ("misfit left of that of the prediction, mean", number(kept.unwrap_or_default())),
        ("seconds a pair, mean", number(mean(history, |pair| Some(pair.seconds)).unwrap_or_default())),
    ];
    let known = [
        ("error, cells a frame (RMS), mean", mean(history, |pair| pair.velocity_rms_error)),
        ("error in parts of the true flow, mean", mean(history, |pair| pair.velocity_relative_error)),
        ("angle to the true flow, degrees, mean", mean(history, |pair| pair.angular_error)),
        ("re-advected density, error at the end", history.last().and_then(|pair| pair.readvection_error)),
    ];
    rows.extend(known.into_iter().filter_map(|(name, value)| Some((name, number(value?)))));
    if let Some(table) = record.track.as_object() {
        let chosen: Vec<String> = table.iter().map(|(name, value)| format!("{name} {value}")).collect();
        rows.push(("chosen", chosen.join(", ")));
    }
    Table {
        head: vec!["", ""],
        names: 1,
        ours: 2,
        rows: rows.into_iter().map(|(name, value)| vec![name.to_owned(), value]).collect(),
    }
}

fn ledger(record: &TrackRecord) -> Table {
    let line = |line: &crate::report::LedgerLine| {
        let indent = "\u{a0}\u{a0}".repeat(line.depth);
        vec![format!("{indent}{}", line.name), bytes(line.bytes)]
    };
    Table {
        head: vec!["buffer", "bytes"],
        names: 1,
        ours: 2,
        rows: record.memory.ledger.iter().map(line).collect(),
    }
}

fn charts(record: &TrackRecord) -> Vec<Chart> {
    let curve = |name: &str, colour: usize, of: &dyn Fn(&PairRecord) -> Option<f64>| {
        let points = record.history.iter().filter_map(|pair| Some((pair.frame as f64, of(pair)?)));
        Curve::new(name, colour, points.filter(|(_, value)| *value > 0.0).collect::<Vec<_>>().into_iter())
    };
    let chart = |title, note: &str, curves: Vec<Curve>| {
        let drawn: Vec<Curve> = curves.into_iter().filter(|curve| !curve.is_empty()).collect();
        (!drawn.is_empty()).then(|| Chart {
            title,
            note: note.into(),
            across: "frame",
            scale: Scale::Counts,
            curves: drawn,
        })
    };
    let all = [
        chart(
            "Error of the velocity",
            "in cells a frame, and in parts of the true flow",
            vec![
                curve("RMS", 1, &|pair| pair.velocity_rms_error),
                curve("relative", 2, &|pair| pair.velocity_relative_error),
            ],
        ),
        chart(
            "Angle to the true flow",
            "in degrees, weighted by the true speed",
            vec![curve("angle", 1, &|pair| pair.angular_error)],
        ),
        chart(
            "Re-advected density",
            "distance from the frame, in parts of it",
            vec![curve("re-advection", 1, &|pair| pair.readvection_error)],
        ),
        chart(
            "Misfit of the frames",
            "squared distance of the next frame, pulled back, from this one",
            vec![
                curve("by the prediction", 2, &|pair| Some(pair.misfit_predicted)),
                curve("by the flow", 1, &|pair| Some(pair.misfit)),
            ],
        ),
        chart(
            "Terms of the objective",
            "on the finest grid, at the result",
            vec![
                curve("data", 1, &|pair| Some(pair.data)),
                curve("smoothness", 2, &|pair| Some(pair.smoothness)),
                curve("kinetic", 3, &|pair| Some(pair.kinetic)),
            ],
        ),
        chart(
            "Work",
            "products by the operator on the finest grid, and seconds",
            vec![
                curve("products", 1, &|pair| pair.cg.first().map(|&count| count as f64)),
                curve("seconds", 2, &|pair| Some(pair.seconds)),
            ],
        ),
    ];
    all.into_iter().flatten().collect()
}

/// The arrays of a result, from which pictures are drawn: of a box its middle plane, x across and z up.
struct Album<'a> {
    record: &'a TrackRecord,
    captured: Series,
    density: Option<Series>,
    velocity: Vec<Series>,
    truth: Vec<Series>,
    /// The density that is drawn brightest.
    full: f32,
}

impl<'a> Album<'a> {
    fn open(result: &Path, record: &'a TrackRecord) -> Result<Self, OutputError> {
        let archive = result.join("result.npz");
        let unread = |error: crate::keyframes::ShapeError| {
            OutputError::unread(&archive)(std::io::Error::other(error.to_string()))
        };
        let open = |name: &str| Series::open(&archive, Some(name), "result");
        let flows = |name: &str| -> Result<Vec<Series>, crate::keyframes::ShapeError> {
            let axes = AXES.iter().take(record.cells.len());
            axes.map(|axis| open(&format!("{name}_{axis}"))).collect()
        };
        let mut captured = open("captured").map_err(unread)?;
        let mut full = 0.0f64;
        for index in picked(record.steps + 1) {
            full = captured.read(index).map_err(unread)?.into_iter().fold(full, f64::max);
        }
        Ok(Self {
            record,
            captured,
            density: open("density").ok(),
            velocity: flows("velocity").map_err(unread)?,
            truth: flows("truth").unwrap_or_default(),
            full: full as f32,
        })
    }

    /// Some frames, and below them the first one carried by the flow.
    fn frames(&mut self, blocks: &mut Vec<Block>) -> Result<(), OutputError> {
        let (cells, full) = (self.record.cells.clone(), self.full);
        let rows = [(Some(&mut self.captured), "frame"), (self.density.as_mut(), "carried to frame")];
        for (series, name) in rows {
            let Some(series) = series else { continue };
            let mut shots = Vec::new();
            for index in picked(self.record.steps + 1) {
                let values = series.read(index).unwrap_or_default();
                let values = values.into_iter().map(|value| value as f32).collect();
                let smoke = Smoke::new(&cells, values, full, None);
                shots.push(shown(format!("{name} {index}"), &smoke.photograph())?);
            }
            blocks.push(Block::Strip(shots));
        }
        Ok(())
    }

    /// Some flows: arrows over the frame, colours, and the true ones.
    fn flows(&mut self, blocks: &mut Vec<Block>) -> Result<(), OutputError> {
        let picked = picked(self.record.steps);
        let own: Vec<Plane> = picked.iter().map(|&index| plane(self.record, &mut self.velocity, index)).collect();
        let truth: Vec<Plane> = if self.truth.is_empty() {
            Vec::new()
        } else {
            picked.iter().map(|&index| plane(self.record, &mut self.truth, index)).collect()
        };
        let fastest = own.iter().chain(&truth).map(Plane::fastest).fold(0.0, f32::max);
        let mut arrows = Vec::new();
        for (&index, plane) in picked.iter().zip(&own) {
            arrows.push(shown(format!("flow from frame {index}"), &self.arrows(index, plane, fastest)?)?);
        }
        blocks.push(Block::Strip(arrows));
        for (planes, name) in [(&own, "flow from frame"), (&truth, "true flow from frame")] {
            let mut shots = Vec::new();
            for (&index, plane) in picked.iter().zip(planes) {
                shots.push(shown(format!("{name} {index}"), &plane.picture(fastest))?);
            }
            if !shots.is_empty() {
                blocks.push(Block::Strip(shots));
            }
        }
        let legend = format!("direction and speed; the rim is {} cells a frame", number(f64::from(fastest)));
        blocks.push(Block::Strip(vec![shown(legend, &wheel::wheel())?]));
        Ok(())
    }

    /// Arrows over the frame that they start from.
    fn arrows(&mut self, index: usize, plane: &Plane, fastest: f32) -> Result<Picture, OutputError> {
        let values = self.captured.read(index).unwrap_or_default();
        let smoke = Smoke::new(&plane.cells, slice(self.record, &values), self.full, None);
        let [nx, ny] = plane.cells;
        let pixels = (LONGEST / nx.max(ny)).max(2);
        let shot = Shot {
            width: nx * pixels,
            height: ny * pixels,
            angles: Angles::default(),
            gain: 1.0,
            detail: 0.0,
        };
        let mut film = smoke.expose(&shot);
        let field = Field {
            cells: plane.cells,
            values: plane.flow.clone(),
        };
        if fastest > 0.0 {
            let strongest = field.strongest(arrow_side(plane.cells, pixels as f32));
            let over = Over {
                streaks: None,
                arrows: (strongest > 0.0).then_some((field, strongest)),
            };
            smoke.draw_over(&mut film, &shot, &over);
        }
        Ok(film.develop())
    }
}

/// Some of `count` entries, first and last among them.
fn picked(count: usize) -> Vec<usize> {
    let shown = SHOWN.min(count);
    let last = count.saturating_sub(1);
    (0..shown).map(|index| (index * last).checked_div(shown - 1).unwrap_or(0)).collect()
}

fn shown(caption: String, picture: &Picture) -> Result<Shown, OutputError> {
    let png = picture.to_png().map_err(OutputError::of(Path::new("report.html")))?;
    Ok(Shown { caption, png })
}

/// Cells of the plane that is shown, and the index of cell (across, up) of it.
fn shape(record: &TrackRecord) -> ([usize; 2], impl Fn(usize, usize) -> usize + use<>) {
    let (cells, middle) = match *record.cells.as_slice() {
        [nx, ny, nz] => ([nx, nz], Some((nx, ny))),
        [nx, ny] => ([nx, ny], None),
        _ => ([1, 1], None),
    };
    let across = cells[0];
    let index = move |x: usize, up: usize| match middle {
        Some((nx, ny)) => (up * ny + ny / 2) * nx + x,
        None => up * across + x,
    };
    (cells, index)
}

/// The density of that plane.
fn slice(record: &TrackRecord, values: &[f64]) -> Vec<f32> {
    let ([nx, ny], index) = shape(record);
    let at = |cell: usize| values.get(index(cell % nx, cell / nx)).map_or(0.0, |&value| value as f32);
    (0..nx * ny).map(at).collect()
}

/// The flow in that plane at the centres of the cells, in cells a frame.
fn plane(record: &TrackRecord, velocity: &mut [Series], step: usize) -> Plane {
    let (cells, index) = shape(record);
    let longest = record.cells.iter().copied().max().unwrap_or(1) as f64;
    let unit = record.dt * longest / record.length;
    let mut flow = vec![[0.0; 2]; cells[0] * cells[1]];
    let last = record.cells.len() - 1;
    for (component, axis) in [0, last].into_iter().enumerate() {
        let Some(series) = velocity.get_mut(axis) else { continue };
        let values = series.read(step).unwrap_or_default();
        let periodic = record.boundary.get(axis) == Some(&Boundary::Periodic);
        for (cell, flow) in flow.iter_mut().enumerate() {
            let place = index(cell % cells[0], cell / cells[0]);
            let [low, high] = faces(&record.cells, (axis, periodic), place);
            let value = |face: usize| values.get(face).copied().unwrap_or_default();
            flow[component] = (0.5 * unit * (value(low) + value(high))) as f32;
        }
    }
    Plane { cells, flow }
}
