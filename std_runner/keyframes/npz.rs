//! Array files by their extension: one array in a `.npy`, named ones in a `.npz` (a zip archive).

use std::fs::File;
use std::io::{self, BufReader, Read};
use std::path::Path;

use zip::read::ZipFile;
use zip::result::ZipError;
use zip::{CompressionMethod, ZipArchive};

use super::ending::ends_with;
use super::error::Fault;
use super::npy::{self, Array, Entry, read_array};

/// Reads a `.npy` file, or the array `name` of a `.npz` file.
pub(super) fn read(path: &Path, name: Option<&str>) -> Result<Array, Fault> {
    read_by(path, name, &read_array)
}

/// Reads entry `entry` along the first axis of such an array.
pub(super) fn read_entry(path: &Path, name: Option<&str>, entry: Entry) -> Result<Array, Fault> {
    read_by(path, name, &|reader| npy::read_entry(reader, entry))
}

/// How many entries such an array has along its first axis.
pub(super) fn steps(path: &Path, name: Option<&str>) -> Result<usize, Fault> {
    read_by(path, name, &npy::read_steps)
}

/// How an array is read.
type How<'a, R> = &'a dyn Fn(&mut dyn Read) -> Result<R, Fault>;

fn read_by<R>(path: &Path, name: Option<&str>, read: How<'_, R>) -> Result<R, Fault> {
    let mut file = BufReader::new(File::open(path)?);
    check_ending(path, name)?;
    match name {
        None if ends_with(path, "npy") => read(&mut file),
        None => read_member(file, &sole_name(path)?, read),
        Some(name) => read_member(file, name, read),
    }
}

/// Refuses what is neither a `.npy`, which has no name in it, nor a `.npz`.
pub(super) fn check_ending(path: &Path, name: Option<&str>) -> Result<(), Fault> {
    let one = ends_with(path, "npy");
    if one && name.is_some() {
        Err(Fault::content(
            "is one array, and `name` is given",
            "remove `name`",
        ))
    } else if one || ends_with(path, "npz") {
        Ok(())
    } else if !path.exists() {
        Err(Fault::Read(io::ErrorKind::NotFound.into()))
    } else {
        Err(Fault::content(
            "has an unknown extension",
            "files are .npy, .npz or .vdb, and pictures .png, .jpg, .tif or .webp",
        ))
    }
}

pub(super) fn archive(file: BufReader<File>) -> Result<ZipArchive<BufReader<File>>, Fault> {
    ZipArchive::new(file)
        .map_err(|error| Fault::content(format!("is no .npz ({error})"), "save it by numpy.savez"))
}

/// The names of all arrays.
fn names(archive: &ZipArchive<BufReader<File>>) -> Vec<String> {
    let members = archive.file_names().filter_map(Result::ok);
    members
        .filter(|name| !name.ends_with('/'))
        .map(|name| name.strip_suffix(".npy").unwrap_or(&name).to_owned())
        .collect()
}

/// The name of the only array in the `.npz` at `path`.
pub(super) fn sole_name(path: &Path) -> Result<String, Fault> {
    let names = names(&archive(BufReader::new(File::open(path)?))?);
    match names.as_slice() {
        [name] => Ok(name.clone()),
        [] => Err(Fault::content("holds no array", "save it by numpy.savez")),
        some => Err(Fault::content(
            format!("holds {} arrays", some.len()),
            format!("say which by `name`; there are: {}", some.join(", ")),
        )),
    }
}

/// Which member is the array `name`: NumPy names it with an ending, others do without.
pub(super) fn index_of(archive: &ZipArchive<BufReader<File>>, name: &str) -> Option<usize> {
    archive
        .index_for_name(&format!("{name}.npy"))
        .or_else(|| archive.index_for_name(name))
}

/// What is wrong with the array `name`, whose bytes are not those that were saved.
pub(super) fn damaged(name: &str, error: &dyn core::fmt::Display) -> Fault {
    Fault::content(
        format!("holds an array `{name}` that is damaged ({error})"),
        "copy the file again, or save it again",
    )
}

/// The member of `archive` that is the array `name`.
pub(super) fn member<'a>(
    archive: &'a mut ZipArchive<BufReader<File>>,
    name: &str,
) -> Result<ZipFile<'a, BufReader<File>>, Fault> {
    let Some(index) = index_of(archive, name) else {
        let held = names(archive).join(", ");
        return Err(Fault::content(
            format!("has no array `{name}`"),
            format!("it holds: {held}"),
        ));
    };
    let packing = archive.by_index_raw(index).map(|member| member.compression());
    let unknown = |how: String| {
        Fault::content(
            format!("holds an array `{name}` that is packed in an unknown way ({how})"),
            "save it by numpy.savez or numpy.savez_compressed",
        )
    };
    match packing {
        Ok(CompressionMethod::Stored | CompressionMethod::Deflated) => {}
        Ok(other) => return Err(unknown(other.to_string())),
        Err(error) => return Err(damaged(name, &error)),
    }
    archive.by_index(index).map_err(|error| match error {
        ZipError::UnsupportedArchive(_) | ZipError::CompressionMethodNotSupported(_) => {
            unknown(error.to_string())
        }
        other => damaged(name, &other),
    })
}

/// Reads the array `name` by `read`, and the rest of its member for the sake of the checksum.
fn read_member<R>(file: BufReader<File>, name: &str, read: How<'_, R>) -> Result<R, Fault> {
    let mut archive = archive(file)?;
    let mut member = Watched::new(member(&mut archive, name)?);
    let array = read(&mut member);
    // The checksum is compared at the member's end, which the array's last value need not be.
    let _ = io::copy(&mut member, &mut io::sink());
    match member.failed {
        Some(error) => Err(damaged(name, &error)),
        None => array,
    }
}

/// A reader that remembers how it failed: damage is told before whatever sense the bytes made.
pub(super) struct Watched<R> {
    inner: R,
    pub failed: Option<String>,
}

impl<R> Watched<R> {
    pub fn new(inner: R) -> Self {
        Self { inner, failed: None }
    }
}

impl<R: Read> Read for Watched<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let read = self.inner.read(buffer);
        if let Err(error) = &read
            && error.kind() != io::ErrorKind::Interrupted
        {
            self.failed.get_or_insert_with(|| error.to_string());
        }
        read
    }
}
