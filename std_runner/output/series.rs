//! Fields of one size in a file that grows, to be read back in any order: what memory has no room for.

use super::archive::push;
use super::{OutputError, Precision, Samples};
use std::fs::{File, OpenOptions};
use std::io::{self, BufReader, BufWriter, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

/// A file of fields.
pub(crate) struct Series {
    path: PathBuf,
    file: File,
    /// Numbers of a field; known from the first one on.
    len: usize,
    /// How many there are.
    count: usize,
}

impl Series {
    /// An empty one at `path`.
    pub fn create(path: &Path) -> Result<Self, OutputError> {
        let mut options = OpenOptions::new();
        let options = options.read(true).write(true).create(true).truncate(true);
        Ok(Self {
            path: path.to_owned(),
            file: options.open(path).map_err(OutputError::of(path))?,
            len: 0,
            count: 0,
        })
    }

    /// How many fields there are.
    pub fn count(&self) -> usize {
        self.count
    }

    /// Takes all fields out.
    pub fn clear(&mut self) -> Result<(), OutputError> {
        self.count = 0;
        self.file.set_len(0).map_err(OutputError::of(&self.path))
    }

    /// Adds a field, which has as many numbers as those before.
    pub fn append(&mut self, field: &Samples) -> Result<(), OutputError> {
        self.len = field.len();
        let place = (self.count * self.len * bytes_of(field)) as u64;
        let write = || -> io::Result<()> {
            let mut file = &self.file;
            file.seek(SeekFrom::Start(place))?;
            let mut file = BufWriter::new(file);
            match field {
                Samples::F32(values) => push(&mut file, values, f32::to_le_bytes),
                Samples::F64(values) => push(&mut file, values, f64::to_le_bytes),
            }?;
            file.flush()
        };
        write().map_err(OutputError::of(&self.path))?;
        self.count += 1;
        Ok(())
    }

    /// `out` becomes field `index`, in the precision that `out` has.
    pub fn read(&self, index: usize, out: &mut Samples) -> Result<(), OutputError> {
        let place = (index * self.len * bytes_of(out)) as u64;
        let mut read = || -> io::Result<()> {
            let mut file = &self.file;
            file.seek(SeekFrom::Start(place))?;
            let mut file = BufReader::new(file);
            match out {
                Samples::F32(values) => pull(&mut file, self.len, values, f32::from_le_bytes),
                Samples::F64(values) => pull(&mut file, self.len, values, f64::from_le_bytes),
            }
        };
        read().map_err(OutputError::unread(&self.path))
    }
}

/// Bytes of a number.
fn bytes_of(samples: &Samples) -> usize {
    match samples.precision() {
        Precision::F32 => size_of::<f32>(),
        Precision::F64 => size_of::<f64>(),
    }
}

/// `values` become the next `count` numbers.
fn pull<T, const N: usize>(
    source: &mut impl Read,
    count: usize,
    values: &mut Vec<T>,
    number: impl Fn([u8; N]) -> T,
) -> io::Result<()> {
    values.clear();
    values.reserve_exact(count);
    let mut bytes = [0; N];
    for _ in 0..count {
        source.read_exact(&mut bytes)?;
        values.push(number(bytes));
    }
    Ok(())
}
