//! Which files the frames are in, and whether one is missing.

use super::scene::{CaptureScene, ENDS};
use crate::exit::Failure;
use crate::keyframes::{Frames, Series, ShapeError, ends_with, has_array, is_picture};
use crate::report::{ARCHIVE, Said};
use crate::scene::{Document, Numbered, files_of};
use std::path::{Path, PathBuf};
use thurible_core::{Boundary, Named};

/// The key that names the frames.
pub(super) const KEY: &str = "capture.files";
/// The key that names true velocities.
pub(super) const TRUTH: &str = "capture.truth";
/// Endings of files that frames come in.
const ENDINGS: [&str; 10] = [
    "npy", "npz", "vdb", "png", "jpg", "jpeg", "tif", "tiff", "webp", "exr",
];

/// What a result folder says of the frames in it.
#[derive(Clone, Debug, Default)]
pub(super) struct Known {
    pub boundary: Option<Vec<Boundary>>,
    pub length: Option<f64>,
    pub dt: Option<f64>,
    /// What the flow that is tracked cannot know of it.
    pub remarks: Vec<String>,
}

/// Frames, and what is known beside them.
pub(super) struct Found {
    pub frames: Frames,
    /// An archive that holds true velocities.
    pub truth: Option<PathBuf>,
    /// An archive that holds what was made between frames.
    pub emission: Option<PathBuf>,
    pub known: Known,
}

/// A refusal of what is in a file, with the place of the key `key` that names it.
pub(super) fn refused(document: &Document, key: &str, error: &ShapeError) -> Failure {
    let sentence = format!("{}: {error}", document.place(key));
    error.failure(sentence)
}

/// Finds the frames of a capture.
pub(super) fn find(scene: &CaptureScene) -> Result<Found, Failure> {
    let document = &scene.document;
    let path = document.folder().join(&scene.files);
    let refuse = |error: ShapeError| refused(document, KEY, &error);
    let result = path.join(ARCHIVE);
    let archive = if path.is_dir() && result.is_file() {
        result
    } else {
        path.clone()
    };
    if archive.is_file() {
        refuse_one_frame(document, &archive)?;
        let name = scene.name.as_deref();
        let of_track = name.is_none() && has_array(&archive, "captured");
        let name = if of_track { Some("captured") } else { name };
        let frames = Frames::of_array(&archive, name, KEY).map_err(refuse)?;
        let of_result = if of_track { "truth_x" } else { "velocity_x" };
        let said = archive.parent().and_then(|folder| Said::of(folder).ok());
        // Velocities of cells are no truth for those of faces.
        let centred = !of_track && said.as_ref().is_some_and(|said| said.centred);
        let truth = (has_array(&archive, of_result) && !centred).then(|| archive.clone());
        let emission = has_array(&archive, "emission").then(|| archive.clone());
        let mut known = known(&archive);
        known
            .remarks
            .extend(unheard(scene, core::slice::from_ref(&archive)));
        if centred {
            let why = "the result has the flow of stable_fluids, which is that of cells: what is found is not compared with it";
            known.remarks.push(why.into());
        }
        return Ok(Found {
            frames,
            truth,
            emission,
            known,
        });
    }
    let files = if path.is_dir() {
        in_folder(document, &path)?
    } else if scene.files.contains('*') {
        files_of(document, KEY, &scene.files)?
    } else {
        let why = format!("names {}, which is not there; correct it", path.display());
        return Err(Failure::File(format!("{}: `{KEY}` {why}", document.place(KEY))));
    };
    // Frames that are not tracked may be missing.
    let count = files.paths.len();
    let end = scene.last.map_or(count, |last| count.min(last + 1));
    refuse_disorder(document, &files, scene.first, end)?;
    let remarks = unheard(scene, &files.paths);
    let frames =
        Frames::of_files(files.paths, scene.name.as_deref(), scene.ink.as_deref(), KEY).map_err(refuse)?;
    Ok(Found {
        frames,
        truth: None,
        emission: None,
        known: Known {
            remarks,
            ..Known::default()
        },
    })
}

/// Says which keys are given that none of these files hears.
fn unheard(scene: &CaptureScene, files: &[PathBuf]) -> Vec<String> {
    let named = |path: &PathBuf| ends_with(path, "npz") || ends_with(path, "vdb");
    let keys = [
        (
            "ink",
            scene.ink.is_some(),
            "pictures",
            files.iter().any(|path| is_picture(path)),
        ),
        (
            "name",
            scene.name.is_some(),
            "archives and volumes",
            files.iter().any(named),
        ),
    ];
    let passed_over = keys.into_iter().filter(|(_, given, _, heard)| *given && !heard);
    passed_over
        .map(|(key, _, of, _)| {
            format!("`capture.{key}` is for {of} alone, and does nothing with these frames")
        })
        .collect()
}

