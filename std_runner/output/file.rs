//! Files that are whole or not there: written under a temporary name, then renamed.

use std::fs::{self, File, OpenOptions};
use std::io::{self, BufWriter, ErrorKind, Write};
use std::path::{Path, PathBuf};

use super::OutputError;

/// Creates a folder and its parents.
pub(crate) fn create_folder(path: &Path) -> Result<(), OutputError> {
    fs::create_dir_all(path).map_err(OutputError::of(path))
}

/// Writes a whole file.
pub(crate) fn write_bytes(path: &Path, bytes: &[u8]) -> Result<(), OutputError> {
    write_whole(path, |file| file.write_all(bytes).map_err(OutputError::of(path)))
}

/// Lets `fill` write a file under a temporary name, and renames it when all of it is there. A device or a pipe takes it as it comes: a file
/// would stand in its place.
pub(crate) fn write_whole(
    path: &Path,
    fill: impl FnOnce(&mut BufWriter<File>) -> Result<(), OutputError>,
) -> Result<(), OutputError> {
    let write = |file: File| {
        let mut file = BufWriter::new(file);
        fill(&mut file)?;
        file.flush().map_err(OutputError::of(path))
    };
    if fs::metadata(path).is_ok_and(|there| !there.is_file() && !there.is_dir()) {
        let opened = OpenOptions::new().write(true).open(path);
        return opened.map_err(OutputError::of(path)).and_then(write);
    }
    let part = temporary(path);
    let filled = File::create(&part).map_err(OutputError::of(path)).and_then(write);
    let renamed = filled.and_then(|()| fs::rename(&part, path).map_err(OutputError::of(path)));
    if renamed.is_err() {
        // What is left is of no use, and the first error says more than a second one would.
        let _ = fs::remove_file(&part);
    }
    renamed
}

/// Makes sure that a file that was written is on the disc.
pub(crate) fn sync_file(path: &Path) -> io::Result<()> {
    // Some systems sync only what may be written to.
    OpenOptions::new().read(true).write(true).open(path)?.sync_all()
}

/// Makes sure that what was made or renamed in a folder stays so; where a system knows no such thing, or lets nobody ask, it need not.
pub(crate) fn sync_folder(folder: &Path) -> io::Result<()> {
    if !cfg!(unix) {
        return Ok(());
    }
    let synced = match File::open(folder) {
        Err(error) if error.kind() == ErrorKind::PermissionDenied => return Ok(()),
        opened => opened.and_then(|folder| folder.sync_all()),
    };
    match synced {
        Err(error) if matches!(error.kind(), ErrorKind::InvalidInput | ErrorKind::Unsupported) => Ok(()),
        synced => synced,
    }
}

fn temporary(path: &Path) -> PathBuf {
    let mut name = path.file_name().unwrap_or_default().to_owned();
    name.push(".part");
    path.with_file_name(name)
}

#[cfg(all(test, unix))]
#[expect(clippy::unwrap_used, reason = "a test")]
mod tests {
    use super::*;

    #[test]
    fn a_device_stays_where_it_is() {
        let folder = std::env::temp_dir().join(format!("thurible-device-{}", std::process::id()));
        create_folder(&folder).unwrap();
        let device = folder.join("null");
        std::os::unix::fs::symlink("/dev/null", &device).unwrap();
        write_bytes(&device, b"nothing stays of it").unwrap();
        assert!(device.is_symlink() && !device.is_file());
        assert_eq!(fs::read_dir(&folder).unwrap().count(), 1);
        fs::remove_dir_all(&folder).unwrap();
    }
}
