//! What a run has to say about itself: `report.json` for programs, `report.html` for people.

mod chart;
mod charts;
mod document;
mod page;
mod record;
mod tables;
mod words;

use std::path::Path;

pub(crate) use chart::{Chart, Curve, Scale};
pub(crate) use charts::by_grid;
pub(crate) use document::{Block, Document, Shot, Table};
pub use record::{
    AdmmRecord, AdvectionRecord, DirectRecord, IterationRecord, KeyframeRecord, LedgerLine, MemoryRecord, ObjectiveRecord, RunRecord, SecondsRecord,
};

pub(crate) use tables::product;
pub(crate) use words::{bytes, number, seconds};

use crate::output::{Frames, Gallery, OutputError, create_folder, write_archive, write_bytes};

/// Writes a result folder: `result.npz`, `report.json`, `report.html`, and with `images` the frames and the animation.
///
/// Numbers are written first, so that they are there if pictures fail. Every file is whole or not there.
///
/// # Errors
/// A file that could not be written, by name.
pub fn write(folder: &Path, frames: &dyn Frames, record: &RunRecord, images: bool) -> Result<(), OutputError> {
    write_and_show(folder, frames, record, Parts { arrays: true, images }).map(drop)
}

/// Which of the large parts of a result folder are wanted.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Parts {
    /// `result.npz`.
    pub arrays: bool,
    /// The frames and the animation.
    pub images: bool,
}

/// As [`write`]; the answer is the pictures of the report.
pub(crate) fn write_and_show(folder: &Path, frames: &dyn Frames, record: &RunRecord, parts: Parts) -> Result<Gallery, OutputError> {
    create_folder(folder)?;
    if parts.arrays {
        write_archive(&folder.join("result.npz"), frames)?;
    }
    let path = folder.join("report.json");
    let json = serde_json::to_vec_pretty(record).map_err(OutputError::of(&path))?;
    write_bytes(&path, &json)?;
    let gallery = Gallery::draw(folder, frames, parts.images)?;
    let title = folder.file_name().map_or_else(|| "result".into(), |name| name.to_string_lossy());
    write_bytes(&folder.join("report.html"), page::page(&title, record, &gallery).as_bytes())?;
    Ok(gallery)
}
