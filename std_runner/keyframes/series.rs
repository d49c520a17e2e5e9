//! An array whose first axis is time, read entry by entry: the memory of one, whatever their number.

use core::hash::BuildHasher;
use std::collections::hash_map::RandomState;
use std::fs::{File, OpenOptions};
use std::io::{self, BufReader, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

use super::error::Fault;
use super::header::Header;
use super::npy::{Array, read_values};
use super::{ShapeError, npz};

/// How many random names of a temporary file may be taken.
const ATTEMPTS: usize = 16;

/// An array in a `.npy` file, or one of a `.npz` file.
#[derive(Debug)]
pub struct Series {
    /// The scene's key that names the file, for messages.
    key: String,
    path: PathBuf,
    file: BufReader<File>,
    /// Where the values begin, and bytes of an entry.
    begin: u64,
    size: u64,
    header: Entry,
    count: usize,
    /// Whether it is one number, without an axis.
    is_number: bool,
    /// The copy of a packed array, which is unpacked once, where the system keeps its name as long as it is open.
    _unpacked: Option<Aside>,
}

/// A temporary file that is removed in the end.
#[derive(Debug)]
struct Aside(PathBuf);

impl Aside {
    /// A new one, which nobody else can have put there, and which is gone with its last reader where the system knows files without names.
    fn create() -> io::Result<(File, Option<Self>)> {
        let mut options = OpenOptions::new();
        let options = options.read(true).write(true).create_new(true);
        #[cfg(unix)]
        std::os::unix::fs::OpenOptionsExt::mode(options, 0o600);
        let folder = std::env::temp_dir();
        for _ in 0..ATTEMPTS {
            // The keys of a hasher are random.
            let random = RandomState::new().hash_one(std::process::id());
            let path = folder.join(format!("thurible-{random:016x}.values"));
            match options.open(&path) {
                Ok(file) => {
                    let aside = Self(path);
                    let is_named = std::fs::remove_file(&aside.0).is_err();
                    return Ok((file, is_named.then_some(aside)));
                }
                Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {}
                Err(error) => return Err(error),
            }
        }
        Err(io::ErrorKind::AlreadyExists.into())
    }
}

/// The header of an entry.
struct Entry(Header);

impl core::fmt::Debug for Entry {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_tuple("Entry").field(&self.0.shape).finish()
    }
}

impl Series {
    /// Opens the array `name` of `path`, whose name is that of the file where that is a `.npy`; `key` is the scene's for it.
    ///
    /// # Errors
    /// A file that cannot be read, or has no such array.
    pub fn open(path: &Path, name: Option<&str>, key: &str) -> Result<Self, ShapeError> {
        Self::opened(path, name, key, false).map_err(|fault| fault.of(key, path))
    }

    /// Opens the array `name` of the archive `path`, whatever it is: a number without an axis is one entry.
    ///
    /// # Errors
    /// As [`Self::open`].
    pub(crate) fn open_any(path: &Path, name: &str, key: &str) -> Result<Self, ShapeError> {
        Self::opened(path, Some(name), key, true).map_err(|fault| fault.of(key, path))
    }

    fn opened(path: &Path, name: Option<&str>, key: &str, numbers: bool) -> Result<Self, Fault> {
        let (mut file, header, unpacked) = match name {
            None => {
                let mut file = BufReader::new(File::open(path)?);
                let header = Header::read(&mut file)?;
                (file, header, None)
            }
            Some(name) => member(path, name)?,
        };
        let is_number = numbers && header.shape.is_empty();
        let (header, count) = if is_number { (header, 1) } else { header.entries()? };
        let header = header.without_ones();
        Ok(Self {
            key: key.to_owned(),
            path: path.to_owned(),
            begin: file.stream_position()?,
            size: header.bytes(),
            header: Entry(header),
            file,
            count,
            is_number,
            _unpacked: unpacked,
        })
    }

    /// Entries.
    #[must_use]
    pub fn count(&self) -> usize {
        self.count
    }

    /// Whether it is one number, without an axis.
    pub(crate) fn is_number(&self) -> bool {
        self.is_number
    }

    /// The shape of an entry, x last.
    #[must_use]
    pub fn shape(&self) -> &[usize] {
        &self.header.0.shape
    }

    /// The type of the values as NumPy writes it, in this machine's order of bytes: f4, f8, b1, i8 and the like.
    #[must_use]
    pub fn kind(&self) -> String {
        self.header.0.kind.name()
    }

    /// The file.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Reads an entry, x fastest.
    ///
    /// # Errors
    /// A file that breaks off or cannot be read.
    pub fn read(&mut self, entry: usize) -> Result<Vec<f64>, ShapeError> {
        let read = self.array(entry);
        read.map(|array| array.values)
            .map_err(|fault| fault.of(&self.key, &self.path))
    }

