//! A folder that a run holds: as long as it lives, a file in it is locked, on network discs too. A lock ends with its process, however
//! that ends.

use core::time::Duration;
use std::fs::{self, File, OpenOptions, TryLockError};
use std::io;
use std::path::Path;
use std::time::SystemTime;

/// The file that is locked.
pub(crate) const LOCK: &str = "lock";

/// A folder without a lock in it, which another run has just made or an older version left behind, is nobody's after this long.
const NOBODYS: Duration = Duration::from_secs(3600);

/// Holds `folder` until what is returned is dropped; `None` if another run holds it.
pub(crate) fn hold(folder: &Path) -> io::Result<Option<File>> {
    let mut options = OpenOptions::new();
    let options = options.read(true).write(true).create(true).truncate(false);
    let file = options.open(folder.join(LOCK))?;
    match file.try_lock() {
        Ok(()) => Ok(Some(file)),
        Err(TryLockError::WouldBlock) => Ok(None),
        // Where a disc knows no locks, nobody can be asked.
        Err(TryLockError::Error(_)) => Ok(Some(file)),
    }
}

/// Removes `folder` with all that is in it. The lock goes last, so that what is left by a run that is killed meanwhile is known as such.
pub(crate) fn remove(folder: &Path) -> io::Result<()> {
    for entry in fs::read_dir(folder)? {
        let entry = entry?;
        if entry.file_type()?.is_dir() {
            fs::remove_dir_all(entry.path())?;
        } else if entry.file_name() != LOCK {
            fs::remove_file(entry.path())?;
        }
    }
    match fs::remove_file(folder.join(LOCK)) {
        Err(error) if error.kind() != io::ErrorKind::NotFound => Err(error),
        _ => fs::remove_dir(folder),
    }
}

/// Whether the run that made `folder` is no more. Where that cannot be known it is not.
pub(crate) fn is_left_behind(folder: &Path) -> bool {
    match OpenOptions::new().read(true).write(true).open(folder.join(LOCK)) {
        Ok(file) => file.try_lock().is_ok(),
        Err(error) if error.kind() == io::ErrorKind::NotFound => {
            let made = fs::metadata(folder).and_then(|found| found.modified());
            made.is_ok_and(|made| {
                SystemTime::now()
                    .duration_since(made)
                    .is_ok_and(|age| age > NOBODYS)
            })
        }
        Err(_) => false,
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    #[test]
    fn a_folder_is_held_once_and_left_when_its_holder_is_gone() {
        let folder = std::env::temp_dir().join(format!("thurible-held-{}", std::process::id()));
        fs::create_dir_all(&folder).unwrap();
        assert!(!is_left_behind(&folder), "nobody can know this yet");
        let held = hold(&folder).unwrap();
        assert!(held.is_some());
        assert!(hold(&folder).unwrap().is_none() && !is_left_behind(&folder));
        drop(held);
        assert!(is_left_behind(&folder));
        fs::create_dir(folder.join("below")).unwrap();
        remove(&folder).unwrap();
        assert!(!folder.exists());
    }
}
