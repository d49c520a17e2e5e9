//! Lists of different kinds in one archive.

use super::OutputError;
use super::archive::{header, stored};
use super::file::write_whole;
use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::Path;
use zip::ZipWriter;

/// An array of a result.
pub(crate) struct List<'a> {
    pub name: &'static str,
    pub shape: Vec<usize>,
    pub values: Values<'a>,
}

/// Its values.
pub(crate) enum Values<'a> {
    Reals(&'a [f64]),
    Whole(&'a [i64]),
    Flags(&'a [bool]),
}

/// Writes lists into the archive `path`.
pub(crate) fn write_lists(path: &Path, lists: &[List<'_>]) -> Result<(), OutputError> {
    write_whole(path, |file| {
        let mut zip = ZipWriter::new(file);
        if let Err(error) = lists.iter().try_for_each(|list| put(&mut zip, list)) {
            // Dropped, it would try to end the file and print what it thinks of the attempt.
            core::mem::forget(zip);
            return Err(OutputError::of(path)(error));
        }
        zip.finish().map_err(OutputError::of(path))?;
        Ok(())
    })
}

fn put(zip: &mut ZipWriter<&mut BufWriter<File>>, list: &List<'_>) -> io::Result<()> {
    let (kind, bytes): (&str, Vec<u8>) = match list.values {
        Values::Reals(values) => (
            "<f8",
            values.iter().flat_map(|value| value.to_le_bytes()).collect(),
        ),
        Values::Whole(values) => (
            "<i8",
            values.iter().flat_map(|value| value.to_le_bytes()).collect(),
        ),
        Values::Flags(values) => ("|b1", values.iter().map(|&value| value.into()).collect()),
    };
    zip.start_file(format!("{}.npy", list.name), stored())?;
    zip.write_all(&header(kind, &list.shape))?;
    zip.write_all(&bytes)
}
