//! The frame of every archive of NumPy's arrays: whole or not there, members stored as they are.

use super::OutputError;
use super::file::write_whole;
use super::quiet::Quiet;
use std::io::{self, Write};
use std::path::Path;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipWriter};

/// An archive that is being written.
pub(crate) struct Npz<'a> {
    zip: ZipWriter<Quiet<'a>>,
    path: &'a Path,
}

/// Writes the archive `path`; `fill` begins its arrays and gives their values.
pub(crate) fn write_npz(
    path: &Path,
    fill: impl FnOnce(&mut Npz<'_>) -> Result<(), OutputError>,
) -> Result<(), OutputError> {
    write_whole(path, |file| {
        let zip = ZipWriter::new(Quiet::new(file));
        let mut npz = Npz { zip, path };
        if let Err(error) = fill(&mut npz) {
            // Dropped, it would try to end a file that is in the middle of an array.
            core::mem::forget(npz.zip);
            return Err(error);
        }
        npz.zip.finish().map_err(OutputError::of(path))?;
        Ok(())
    })
}

impl Npz<'_> {
    /// Begins an array of values of a type as NumPy names it, `<f4`; its values come next, x fastest.
    pub fn begin(&mut self, name: &str, kind: &str, shape: &[usize]) -> Result<(), OutputError> {
        let stored = SimpleFileOptions::default()
            .compression_method(CompressionMethod::Stored)
            .large_file(true);
        let begun = self.zip.start_file(format!("{name}.npy"), stored);
        begun.map_err(OutputError::of(self.path))?;
        self.put(|zip| zip.write_all(&header(kind, shape)))
    }

    /// Lets `write` write what comes next of the array.
    pub fn put<R>(&mut self, write: impl FnOnce(&mut dyn Write) -> io::Result<R>) -> Result<R, OutputError> {
        write(&mut self.zip).map_err(OutputError::of(self.path))
    }
}

/// The head of a `.npy` file: magic, length, a Python dictionary padded to a multiple of 64 bytes.
fn header(kind: &str, shape: &[usize]) -> Vec<u8> {
    let sides: String = shape.iter().map(|side| format!("{side}, ")).collect();
    let mut text = format!(
        "{{'descr': '{kind}', 'fortran_order': False, 'shape': ({}), }}",
        sides.trim_end()
    );
    while (10 + text.len() + 1) % 64 != 0 {
        text.push(' ');
    }
    text.push('\n');
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend((text.len() as u16).to_le_bytes());
    bytes.extend(text.as_bytes());
    bytes
}
