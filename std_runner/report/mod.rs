//! What a run has to say about itself: `report.json` for programs, `report.html` for people.

mod axes;
mod chart;
mod charts;
mod document;
mod found;
mod iteration;
mod page;
mod record;
mod said;
mod tables;
mod templates;
mod words;

use std::path::{Path, PathBuf};

pub use axes::Scale;
pub use chart::{Chart, Curve};
pub use document::Table;
pub use iteration::{Facts, IterationRecord, ObjectiveRecord, WindowRecord};
pub use record::{
    AdvectionRecord, FluidsRecord, FrameRecord, KeyframeRecord, LedgerLine, MemoryRecord, RunRecord,
    SecondsRecord, SolvedBy,
};

pub(crate) use charts::{by_grid, charts};
pub(crate) use document::{Block, Document, Shot, evenly};
pub use found::TemplateRecord;
pub(crate) use iteration::{by_name, cells};
pub(crate) use page::shell;
pub(crate) use record::{by_side, end_in_words};

pub(crate) use found::{record as template_record, templates};
pub(crate) use said::{CENTRED, Said, is_said_of};
pub(crate) use tables::{product, smoothness};
pub(crate) use templates::lines as template_lines;
pub(crate) use words::{bytes, count, escape, number, seconds};

use crate::output::{
    ANIMATION, Densities, Frames, Gallery, OutputError, Pictured, create_folder, frame, write_archive,
    write_bytes, write_whole,
};

/// The arrays of a result.
pub(crate) const ARCHIVE: &str = "result.npz";
/// What is said of it.
pub(crate) const REPORT: &str = "report.json";
/// The same for people.
const PAGE: &str = "report.html";

/// The files of a result with densities 0 ..= `steps`, with `images` those of its pictures too, relative to its folder.
pub(crate) fn files(steps: usize, images: bool) -> Vec<PathBuf> {
    let mut files: Vec<PathBuf> = [ARCHIVE, REPORT, PAGE].map(PathBuf::from).to_vec();
    if images {
        files.push(ANIMATION.into());
        files.extend((0..=steps).map(frame));
    }
    files
}

/// Writes the data of a result, `result.npz` and `report.json`, and a page without pictures into `folder`, from where they go to `result`. A
/// file is written completely or not at all.
///
/// # Errors
/// A file that could not be written, by name.
pub fn write_numbers(
    folder: &Path,
    result: &Path,
    frames: &mut dyn Frames,
    record: &RunRecord,
) -> Result<(), OutputError> {
    create_folder(folder)?;
    write_archive(&folder.join(ARCHIVE), frames)?;
    write_words(folder, result, record)
}

/// Writes `report.json` and a page without pictures into `folder`, from where they go to `result`.
pub(crate) fn write_words(folder: &Path, result: &Path, record: &RunRecord) -> Result<(), OutputError> {
    let path = folder.join(REPORT);
    write_whole(&path, |file| {
        serde_json::to_writer_pretty(file, record).map_err(OutputError::of(&path))
    })?;
    write_page(folder, result, record, &Gallery::default())
}

/// Writes the page of `result` into `folder`.
fn write_page(
    folder: &Path,
    result: &Path,
    record: &RunRecord,
    gallery: &Gallery,
) -> Result<(), OutputError> {
    let name = result.file_name().map(|name| name.to_string_lossy());
    let page = page::page(name.as_deref().unwrap_or("result"), record, gallery);
    write_bytes(&folder.join(PAGE), page.as_bytes())
}

/// Writes `report.html`, and with `images` the frames and the animation, into `folder`, all drawn from the arrays in
/// `result`, which may be the same folder.
///
/// Returns false if there is no memory for pictures; then the page has none.
///
/// # Errors
/// A file that could not be read or written, by name.
pub fn write_pictures(
    result: &Path,
    folder: &Path,
    record: &RunRecord,
    images: bool,
) -> Result<bool, OutputError> {
    draw(result, folder, record, images).map(|gallery| gallery.is_some())
}

/// As [`write_pictures`]; returns the pictures of the page, or `None` if there is no memory for them.
pub(crate) fn draw(
    result: &Path,
    folder: &Path,
    record: &RunRecord,
    images: bool,
) -> Result<Option<Gallery>, OutputError> {
    create_folder(folder)?;
    let densities = Densities::open(
        &result.join(ARCHIVE),
        record.cells.clone(),
        record.steps,
        pictured(record),
        Some(record.density_max),
    )?;
    let gallery = Gallery::has_room(&densities, images)
        .then(|| Gallery::draw(folder, densities, images))
        .transpose()?;
    write_page(
        folder,
        result,
        record,
        gallery.as_ref().unwrap_or(&Gallery::default()),
    )?;
    Ok(gallery)
}

/// Each keyframe, to be shown where it is missed most.
fn pictured(record: &RunRecord) -> Vec<Pictured> {
    let targets = record.keyframes.iter().map(|keyframe| keyframe.step);
    let mut targets = targets.enumerate();
    let pictured = |worst: &KeyframeRecord| {
        let (target, step) = targets.find(|(_, step)| *step == worst.step)?;
        Some(Pictured {
            stay: worst.stay,
            step,
            target,
        })
    };
    record.worst_of_each().filter_map(pictured).collect()
}