/// Refuses a file that is one frame, whatever is in it.
fn refuse_one_frame(document: &Document, path: &Path) -> Result<(), Failure> {
    if is_picture(path) || ends_with(path, "vdb") {
        let ending = path.extension().unwrap_or_default().to_string_lossy();
        let why = format!(
            "names {}, which is one frame, and a flow needs two; write a pattern of several, as in \"smoke_*.{ending}\"",
            path.display()
        );
        return Err(document.refuse(KEY, why));
    }
    Ok(())
}

/// What the report beside an archive says.
fn known(archive: &Path) -> Known {
    let text = std::fs::read_to_string(archive.with_file_name("report.json")).unwrap_or_default();
    let report: serde_json::Value = serde_json::from_str(&text).unwrap_or_default();
    let number = |key: &str| report.get(key).and_then(serde_json::Value::as_f64);
    let axes = report.get("boundary").and_then(serde_json::Value::as_array);
    let ends: Option<Vec<_>> = axes.map(|axes| axes.iter().map(end_of).collect());
    let mut remarks = Vec::new();
    if ends.iter().flatten().any(Option::is_none) {
        let why = "the result has open sides, and a flow that is tracked ends there as at walls";
        remarks.push(why.to_owned());
    }
    if report.get("solid").and_then(serde_json::Value::as_bool) == Some(true) {
        let why = "the result has solid cells, which a flow that is tracked does not know: it may pass through them";
        remarks.push(why.to_owned());
    }
    Known {
        boundary: ends.map(|ends| {
            ends.into_iter()
                .map(|end| end.unwrap_or(Boundary::Wall))
                .collect()
        }),
        length: number("length"),
        dt: number("dt"),
        remarks,
    }
}

/// How an axis ends, as a report says it, if a capture may have that.
fn end_of(word: &serde_json::Value) -> Option<Boundary> {
    let end = Boundary::from_name(word.as_str()?).ok()?;
    ENDS.contains(&end).then_some(end)
}

/// The frames of a folder: all files of one kind, by number.
fn in_folder(document: &Document, folder: &Path) -> Result<Numbered, Failure> {
    let unread = |error: std::io::Error| {
        let why = format!(
            "names {}, which cannot be read ({error}); correct it",
            folder.display()
        );
        Failure::File(format!("{}: `{KEY}` {why}", document.place(KEY)))
    };
    let entries = std::fs::read_dir(folder).map_err(unread)?;
    let all: Vec<PathBuf> = entries.filter_map(|entry| Some(entry.ok()?.path())).collect();
    let of = |ending: &str| -> Vec<PathBuf> {
        let fits = all.iter().filter(|path| ends_with(path, ending));
        fits.cloned().collect()
    };
    let mut kinds: Vec<Vec<PathBuf>> = ENDINGS
        .map(of)
        .into_iter()
        .filter(|paths| !paths.is_empty())
        .collect();
    match (kinds.pop(), kinds.is_empty()) {
        (Some(paths), true) => Ok(Numbered::of(paths)),
        (None, _) => Err(document.refuse(
            KEY,
            format!("names the folder {}, which holds no .npy, .npz, .vdb or pictures; name the folder of the frames", folder.display()),
        )),
        (Some(paths), false) => {
            let first = paths.first().and_then(|path| path.extension());
            let ending = first.unwrap_or_default().to_string_lossy();
            let shown = folder.display();
            Err(document.refuse(
                KEY,
                format!(
                    "names the folder {shown}, which holds files of several kinds; say which by a pattern, as in \"{shown}/*.{ending}\""
                ),
            ))
        }
    }
}

/// Refuses numbered files from number `first` to before number `end` of them among which one is missing, or there twice: they are evenly apart.
fn refuse_disorder(document: &Document, files: &Numbered, first: usize, end: usize) -> Result<(), Failure> {
    if let Some(name) = files.uncounted() {
        let why = format!(
            "has {name} among frames that are numbered: nothing says where it comes; take it away, or name the others by a pattern"
        );
        return Err(document.refuse(KEY, why));
    }
    if let Some([one, other]) = files.twice(first, end) {
        let why = format!(
            "has frames with the same number, {one} and {other}; name those of one camera by a pattern"
        );
        return Err(document.refuse(KEY, why));
    }
    match files.gap(first, end) {
        None => Ok(()),
        Some(gap) => {
            let why = format!(
                "lacks frame {} between {} and {}; add it, or track the frames before and after it on their own by capture.first and capture.last",
                gap.missing, gap.before, gap.after
            );
            Err(document.refuse(KEY, why))
        }
    }
}

/// The true velocities of a capture, component by component; of a result folder, those of its arrays.
pub(super) fn truth(scene: &CaptureScene, given: &Path, axes: usize) -> Result<Vec<Series>, Failure> {
    let inside = given.join(ARCHIVE);
    let archive = if given.is_dir() { &inside } else { given };
    let own = if has_array(archive, "truth_x") {
        "truth"
    } else {
        "velocity"
    };
    ["x", "y", "z"]
        .iter()
        .take(axes)
        .map(|axis| {
            let name = format!("{own}_{axis}");
            Series::open(archive, Some(&name), TRUTH).map_err(|error| refused(&scene.document, TRUTH, &error))
        })
        .collect()
}
