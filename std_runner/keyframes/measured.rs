//! Pictures and arrays as numbers that were measured: as they are, not stretched over a box.

use std::path::Path;

use super::ShapeError;
use super::decode::{self, is_picture};
use super::error::Fault;
use super::image::USUAL_SIDE;
use super::npy::Entry;
use super::npz;
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

/// How many entries the array `name` of `path`, which `key` names, has along its first axis.
///
/// # Errors
/// As [`measured`].
pub(crate) fn entries(key: &str, path: &Path, name: Option<&str>) -> Result<usize, ShapeError> {
    npz::steps(path, name).map_err(|fault| fault.of(key, path))
}

/// Reads a picture, an array, or the entry `entry` along the first axis of one; `key` names the file.
///
/// # Errors
/// A file that cannot be read, or a number that is not finite.
pub(crate) fn measured(
    key: &str,
    path: &Path,
    name: Option<&str>,
    entry: Option<usize>,
) -> Result<Measured, ShapeError> {
    read(path, name, entry).map_err(|fault| fault.of(key, path))
}

fn read(path: &Path, name: Option<&str>, entry: Option<usize>) -> Result<Measured, Fault> {
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
    let array = match entry {
        None => npz::read(path, name)?,
        Some(entry) => npz::read_entry(path, name, Entry::At(entry))?,
    };
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
