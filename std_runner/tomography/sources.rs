//! The pictures of a camera: a file for each frame, or an array of all of them.

use super::raw::RawCamera;
use crate::exit::Failure;
use crate::keyframes::{Measured, ShapeError, entries, is_picture, measured};
use crate::scene::{Document, files_of};
use std::path::{Path, PathBuf};

/// Where the pictures of a camera are.
pub(super) enum Source {
    /// One file a frame, in the order of the frames.
    Files(Vec<PathBuf>),
    /// Entries along the first axis of an array.
    Array {
        path: PathBuf,
        name: Option<String>,
        frames: usize,
    },
    /// One picture.
    One { path: PathBuf, name: Option<String> },
}

impl Source {
    /// Reads camera `key` of the file.
    pub fn of(document: &Document, key: &str, raw: &RawCamera, dims: usize) -> Result<Self, Failure> {
        match (&raw.files, &raw.file) {
            (Some(pattern), None) => {
                let files = files_of(document, &format!("{key}.files"), pattern)?;
                no_gap(document, &format!("{key}.files"), pattern, &files)?;
                Ok(Self::Files(files))
            }
            (None, Some(file)) => {
                let (path, name) = (document.folder().join(file), raw.array.clone());
                let one = Self::One {
                    path: path.clone(),
                    name: name.clone(),
                };
                let axes = one.read(document, key, 0)?.shape.len();
                if axes < dims || is_picture(&path) {
                    return Ok(one);
                }
                let frames = entries("file", &path, name.as_deref()).map_err(refuse(document, key))?;
                Ok(Self::Array { path, name, frames })
            }
            _ => {
                let why = "needs its pictures; write files = \"front_*.png\" (or .npy), or file = \"views.npz\" with array = \"front\"";
                Err(document.refuse(key, why))
            }
        }
    }

    /// How many frames it has.
    pub fn frames(&self) -> usize {
        match self {
            Self::Files(files) => files.len(),
            Self::Array { frames, .. } => *frames,
            Self::One { .. } => 1,
        }
    }

    /// The file of a frame, in words.
    pub fn shown(&self, frame: usize) -> String {
        match self {
            Self::Files(files) => files
                .get(frame)
                .map(|path| path.display().to_string())
                .unwrap_or_default(),
            Self::Array { path, name, .. } => {
                format!(
                    "{}, {}[{frame}]",
                    path.display(),
                    name.as_deref().unwrap_or_default()
                )
            }
            Self::One { path, .. } => path.display().to_string(),
        }
    }

    /// The picture of a frame.
    pub fn read(&self, document: &Document, key: &str, frame: usize) -> Result<Measured, Failure> {
        let read = |path: &Path, name: Option<&str>, entry| measured("file", path, name, entry);
        let picture = match self {
            Self::Files(files) => match files.get(frame) {
                Some(path) => read(path, None, None),
                None => return Err(document.refuse(key, format!("has no picture {frame}"))),
            },
            Self::Array { path, name, .. } => read(path, name.as_deref(), Some(frame)),
            Self::One { path, name } => read(path, name.as_deref(), None),
        };
        Ok(picture.map_err(refuse(document, key))?.grey())
    }
}

pub(super) fn refuse<'a>(document: &'a Document, key: &'a str) -> impl Fn(ShapeError) -> Failure + 'a {
    move |error| {
        let sentence = format!("{}: in {key}: {error}", document.place(key));
        error.failure(sentence)
    }
}

/// Refuses a sequence whose numbers leave one out.
fn no_gap(document: &Document, key: &str, pattern: &str, files: &[PathBuf]) -> Result<(), Failure> {
    let name = Path::new(pattern)
        .file_name()
        .unwrap_or_default()
        .to_string_lossy()
        .into_owned();
    let (before, after) = name.split_once('*').unwrap_or_default();
    let number = |path: &PathBuf| -> Option<u64> {
        let name = path.file_name()?.to_str()?;
        name.strip_prefix(before)?.strip_suffix(after)?.parse().ok()
    };
    let numbers: Vec<u64> = files.iter().filter_map(number).collect();
    if numbers.len() != files.len() {
        return Ok(());
    }
    let apart = numbers.windows(2).map(|pair| pair[1] - pair[0]);
    let least = apart.clone().min().unwrap_or(1);
    match numbers.windows(2).find(|pair| pair[1] - pair[0] != least) {
        None => Ok(()),
        Some(pair) => Err(document.refuse(
            key,
            format!(
                "is \"{pattern}\", and the frame {} is missing between {} and {}; put it there, or give the frames without it other numbers",
                pair[0] + least, pair[0], pair[1]
            ),
        )),
    }
}
