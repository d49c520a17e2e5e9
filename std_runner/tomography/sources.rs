//! The pictures of a camera: a file for each frame, or an array of all of them; as light, less what there is without smoke.

use super::raw::{RawBackground, RawCamera};
use crate::deblur::Light;
use crate::exit::Failure;
use crate::keyframes::{Measured, ShapeError, entries, is_picture, measured};
use crate::scene::{Document, files_of};
use std::path::{Path, PathBuf};

/// The pictures of a camera.
pub(super) struct Source {
    pictures: Pictures,
    /// How they store light.
    light: Light,
    background: Background,
}

/// What is seen without smoke.
enum Background {
    Level(f64),
    Picture(Vec<f64>),
}

/// How the pictures of a file of views store light, by the word for it; linear where there is none.
pub(super) fn light(document: &Document, word: Option<&str>) -> Result<Light, Failure> {
    match word {
        None | Some("linear") => Ok(Light::Linear),
        Some("srgb") => Ok(Light::Srgb),
        Some(other) => {
            let why =
                format!("is \"{other}\"; write \"linear\", or \"srgb\" for pictures as screens show them");
            Err(document.refuse("pictures.light", why))
        }
    }
}

impl Source {
    /// Reads camera `key` of the file.
    pub fn of(
        document: &Document,
        key: &str,
        raw: &RawCamera,
        dims: usize,
        light: Light,
    ) -> Result<Self, Failure> {
        let mut source = Self {
            pictures: Pictures::of(document, key, raw, dims)?,
            light,
            background: Background::Level(0.0),
        };
        let place = format!("{key}.background");
        source.background = match &raw.background {
            None => return Ok(source),
            Some(RawBackground::Level(level)) if *level >= 0.0 && level.is_finite() => {
                Background::Level(*level)
            }
            Some(RawBackground::Level(level)) => {
                let why = format!("is {level}; write a number from 0, or the name of a picture");
                return Err(document.refuse(&place, why));
            }
            Some(RawBackground::File(file)) => {
                let path = document.folder().join(file);
                let found = measured("background", &path, None, None).map_err(refuse(document, &place))?;
                let (found, first) = (source.as_light(found), source.read(document, key, 0)?);
                if found.shape != first.shape {
                    let why = format!(
                        "`{}` has the shape {:?}, and the camera's pictures {:?}; give one of the same size",
                        path.display(),
                        found.shape,
                        first.shape
                    );
                    return Err(document.refuse(&place, why));
                }
                Background::Picture(found.values)
            }
        };
        Ok(source)
    }

    /// How many frames it has.
    pub fn frames(&self) -> usize {
        self.pictures.frames()
    }

    /// The file of a frame, in words.
    pub fn shown(&self, frame: usize) -> String {
        self.pictures.shown(frame)
    }

    /// Whether some of its files are of a kind that mostly holds levels as screens show them.
    pub fn is_for_screens(&self) -> bool {
        let files = match &self.pictures {
            Pictures::Files(files) => files.as_slice(),
            Pictures::Array { path, .. } | Pictures::One { path, .. } => core::slice::from_ref(path),
        };
        files.iter().any(|file| Light::of(file) == Light::Srgb)
    }

    /// The picture of a frame, in grey, what its background leaves of it.
    pub fn read(&self, document: &Document, key: &str, frame: usize) -> Result<Measured, Failure> {
        let mut picture = self.as_light(self.pictures.read(document, key, frame)?);
        let less = |value: &mut f64, by: f64| {
            // Noise about the background is no light that is missing.
            *value = if *value < by { 0.0 } else { *value - by };
        };
        match &self.background {
            Background::Level(level) if *level == 0.0 => {}
            Background::Level(level) => picture.values.iter_mut().for_each(|value| less(value, *level)),
            Background::Picture(values) => {
                let pairs = picture.values.iter_mut().zip(values);
                pairs.for_each(|(value, by)| less(value, *by));
            }
        }
        Ok(picture)
    }

    /// A picture's levels as light, in grey.
    fn as_light(&self, mut picture: Measured) -> Measured {
        if self.light == Light::Srgb {
            let levels = picture.values.iter_mut();
            levels.for_each(|level| *level = self.light.decoded(*level));
        }
        picture.grey()
    }
}

/// Where pictures are.
enum Pictures {
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

impl Pictures {
    /// Reads camera `key` of the file.
    fn of(document: &Document, key: &str, raw: &RawCamera, dims: usize) -> Result<Self, Failure> {
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
                let axes = one.read(document, key, 0)?.grey().shape.len();
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

    /// How many frames there are.
    fn frames(&self) -> usize {
        match self {
            Self::Files(files) => files.len(),
            Self::Array { frames, .. } => *frames,
            Self::One { .. } => 1,
        }
    }

    /// The file of a frame, in words.
    fn shown(&self, frame: usize) -> String {
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

    /// The picture of a frame, as it is stored.
    fn read(&self, document: &Document, key: &str, frame: usize) -> Result<Measured, Failure> {
        let read = |path: &Path, name: Option<&str>, entry| measured("file", path, name, entry);
        let picture = match self {
            Self::Files(files) => match files.get(frame) {
                Some(path) => read(path, None, None),
                None => return Err(document.refuse(key, format!("has no picture {frame}"))),
            },
            Self::Array { path, name, .. } => read(path, name.as_deref(), Some(frame)),
            Self::One { path, name } => read(path, name.as_deref(), None),
        };
        picture.map_err(refuse(document, key))
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
