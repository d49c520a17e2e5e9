//! Archives of arrays that come entry by entry, as bytes of any type.

use std::io::Write;
use std::path::Path;

use zip::ZipWriter;

use super::OutputError;
use super::archive::{header, stored};
use super::file::write_whole;

/// An array that is going to be written.
pub(crate) struct Streamed {
    pub name: String,
    /// The type of its values as NumPy names it, `<f4`.
    pub kind: String,
    /// Entries, and the shape of one, x last.
    pub count: usize,
    pub shape: Vec<usize>,
}

/// Writes `path` from `arrays`; `entry` gives the bytes of an entry of one, by their numbers.
pub(crate) fn write_streamed(
    path: &Path,
    arrays: &[Streamed],
    entry: &mut dyn FnMut(usize, usize) -> Result<Vec<u8>, OutputError>,
) -> Result<(), OutputError> {
    write_whole(path, |file| {
        let mut zip = ZipWriter::new(file);
        let mut put = || -> Result<(), OutputError> {
            for (number, array) in arrays.iter().enumerate() {
                let begun = zip.start_file(format!("{}.npy", array.name), stored());
                begun.map_err(OutputError::of(path))?;
                let shape = [&[array.count], array.shape.as_slice()].concat();
                let head = zip.write_all(&header(&array.kind, &shape));
                head.map_err(OutputError::of(path))?;
                for index in 0..array.count {
                    zip.write_all(&entry(number, index)?)
                        .map_err(OutputError::of(path))?;
                }
            }
            Ok(())
        };
        if let Err(error) = put() {
            // Dropped, it would try to end the file and print what it thinks of the attempt.
            core::mem::forget(zip);
            return Err(error);
        }
        zip.finish().map_err(OutputError::of(path))?;
        Ok(())
    })
}
