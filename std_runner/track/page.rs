//! `report.html` of a tracked capture: frames, flow as arrows and colours, error curves, re-advection beside the truth.

use super::album::Album;
use super::record::{PairRecord, TrackRecord};
use crate::output::{OutputError, write_bytes};
use crate::report::{Block, Chart, Curve, Document, Table, bytes, number, seconds};
use std::path::Path;
use thurible_core::{Named, Status};

/// Writes the page of the result in `result` into `folder`.
pub(super) fn write(result: &Path, folder: &Path, record: &TrackRecord) -> Result<(), OutputError> {
    let mut album = Album::open(result, record)?;
    let name = result
        .file_name()
        .map_or_else(|| "result".into(), |name| name.to_string_lossy());
    let mut blocks: Vec<Block> = record
        .remarks
        .iter()
        .map(|remark| Block::Text(format!("Note: {remark}.")))
        .collect();
    blocks.push(Block::Table(facts(record)));
    blocks.push(Block::Heading(
        "Frames, and the first one carried by the flow".into(),
    ));
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
    let method = record
        .track
        .get("method")
        .and_then(serde_json::Value::as_str)
        .unwrap_or_default();
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
    let kept = mean(history, |pair| {
        Some(pair.misfit / pair.misfit_predicted.max(f64::MIN_POSITIVE))
    });
    let mut rows = vec![
        ("cells", cells.join(" x ")),
        ("axes end in", ends.join(", ")),
        ("precision", record.precision.to_owned()),
        ("largest velocity, cells a frame", number(fastest)),
        (
            "misfit left of that of the prediction, mean",
            number(kept.unwrap_or_default()),
        ),
        (
            "seconds a pair, mean",
            number(mean(history, |pair| Some(pair.seconds)).unwrap_or_default()),
        ),
    ];
    let known = [
        (
            "error, cells a frame (RMS), mean",
            mean(history, |pair| pair.velocity_rms_error),
        ),
        (
            "error in parts of the true flow, mean",
            mean(history, |pair| pair.velocity_relative_error),
        ),
        (
            "angle to the true flow, degrees, mean",
            // Without the pairs whose truth rests.
            mean(history, |pair| {
                pair.velocity_relative_error.and(pair.angular_error)
            }),
        ),
        (
            "re-advected density, error at the end",
            history.last().and_then(|pair| pair.readvection_error),
        ),
    ];
    rows.extend(
        known
            .into_iter()
            .filter_map(|(name, value)| Some((name, number(value?)))),
    );
    if let Some(table) = record.track.as_object() {
        let chosen: Vec<String> = table
            .iter()
            .map(|(name, value)| format!("{name} {value}"))
            .collect();
        rows.push(("chosen", chosen.join(", ")));
    }
    Table::of_facts(rows)
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
        let points = record.history.iter().map(|pair| (pair.frame as f64, of(pair)));
        Curve::above_zero(name, colour, points)
    };
    let chart = |title, note: &str, curves: Vec<Curve>| Chart::of_counts(title, note, "frame", curves);
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
