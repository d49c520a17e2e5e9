//! Frames of smoke: one array with time as its first axis, or a file for each.

use std::path::{Path, PathBuf};

use super::error::Fault;
use super::ink::Ink;
use super::series::{self, Series};
use super::{ShapeError, image, npz};

/// The array of densities in a `.npz` file.
const DENSITY: &str = "density";

/// Frames that are read one by one.
#[derive(Debug)]
pub struct Frames {
    /// The scene's key that names the files, for messages.
    key: String,
    held: Held,
}

#[derive(Debug)]
enum Held {
    Array(Series),
    Files {
        paths: Vec<PathBuf>,
        name: Option<String>,
        ink: Option<Ink>,
    },
}

/// A frame: densities, x fastest.
#[derive(Clone, Debug)]
pub struct Frame {
    /// Cells along x, y (and z).
    pub cells: Vec<usize>,
    /// A value for each cell.
    pub values: Vec<f64>,
}

impl Frames {
    /// The array of densities of a file: that of a `.npy`, the array `name` of a `.npz`, which is `density` where nothing is said.
    ///
    /// # Errors
    /// A file that cannot be read, or has no such array.
    pub fn of_array(path: &Path, name: Option<&str>, key: &str) -> Result<Self, ShapeError> {
        let name = if ends_with(path, "npz") {
            Some(name.unwrap_or(DENSITY))
        } else {
            None
        };
        Ok(Self {
            key: key.to_owned(),
            held: Held::Array(Series::open(path, name, key)?),
        })
    }

    /// One frame a file, in this order; `ink` says which pixels of pictures are smoke.
    ///
    /// # Errors
    /// An `ink` that is none.
    pub fn of_files(
        paths: Vec<PathBuf>,
        name: Option<&str>,
        ink: Option<&str>,
        key: &str,
    ) -> Result<Self, ShapeError> {
        Ok(Self {
            key: key.to_owned(),
            held: Held::Files {
                paths,
                name: name.map(str::to_owned),
                ink: ink.map(Ink::parse).transpose()?,
            },
        })
    }

    /// How many there are.
    #[must_use]
    pub fn count(&self) -> usize {
        match &self.held {
            Held::Array(series) => series.count(),
            Held::Files { paths, .. } => paths.len(),
        }
    }

    /// The file that a frame is in, and its number there if it has several.
    #[must_use]
    pub fn place(&self, frame: usize) -> (&Path, Option<usize>) {
        match &self.held {
            Held::Array(series) => (series.path(), Some(frame)),
            Held::Files { paths, .. } => (paths.get(frame).map_or(Path::new(""), PathBuf::as_path), None),
        }
    }

    /// A refusal of what is in a frame.
    #[must_use]
    pub fn refuse(&self, frame: usize, found: &str, remedy: &str) -> ShapeError {
        let (path, number) = self.place(frame);
        let of = number.map_or(String::new(), |number| format!("in frame {number} "));
        Fault::content(format!("{of}{found}"), remedy).of(&self.key, path)
    }

    /// Reads a frame.
    ///
    /// # Errors
    /// A file that cannot be read, or is no density.
    pub fn read(&mut self, frame: usize) -> Result<Frame, ShapeError> {
        let key = self.key.clone();
        match &mut self.held {
            Held::Array(series) => {
                let cells = series.shape().iter().rev().copied().collect();
                let values = series.read(frame)?;
                Ok(Frame { cells, values })
            }
            Held::Files { paths, name, ink } => {
                let path = paths.get(frame).map_or(Path::new(""), PathBuf::as_path);
                of_file(path, name.as_deref(), ink).map_err(|fault| fault.of(&key, path))
            }
        }
    }
}

fn ends_with(path: &Path, ending: &str) -> bool {
    path.extension()
        .is_some_and(|extension| extension.eq_ignore_ascii_case(ending))
}

/// The frame of a file of its own. The first picture decides which pixels are smoke in all of them, where nothing is said.
fn of_file(path: &Path, name: Option<&str>, ink: &mut Option<Ink>) -> Result<Frame, Fault> {
    if ends_with(path, "png") {
        let (picture, taken) = image::read(path, *ink)?;
        *ink = Some(taken);
        return Ok(Frame {
            cells: vec![picture.width, picture.height],
            values: picture.values,
        });
    }
    let name = if ends_with(path, "npz") {
        Some(name.unwrap_or(DENSITY))
    } else {
        None
    };
    let array = npz::read(path, name)?;
    Ok(Frame {
        cells: array.shape.iter().rev().copied().collect(),
        values: array.values,
    })
}

/// Whether a file is a `.npz` with an array of densities.
#[must_use]
pub fn has_array(path: &Path, name: &str) -> bool {
    ends_with(path, "npz") && series::has(path, name)
}
