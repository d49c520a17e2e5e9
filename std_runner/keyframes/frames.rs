//! Frames of smoke: one array with time as its first axis, or a file for each.

use std::path::{Path, PathBuf};

use super::decode::is_picture;
use super::ending::ends_with;
use super::error::Fault;
use super::header::drop_ones;
use super::ink::Ink;
use super::series::{self, Series};
use super::vdb::{self, Bounds};
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
        /// Of volumes: the voxels that count in any of them.
        bounds: Option<Bounds>,
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
    /// The array of densities of a file: that of a `.npy`, the array `name` of a `.npz`; where nothing is said, that
    /// is `density`, or the only one.
    ///
    /// # Errors
    /// A file that cannot be read, or has no such array.
    pub fn of_array(path: &Path, name: Option<&str>, key: &str) -> Result<Self, ShapeError> {
        let name = name_in(path, name).map_err(|fault| fault.of(key, path))?;
        Ok(Self {
            key: key.to_owned(),
            held: Held::Array(Series::open(path, name.as_deref(), key)?),
        })
    }

    /// One frame a file, in this order; `ink` says which pixels of pictures are smoke.
    ///
    /// # Errors
    /// An `ink` that is none; a volume that cannot be read.
    pub fn of_files(
        paths: Vec<PathBuf>,
        name: Option<&str>,
        ink: Option<&str>,
        key: &str,
    ) -> Result<Self, ShapeError> {
        let mut bounds: Option<Bounds> = None;
        for path in paths.iter().filter(|path| ends_with(path, "vdb")) {
            let own = vdb::bounds(path, name).map_err(|fault| fault.of(key, path))?;
            bounds = Some(bounds.map_or(own, |bounds| bounds.and(own)));
        }
        Ok(Self {
            key: key.to_owned(),
            held: Held::Files {
                paths,
                name: name.map(str::to_owned),
                ink: ink.map(Ink::parse).transpose()?,
                bounds,
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
            Held::Files {
                paths,
                name,
                ink,
                bounds,
            } => {
                let path = paths.get(frame).map_or(Path::new(""), PathBuf::as_path);
                if let Some(bounds) = bounds.filter(|_| ends_with(path, "vdb")) {
                    let values =
                        vdb::frame(path, name.as_deref(), bounds).map_err(|fault| fault.of(&key, path))?;
                    // A volume of one voxel's thickness is a plane.
                    let cells = bounds.sides().into_iter().filter(|&side| side > 1).collect();
                    return Ok(Frame { cells, values });
                }
                of_file(path, name.as_deref(), ink).map_err(|fault| fault.of(&key, path))
            }
        }
    }
}

/// The array to read of a file: that of a `.npz` that is asked for, else its densities, else the only one in it.
fn name_in(path: &Path, name: Option<&str>) -> Result<Option<String>, Fault> {
    match name {
        _ if !ends_with(path, "npz") => Ok(None),
        Some(name) => Ok(Some(name.to_owned())),
        None if has_array(path, DENSITY) => Ok(Some(DENSITY.to_owned())),
        None => npz::sole_name(path).map(Some),
    }
}

/// The frame of a file of its own. The first picture decides which pixels are smoke in all of them, where nothing is said.
fn of_file(path: &Path, name: Option<&str>, ink: &mut Option<Ink>) -> Result<Frame, Fault> {
    if is_picture(path) {
        let (picture, taken) = image::read(path, *ink, image::USUAL_SIDE)?;
        *ink = Some(taken);
        return Ok(Frame {
            cells: vec![picture.width, picture.height],
            values: picture.values,
        });
    }
    let mut array = npz::read(path, name_in(path, name)?.as_deref())?;
    drop_ones(&mut array.shape, 2);
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
