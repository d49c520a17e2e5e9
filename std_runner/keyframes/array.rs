//! `file = "x.npy"` or "x.npz": densities from NumPy, of any size.

use std::path::Path;

use super::ending::ends_with;
use super::error::Fault;
use super::header::drop_ones;
use super::note::Note;
use super::npy::Entry;
use super::npz;
use super::resample::resampled;
use super::spec::EntryKey;
use super::{Canvas, ShapeError, ShapeSpec};

/// White in pictures of 8 and 16 bits, as which arrays of whole numbers are often meant.
const WHITES: [f64; 2] = [255.0, 65535.0];

/// How many steps the array of a shape has along its first axis, of which each is a density.
///
/// # Errors
/// A shape that is no `file`; a file that cannot be read or has no such axis.
pub fn steps_of_array(shape: &ShapeSpec, base: &Path) -> Result<usize, ShapeError> {
    let Some(path) = &shape.file else {
        let remedy =
            "write files = \"horse_*.png\", or file = \"x.npz\" whose array has time as its first axis";
        return Err(ShapeError::key(
            "steps",
            "asks for a sequence of shapes, and there is one",
            remedy,
        ));
    };
    let path = base.join(path);
    if ends_with(&path, "vdb") {
        let remedy = "write files = \"smoke_*.vdb\", or leave `steps` out";
        return Err(
            Fault::content("is one volume, and `steps` asks for a sequence", remedy).of("file", &path),
        );
    }
    npz::steps(&path, shape.name.as_deref()).map_err(|fault| fault.of("file", &path))
}

/// The entry of an array that a shape asks for.
///
/// # Errors
/// A word but "last"; an entry that the array has not; a file that cannot be read.
pub(super) fn entry(path: &Path, name: Option<&str>, key: &EntryKey) -> Result<Entry, ShapeError> {
    match key {
        EntryKey::Word(word) if word == "last" => Ok(Entry::Last),
        EntryKey::Word(word) => {
            let remedy = "write a whole number from 0, or \"last\"";
            Err(ShapeError::key("entry", format!("is {word:?}"), remedy))
        }
        &EntryKey::Number(number) => {
            let count = npz::steps(path, name).map_err(|fault| fault.of("file", path))?;
            if number < count {
                return Ok(Entry::At(number));
            }
            let remedy = format!("the array has {count}, so write 0 to {}, or \"last\"", count - 1);
            Err(ShapeError::key("entry", format!("is {number}"), remedy))
        }
    }
}

/// The array, or an entry of it, stretched over the box.
pub(super) fn draw(
    path: &Path,
    (name, entry): (Option<&str>, Option<Entry>),
    canvas: &Canvas,
    notes: &mut Vec<Note>,
) -> Result<Vec<f64>, ShapeError> {
    densities(path, (name, entry), canvas, notes).map_err(|fault| fault.of("file", path))
}

fn densities(
    path: &Path,
    (name, entry): (Option<&str>, Option<Entry>),
    canvas: &Canvas,
    notes: &mut Vec<Note>,
) -> Result<Vec<f64>, Fault> {
    let mut array = match entry {
        None => npz::read(path, name)?,
        Some(entry) => npz::read_entry(path, name, entry)?,
    };
    drop_ones(&mut array.shape, canvas.dimensions());
    if array.shape.len() != canvas.dimensions() || array.values.is_empty() {
        let order = if canvas.dimensions() == 3 {
            "[z, y, x]"
        } else {
            "[y, x]"
        };
        let found = format!("has the shape ({})", array.size_in_words());
        let remedy = format!(
            "a {}D grid takes an array with axes {order} and at least one value",
            canvas.dimensions()
        );
        return Err(Fault::content(found, remedy));
    }
    let of_entry = |fault: Fault| {
        fault.of_entry(match entry {
            Some(Entry::At(entry)) => Some(entry),
            _ => None,
        })
    };
    array.refuse_not_finite().map_err(of_entry)?;
    if let Some(text) = array.clip().map_err(of_entry)? {
        notes.push(Note::remark(format!("`{}` {text}", path.display())));
    }
    let largest = array.values.iter().copied().fold(0.0, f64::max);
    if let Some(white) = WHITES.into_iter().find(|white| *white >= largest)
        && largest > 0.5 * white
        && array.values.iter().all(|value| value.fract() == 0.0)
    {
        notes.push(Note::warning(format!(
            "`{}` holds whole numbers up to {largest}, which are its densities; if {white} is white, write density = {:.3e} beside `file`",
            path.display(),
            1.0 / white
        )));
    }
    let shape: Vec<usize> = array.shape.iter().rev().copied().collect();
    Ok(resampled(array.values, &shape, canvas))
}
