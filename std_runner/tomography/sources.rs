//! The pictures of a camera: a file for each frame, or an array of all of them; as light, less what there is without smoke.

use super::place::positive;
use super::raw::{RawBackground, RawCamera};
use crate::deblur::Light;
use crate::exit::Failure;
use crate::keyframes::{Measured, Measurements, ShapeError, is_picture, measured};
use crate::scene::{Document, in_order};
use std::path::PathBuf;

/// The pictures of a camera.
pub(super) struct Source {
    pictures: Pictures,
    /// How they store light.
    light: Light,
    background: Background,
    /// What its pixels are multiplied by, beside those of all cameras.
    scale: f64,
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
            scale: positive(document, &format!("{key}.scale"), raw.scale.unwrap_or(1.0))?,
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
                let found = measured("background", &path, None).map_err(refuse(document, &place))?;
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
            Pictures::One { path, .. } => core::slice::from_ref(path),
            Pictures::Array(_) => &[],
        };
        files.iter().any(|file| Light::of(file) == Light::Srgb)
    }

    /// The picture of a frame, in grey, what its background leaves of it, times its scale.
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
        if self.scale != 1.0 {
            picture.values.iter_mut().for_each(|value| *value *= self.scale);
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
    Array(Box<Measurements>),
    /// One picture.
    One { path: PathBuf, name: Option<String> },
}

impl Pictures {
    /// Reads camera `key` of the file.
    fn of(document: &Document, key: &str, raw: &RawCamera, dims: usize) -> Result<Self, Failure> {
        match (&raw.files, &raw.file) {
            (Some(pattern), None) => {
                let files = in_order(document, &format!("{key}.files"), pattern, ["frame", ""])?;
                Ok(Self::Files(files.paths))
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
                let held = Measurements::open("file", &path, name.as_deref());
                held.map(|held| Self::Array(Box::new(held)))
                    .map_err(refuse(document, key))
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
            Self::Array(held) => held.count(),
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
            Self::Array(held) => {
                let name = held.name().unwrap_or_default();
                format!("{}, {name}[{frame}]", held.path().display())
            }
            Self::One { path, .. } => path.display().to_string(),
        }
    }

    /// The picture of a frame, as it is stored.
    fn read(&self, document: &Document, key: &str, frame: usize) -> Result<Measured, Failure> {
        let picture = match self {
            Self::Files(files) => match files.get(frame) {
                Some(path) => measured("file", path, None),
                None => return Err(document.refuse(key, format!("has no picture {frame}"))),
            },
            Self::Array(held) => held.read(frame),
            Self::One { path, name } => measured("file", path, name.as_deref()),
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
