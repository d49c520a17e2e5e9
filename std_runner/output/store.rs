//! Arrays that grow entry by entry, each in a file of its own, and are packed in the end.

use super::archive::{Packed, pack_archive};
use super::{OutputError, Precision};
use crate::destination::{Aside, Destination};
use crate::exit::Failure;
use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};
use thurible_core::Real;

/// Values that are turned into bytes together.
const TOGETHER: usize = 512;

/// An array.
struct Growing {
    name: String,
    /// Of an entry, x last.
    shape: Vec<usize>,
    /// Whether there is one entry, and no axis for it.
    single: bool,
    path: PathBuf,
    file: BufWriter<File>,
}

/// The arrays of a result, in a hidden folder until they are packed.
pub(crate) struct Store {
    aside: Aside,
    arrays: Vec<Growing>,
}

impl Store {
    /// No arrays yet.
    pub fn new(destination: &Destination) -> Result<Self, Failure> {
        Ok(Self {
            aside: destination.aside()?,
            arrays: Vec::new(),
        })
    }

    /// Begins an array; its number.
    pub fn begin(&mut self, name: &str, shape: Vec<usize>) -> Result<usize, Failure> {
        self.begin_array(name, shape, false)
    }

    /// Adds an array that does not grow.
    pub fn put<T: Real>(&mut self, name: &str, shape: Vec<usize>, values: &[T]) -> Result<(), Failure> {
        let array = self.begin_array(name, shape, true)?;
        self.push(array, values)
    }

    fn begin_array(&mut self, name: &str, shape: Vec<usize>, single: bool) -> Result<usize, Failure> {
        let path = self.aside.file(name);
        let file = File::create(&path).map_err(|error| failed(&path, error))?;
        self.arrays.push(Growing {
            name: name.to_owned(),
            shape,
            single,
            path,
            file: BufWriter::new(file),
        });
        Ok(self.arrays.len() - 1)
    }

    /// Adds an entry to an array.
    pub fn push<T: Real>(&mut self, array: usize, values: &[T]) -> Result<(), Failure> {
        let Some(growing) = self.arrays.get_mut(array) else {
            return Ok(());
        };
        let mut bytes = [0; 8 * TOGETHER];
        for chunk in values.chunks(TOGETHER) {
            let places = bytes.chunks_exact_mut(T::BYTES);
            places.zip(chunk).for_each(|(place, value)| value.write(place));
            let written = bytes.get(..chunk.len() * T::BYTES).unwrap_or(&[]);
            growing
                .file
                .write_all(written)
                .map_err(|error| failed(&growing.path, error))?;
        }
        Ok(())
    }

    /// Leaves out the arrays whose names begin so; nothing is pushed afterwards.
    pub fn leave_out(&mut self, begins: &str) {
        self.arrays.retain(|array| !array.name.starts_with(begins));
    }

    /// Writes everything to disc.
    pub fn flush(&mut self) -> Result<(), Failure> {
        self.arrays
            .iter_mut()
            .try_for_each(|array| array.file.flush().map_err(|error| failed(&array.path, error)))
    }

    /// Writes `path` with the first entries of every array: `count` says how many by its name.
    pub fn pack(
        &self,
        path: &Path,
        precision: Precision,
        count: impl Fn(&str) -> usize,
    ) -> Result<(), OutputError> {
        let packed = self.arrays.iter().map(|array| Packed {
            count: (!array.single).then(|| count(&array.name)),
            name: &array.name,
            shape: &array.shape,
            values: &array.path,
        });
        let arrays: Vec<Packed<'_>> = packed.collect();
        pack_archive(path, precision, &arrays)
    }
}

fn failed(path: &Path, error: std::io::Error) -> Failure {
    Failure::File(OutputError::of(path)(error).to_string())
}
