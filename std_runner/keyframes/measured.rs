//! Pictures and arrays as numbers that were measured: as they are, not stretched over a box.

use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use super::decode::{self, is_picture};
use super::ending::ends_with;
use super::error::Fault;
use super::image::USUAL_SIDE;
use super::npy::Array;
use super::series::Series;
use super::{ShapeError, npz};
use crate::undershoot::{Undershoot, clip, place};

/// Numbers with their shape, x last and fastest; of a picture in colour the channel is last.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Measured {
    /// Length of each axis.
    pub shape: Vec<usize>,
    /// The numbers, row 0 at the top of a picture.
    pub values: Vec<f64>,
    /// What the user should hear of them.
    pub note: Option<String>,
}

/// The entries along the first axis of an array, each of them measured, in any order and by any thread; or the only one of a picture.
pub(crate) struct Measurements {
    key: String,
    path: PathBuf,
    name: Option<String>,
    /// None of a picture.
    series: Option<Mutex<Series>>,
    count: usize,
}

impl Measurements {
    /// Those of the array `name` of `path`, which `key` names; the sole one of a `.npz` where there is no name.
    ///
    /// # Errors
    /// As [`measured`], but for what only the reading of an entry tells.
    pub fn open(key: &str, path: &Path, name: Option<&str>) -> Result<Self, ShapeError> {
        let failed = |fault: Fault| fault.of(key, path);
        let name = match name {
            None if ends_with(path, "npz") => Some(npz::sole_name(path).map_err(failed)?),
            name => name.map(str::to_owned),
        };
        let series = if is_picture(path) {
            None
        } else {
            npz::check_ending(path, name.as_deref()).map_err(failed)?;
            Some(Series::open(path, name.as_deref(), key)?)
        };
        Ok(Self {
            key: key.to_owned(),
            path: path.to_owned(),
            name,
            count: series.as_ref().map_or(1, Series::count),
            series: series.map(Mutex::new),
        })
    }

    /// How many there are.
    pub fn count(&self) -> usize {
        self.count
    }

    /// The file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The array in the file, where that has names.
    pub fn name(&self) -> Option<&str> {
        self.name.as_deref()
    }

    /// Reads one; of a picture whatever its number.
    ///
    /// # Errors
    /// As [`measured`].
    pub fn read(&self, entry: usize) -> Result<Measured, ShapeError> {
        let Some(series) = &self.series else {
            return measured(&self.key, &self.path, None);
        };
        let mut series = series.lock().unwrap_or_else(PoisonError::into_inner);
        let read = series.array(entry).and_then(finite);
        read.map_err(|fault| fault.of(&self.key, &self.path))
    }
}

/// Reads a picture or an array; `key` names the file.
///
/// # Errors
/// A file that cannot be read, or a number that is not finite.
pub(crate) fn measured(key: &str, path: &Path, name: Option<&str>) -> Result<Measured, ShapeError> {
    read(path, name).map_err(|fault| fault.of(key, path))
}

fn read(path: &Path, name: Option<&str>) -> Result<Measured, Fault> {
    if is_picture(path) {
        let picture = decode::read(path, USUAL_SIDE)?;
        let (channels, values) = picture.plain();
        if let Some(odd) = values.iter().find(|value| !value.is_finite()) {
            return Err(Fault::content(
                format!("holds {odd}"),
                "every value must be finite; save it again",
            ));
        }
        let mut shape = vec![picture.height, picture.width];
        shape.extend((channels > 1).then_some(channels));
        let note = picture.note.map(|said| format!("`{}` {said}", path.display()));
        return Ok(Measured { shape, values, note });
    }
    finite(npz::read(path, name)?)
}

/// An array as it is, where all of it is finite.
fn finite(array: Array) -> Result<Measured, Fault> {
    array.refuse_not_finite()?;
    Ok(Measured {
        shape: array.shape,
        values: array.values,
        note: None,
    })
}

impl Measured {
    /// Sets what little is below 0 to 0 and notes it, or says what is wrong and the remedy.
    pub fn clip(&mut self) -> Result<(), [String; 2]> {
        let Some(found) = Undershoot::of(&self.values) else {
            return Ok(());
        };
        if !found.is_small() {
            return Err([
                format!(
                    "holds {} values below 0, the least {:.3e} at {}",
                    found.count,
                    found.least,
                    place(found.at, &self.shape)
                ),
                "smoke gives light and takes none: take the background off, and set what is below it to 0"
                    .into(),
            ]);
        }
        clip(&mut self.values);
        self.note = Some(found.taken());
        Ok(())
    }

    /// The luminance of a picture in colour; others stay.
    pub fn grey(mut self) -> Self {
        if self.shape.len() == 3 && self.shape.last() == Some(&3) {
            let weights = [0.2126, 0.7152, 0.0722];
            let luminance = |pixel: &[f64]| {
                pixel
                    .iter()
                    .zip(weights)
                    .map(|(level, weight)| level * weight)
                    .sum()
            };
            self.values = self.values.chunks_exact(3).map(luminance).collect();
            self.shape.truncate(2);
        }
        self
    }
}
