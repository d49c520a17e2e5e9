//! Fields of one size in a file that grows, to be read back in any order: what memory has no room for.

use super::archive::push;
use super::{OutputError, Precision, Samples};
use std::fs::{File, OpenOptions};
use std::io::{self, BufReader, BufWriter, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use thurible_core::checkpoint::Mix;

/// A file of fields.
pub(crate) struct Series {
    path: PathBuf,
    file: File,
    /// Numbers of a field; known from the first one on.
    len: usize,
    /// How many there are.
    count: usize,
    /// All their bits mixed into one word.
    digest: u64,
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
            digest: 0,
        })
    }

    /// The one at `path` as it was when it held `count` fields of `len` numbers with this `digest`; what came after them is taken out.
    /// `None` if it is not what it was.
    pub fn go_on(
        path: &Path,
        (len, count, digest): (usize, usize, u64),
        samples: &mut Samples,
    ) -> Result<Option<Self>, OutputError> {
        let unread = OutputError::unread(path);
        let file = OpenOptions::new().read(true).write(true).open(path);
        let file = file.map_err(&unread)?;
        let bytes = (count as u64)
            .saturating_mul(len as u64)
            .saturating_mul(bytes_of(samples) as u64);
        // Fields of nothing would have no end.
        if file.metadata().map_err(&unread)?.len() < bytes || (len == 0 && count > 0) {
            return Ok(None);
        }
        file.set_len(bytes).map_err(OutputError::of(path))?;
        let mut series = Self {
            path: path.to_owned(),
            file,
            len,
            count,
            digest: 0,
        };
        for index in 0..count {
            series.read(index, samples)?;
            series.digest = mixed(series.digest, samples);
        }
        Ok((series.digest == digest).then_some(series))
    }

    /// Numbers of a field, how many fields there are, and all their bits mixed into one word.
    pub fn state(&self) -> (usize, usize, u64) {
        (self.len, self.count, self.digest)
    }

    /// Makes sure that all of it is on the disc.
    pub fn sync(&self) -> io::Result<()> {
        self.file.sync_data()
    }

    /// How many fields there are.
    pub fn count(&self) -> usize {
        self.count
    }

    /// Takes all fields out.
    pub fn clear(&mut self) -> Result<(), OutputError> {
        (self.count, self.digest) = (0, 0);
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
        self.digest = mixed(self.digest, field);
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

/// The bits of a field mixed into those before.
fn mixed(before: u64, field: &Samples) -> u64 {
    let mut mix = Mix::new();
    mix.word(before);
    match field {
        Samples::F32(values) => values
            .iter()
            .for_each(|value| mix.word(u64::from(value.to_bits()))),
        Samples::F64(values) => values.iter().for_each(|value| mix.word(value.to_bits())),
    }
    mix.finish()
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
