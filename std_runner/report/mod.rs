//! What a run has to say about itself: `report.json` for programs, `report.html` for people.

mod chart;
mod charts;
mod page;
mod record;
mod tables;
mod words;

use std::path::Path;

pub use record::{
    AdmmRecord, AdvectionRecord, DirectRecord, IterationRecord, KeyframeRecord, LedgerLine, MemoryRecord, ObjectiveRecord, RunRecord, SecondsRecord,
};

use crate::output::{Frames, Gallery, OutputError, create_folder, write_archive, write_bytes};

/// Writes a result folder: `result.npz`, `report.json`, `report.html`, and with `images` the frames and the animation.
///
/// Numbers are written first, so that they are there if pictures fail. Every file is whole or not there.
///
/// # Errors
/// A file that could not be written, by name.
pub fn write(folder: &Path, frames: &dyn Frames, record: &RunRecord, images: bool) -> Result<(), OutputError> {
    create_folder(folder)?;
    write_archive(&folder.join("result.npz"), frames)?;
    let path = folder.join("report.json");
    let json = serde_json::to_vec_pretty(record).map_err(OutputError::of(&path))?;
    write_bytes(&path, &json)?;
    let gallery = Gallery::draw(folder, frames, images)?;
    let title = folder.file_name().map_or_else(|| "result".into(), |name| name.to_string_lossy());
    write_bytes(&folder.join("report.html"), page::page(&title, record, &gallery).as_bytes())
}
