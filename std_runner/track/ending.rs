//! What is shown while a capture is tracked, and what is written when it is over.

use super::page;
use super::plan::Planned;
use super::record::{Ended, PairRecord, TrackRecord};
use super::scene::CaptureScene;
use crate::console;
use crate::destination::Destination;
use crate::exit::{Failure, INTERRUPTED, code_of_result};
use crate::output::Store;
use crate::output::{OutputError, Precision, write_whole};
use crate::problem;
use crate::progress::{Display, Mode, in_words};
use serde_json::json;
use std::path::Path;
use thurible_core::{Named, Status};

/// Shows the pair that is done, and the time that is left.
pub(super) fn show(display: &Display, history: &[PairRecord], all: usize) {
    let Some(record) = history.last() else { return };
    if display.mode() == Mode::Json {
        let fields = serde_json::to_value(record).unwrap_or_default();
        return display.event("pair", fields);
    }
    let done = history.len();
    let seconds: f64 = history.iter().map(|record| record.seconds).sum();
    let left = (all - done) as f64 * seconds / done as f64;
    let kept = record.misfit / record.misfit_predicted.max(f64::MIN_POSITIVE);
    let mut text = format!(
        "{} left, up to {:.2} cells a frame, {:.0} % of the misfit left",
        in_words(left),
        record.fastest,
        100.0 * kept
    );
    if let Some(error) = record.velocity_relative_error {
        text += &format!(", error {error:.3}");
    } else if let Some(error) = record.velocity_rms_error {
        text += &format!(", {error:.3} cells a frame where the truth rests");
    }
    display.piece(done, &text);
}

/// Writes the result folder.
pub(super) fn finish(
    (scene, planned, display): (&CaptureScene, &Planned, &Display),
    (destination, store): (&mut Destination, &mut Store),
    ended: Ended,
) -> Result<u8, Failure> {
    let (status, pairs) = (ended.status, ended.history.len());
    if pairs == 0 {
        return match status {
            Status::Cancelled => {
                display.note("thurible: interrupted before the first pair was done, so there is no result");
                Ok(INTERRUPTED)
            }
            _ => Err(not_finite(0)),
        };
    }
    store.flush()?;
    if pairs < 2 {
        // A force leads from one pair to another.
        store.leave_out("force_");
    }
    let precision = match planned.precision {
        problem::Precision::F32 => Precision::F32,
        problem::Precision::F64 => Precision::F64,
    };
    let record = TrackRecord::new(scene, planned, ended);
    destination.fill(|folder| {
        let count = |name: &str| match name {
            "captured" | "density" => pairs + 1,
            name if name.starts_with("force_") => pairs.saturating_sub(1),
            _ => pairs,
        };
        store.pack(&folder.join("result.npz"), precision, count)?;
        write_report(folder, &record)
    })?;
    let result = destination.folder().to_path_buf();
    destination.add(|folder| page::write(&result, folder, &record))?;
    let diverted = destination.diverted().map(str::to_owned);
    announce_end(display, &record, destination);
    if let Some(why) = &diverted {
        console::error(&format!("thurible: {why}"));
    }
    if status == Status::NotFinite && diverted.is_none() {
        console::error(&format!("thurible: {}", not_finite(pairs)));
    }
    Ok(code_of_result(status, diverted.is_some()))
}

fn not_finite(pairs: usize) -> Failure {
    Failure::NotFinite(format!(
        "the flow between frames {pairs} and {} became too fast or not finite; raise track.beta or track.alpha, track these frames with track.independent = true, or, where it was the first frame that the flow could not carry, set track.readvect = false",
        pairs + 1
    ))
}

fn write_report(folder: &Path, record: &TrackRecord) -> Result<(), OutputError> {
    let path = folder.join("report.json");
    write_whole(&path, |file| {
        serde_json::to_writer_pretty(file, record).map_err(OutputError::of(&path))
    })
}

fn announce_end(display: &Display, record: &TrackRecord, destination: &Destination) {
    let folder = destination.shown();
    display.event(
        "result",
        json!({ "status": record.status.name(), "pairs": record.steps, "seconds": record.seconds,
                "folder": folder.display().to_string() }),
    );
    if display.mode() != Mode::Human {
        return;
    }
    let how = if record.status == Status::Cancelled {
        "interrupted after"
    } else {
        "tracked"
    };
    console::error(&format!(
        "{how} {} pairs in {}; the result is in {}",
        record.steps,
        in_words(record.seconds),
        folder.display()
    ));
}
