//! Which files of a result folder thurible wrote: those of its manifest. Everything else in it is the user's.

use core::time::Duration;
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::fs::{self, Metadata};
use std::path::{Component, Path, PathBuf};
use std::time::SystemTime;

/// The list of the files that were written, beside them.
pub(super) const MANIFEST: &str = "manifest.json";

/// Who writes manifests.
const WRITER: &str = "thurible";

/// Files below a folder, each as it was when it was last looked at.
#[derive(Clone, Debug, Default)]
pub(super) struct Written {
    files: BTreeMap<PathBuf, Stamp>,
}

/// By what a file is known again.
#[derive(Clone, Copy, Debug)]
struct Stamp {
    bytes: u64,
    modified: Option<SystemTime>,
}

/// Some file systems round times, to two seconds at most, and only after a file has been written.
const ROUNDED: Duration = Duration::from_secs(2);

impl Stamp {
    fn is_like(&self, other: &Self) -> bool {
        let apart = match (self.modified, other.modified) {
            (Some(one), Some(two)) => one.duration_since(two).unwrap_or_else(|error| error.duration()),
            _ => Duration::ZERO,
        };
        self.bytes == other.bytes && apart <= ROUNDED
    }

    /// Of a plain file; links and folders have none.
    fn of(path: &Path) -> Option<Self> {
        let found = fs::symlink_metadata(path).ok().filter(Metadata::is_file)?;
        Some(Self {
            bytes: found.len(),
            modified: found.modified().ok(),
        })
    }
}

impl Written {
    /// Those of `files` that are there, as they are now.
    pub(super) fn now(folder: &Path, files: impl IntoIterator<Item = PathBuf>) -> Self {
        let stamped = |file: PathBuf| Stamp::of(&folder.join(&file)).map(|stamp| (file, stamp));
        Self {
            files: files
                .into_iter()
                .filter(|file| barrier(folder, file).is_none())
                .filter_map(stamped)
                .collect(),
        }
    }

    /// What an earlier run wrote into `folder`, where the JSON file `mark` tells that it holds a result: the files of the manifest, or, of
    /// a result without one, those that have our names.
    pub(super) fn found(folder: &Path, mark: &str) -> Self {
        match manifest(folder) {
            Some(files) if !files.iter().any(|file| file == Path::new(mark)) => Self::default(),
            Some(files) => Self::now(folder, files.into_iter().chain([MANIFEST.into()])),
            None if is_result(folder, mark) => Self::now(folder, by_name(folder, mark)),
            None => Self::default(),
        }
    }

    /// Whether there are none.
    pub(super) fn is_empty(&self) -> bool {
        self.files.is_empty()
    }

    /// Their paths, relative to the folder.
    pub(super) fn files(&self) -> impl Iterator<Item = &PathBuf> {
        self.files.keys()
    }

    /// Whether `file` is still the one that was looked at.
    pub(super) fn holds(&self, folder: &Path, file: &Path) -> bool {
        let found = Stamp::of(&folder.join(file));
        let stamp = self.files.get(file).zip(found);
        stamp.is_some_and(|(known, found)| known.is_like(&found))
    }

    /// What of the user's stands in the way of writing `file`: the file itself, or what should be its folder.
    pub(super) fn in_the_way(&self, folder: &Path, file: &Path) -> Option<PathBuf> {
        barrier(folder, file).or_else(|| {
            let taken = fs::symlink_metadata(folder.join(file)).is_ok();
            (taken && !self.holds(folder, file)).then(|| file.to_path_buf())
        })
    }
}

/// Whether a result of any kind is in `folder`.
pub(super) fn is_of_ours(folder: &Path) -> bool {
    manifest(folder).is_some()
}

/// Whether the JSON file `mark` of `folder` is that of a result.
pub(super) fn is_result(folder: &Path, mark: &str) -> bool {
    let report = fs::read_to_string(folder.join(mark)).unwrap_or_default();
    serde_json::from_str::<Value>(&report).is_ok_and(|report| report.get("format").is_some())
}

/// The text of a manifest of `files`.
pub(super) fn manifest_of<'a>(files: impl IntoIterator<Item = &'a PathBuf>) -> String {
    let names: Vec<_> = files.into_iter().map(|file| file.to_string_lossy()).collect();
    format!(
        "{:#}\n",
        json!({ "format": 1, "written_by": WRITER, "files": names })
    )
}

/// The files that the manifest of `folder` names, if it has one of ours; paths that lead out of the folder are left out.
fn manifest(folder: &Path) -> Option<Vec<PathBuf>> {
    let text = fs::read_to_string(folder.join(MANIFEST)).ok()?;
    let manifest: Value = serde_json::from_str(&text).ok()?;
    if manifest.get("written_by").and_then(Value::as_str) != Some(WRITER) {
        return None;
    }
    let names = manifest.get("files")?.as_array()?;
    let files = names.iter().filter_map(Value::as_str).map(PathBuf::from);
    Some(files.filter(|file| stays_inside(file)).collect())
}

/// Whether a path leads to nothing outside of the folder that it is relative to.
pub(super) fn stays_inside(file: &Path) -> bool {
    let plain = |part| matches!(part, Component::Normal(_));
    file.components().next().is_some() && file.components().all(plain)
}

/// The files of a result, or of the page that `mark` belongs to, by the names that we give them.
fn by_name(folder: &Path, mark: &str) -> Vec<PathBuf> {
    let stem = mark.trim_end_matches(".json");
    let (names, pictures) = if stem == "report" {
        let names = ["result.npz", "report.json", "report.html", "animation.png"];
        (names.map(String::from).to_vec(), "frames".to_string())
    } else {
        let names = ["json", "html", "md"].map(|kind| format!("{stem}.{kind}"));
        (names.to_vec(), format!("{stem}_pictures"))
    };
    let numbered = |name: &str| {
        let number = name.strip_prefix("frame_").unwrap_or(name);
        let digits = number
            .strip_suffix(".png")
            .or_else(|| number.strip_suffix(".svg"));
        digits.is_some_and(|digits| digits.len() > 2 && digits.bytes().all(|digit| digit.is_ascii_digit()))
    };
    let below = fs::read_dir(folder.join(&pictures)).into_iter().flatten();
    let below = below.filter_map(|entry| entry.ok()?.file_name().into_string().ok());
    let below = below
        .filter(|name| numbered(name))
        .map(|name| Path::new(&pictures).join(name));
    names.into_iter().map(PathBuf::from).chain(below).collect()
}

/// The first part of the way from `folder` to `file` that is there and is no folder, a link for one.
fn barrier(folder: &Path, file: &Path) -> Option<PathBuf> {
    let mut ancestors: Vec<&Path> = file.ancestors().skip(1).collect();
    ancestors.retain(|part| !part.as_os_str().is_empty());
    let no_folder =
        |part: &&&Path| fs::symlink_metadata(folder.join(part)).is_ok_and(|found| !found.is_dir());
    ancestors
        .iter()
        .rev()
        .find(no_folder)
        .map(|part| part.to_path_buf())
}