    pub(super) fn array(&mut self, entry: usize) -> Result<Array, Fault> {
        let place = self.begin.saturating_add(self.size.saturating_mul(entry as u64));
        self.file.seek(SeekFrom::Start(place))?;
        read_values(&mut self.file, &self.header.0)
    }
}

impl Drop for Aside {
    fn drop(&mut self) {
        // What is left behind where temporary files go is not what the user must hear of.
        let _ = std::fs::remove_file(&self.0);
    }
}

/// The array `name` of a `.npz`, as a file that stands at its values; those of packed ones are unpacked to a temporary file. Either way it is read
/// through once, for its checksum.
fn member(path: &Path, name: &str) -> Result<(BufReader<File>, Header, Option<Aside>), Fault> {
    let mut archive = npz::archive(BufReader::new(File::open(path)?))?;
    let member = npz::member(&mut archive, name)?;
    if let (zip::CompressionMethod::Stored, Some(begin)) = (member.compression(), member.data_start()) {
        let mut member = member;
        io::copy(&mut member, &mut io::sink()).map_err(|error| npz::damaged(name, &error))?;
        let mut file = BufReader::new(File::open(path)?);
        file.seek(SeekFrom::Start(begin))?;
        let header = Header::read(&mut file)?;
        return Ok((file, header, None));
    }
    let mut member = npz::Watched::new(member);
    let unpacked = unpack(&mut member);
    let _ = io::copy(&mut member, &mut io::sink());
    let failed = member.failed.map(|error| npz::damaged(name, &error));
    failed.map_or(unpacked, Err)
}

/// Reads the header of an array, and copies as many bytes of values as it promises to a temporary file.
fn unpack(member: &mut dyn Read) -> Result<(BufReader<File>, Header, Option<Aside>), Fault> {
    let header = Header::read(member)?;
    let mut copied = || {
        let (mut copy, aside) = Aside::create()?;
        io::copy(&mut member.take(header.bytes()), &mut copy)?;
        copy.rewind()?;
        Ok((copy, aside))
    };
    let (copy, aside) = copied().map_err(|error: io::Error| {
        let folder = std::env::temp_dir();
        let said = format!("it is unpacked to a file in {}: {error}", folder.display());
        io::Error::new(error.kind(), said)
    })?;
    Ok((BufReader::new(copy), header, aside))
}

/// Whether a `.npz` file has an array of this name.
pub(super) fn has(path: &Path, name: &str) -> bool {
    let Ok(file) = File::open(path) else { return false };
    npz::archive(BufReader::new(file)).is_ok_and(|archive| npz::index_of(&archive, name).is_some())
}

/// The names of the arrays of a `.npz` file that hold anything.
///
/// # Errors
/// A file that cannot be read; `key` names it.
pub(crate) fn array_names(path: &Path, key: &str) -> Result<Vec<String>, ShapeError> {
    let names = || -> Result<Vec<String>, Fault> {
        let mut archive = npz::archive(BufReader::new(File::open(path)?))?;
        let members = archive.file_names().filter_map(Result::ok);
        let all: Vec<String> = members
            .filter_map(|name| Some(name.strip_suffix(".npy")?.to_owned()))
            .collect();
        let mut held = Vec::new();
        for name in all {
            let shape = Header::read(&mut npz::member(&mut archive, &name)?)?.shape;
            if !shape.contains(&0) {
                held.push(name);
            }
        }
        Ok(held)
    };
    names().map_err(|fault| fault.of(key, path))
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use std::io::Write;

    #[test]
    fn a_packed_array_whose_name_is_a_path_is_read() {
        let path = std::env::temp_dir().join(format!("thurible-test-{}-series.npz", std::process::id()));
        let mut archive = zip::ZipWriter::new(File::create(&path).unwrap());
        let packed =
            zip::write::SimpleFileOptions::default().compression_method(zip::CompressionMethod::Deflated);
        archive.start_file("group/values.npy", packed).unwrap();
        let header = "{'descr': '<f8', 'fortran_order': False, 'shape': (2,), }\n";
        archive.write_all(b"\x93NUMPY\x01\x00").unwrap();
        archive.write_all(&(header.len() as u16).to_le_bytes()).unwrap();
        archive.write_all(header.as_bytes()).unwrap();
        for value in [1.5_f64, 2.5] {
            archive.write_all(&value.to_le_bytes()).unwrap();
        }
        archive.finish().unwrap();
        let mut series = Series::open(&path, Some("group/values"), "frames").unwrap();
        #[cfg(unix)]
        {
            let unpacked = series.file.get_ref().metadata().unwrap();
            let names = std::os::unix::fs::MetadataExt::nlink(&unpacked);
            assert_eq!(
                names, 0,
                "what it is unpacked to has a name, which a kill would leave"
            );
        }
        assert_eq!(series.read(1).unwrap(), [2.5]);
        std::fs::remove_file(&path).unwrap();
    }
}
