//! A hidden folder on the file system of a result, where it is written before it is moved in place.

use super::moves::Plan;
use crate::held::{self, hold};
use std::ffi::{OsStr, OsString};
use std::fs::{self, File};
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};
use thurible_core::checkpoint::Mix;

/// What their names have after a point, and after that the purpose and the process.
pub(super) const MARK: &str = "thurible-";

/// Hidden folders of one name that earlier runs may have left behind.
const LEFT_BEHIND: usize = 100;

/// Bytes of a name to which there is room for the rest of a hidden name, of 255 in all.
const LONG: usize = 200;

/// What the names of hidden folders beside `folder` begin with, before [`MARK`]. Of a long name they have a part, and a sum of all of it.
pub(super) fn beside(folder: &Path) -> OsString {
    let name = folder.file_name().unwrap_or(OsStr::new("out"));
    let mut hidden = OsString::from(".");
    if name.len() <= LONG {
        hidden.push(name);
    } else {
        let (text, mut sum) = (name.to_string_lossy(), Mix::new());
        sum.bytes(name.as_encoded_bytes());
        let part = text.get(..text.floor_char_boundary(LONG / 2)).unwrap_or("");
        hidden.push(format!("{part}-{:016x}", sum.finish()));
    }
    hidden.push(".");
    hidden
}

/// A folder that is removed with all that is left in it.
#[derive(Debug)]
pub(super) struct Staging {
    path: PathBuf,
    kept: bool,
    /// Held as long as this run lives, so that later ones know what is left behind; on a full disc there may be none.
    _lock: Option<File>,
}

impl Staging {
    /// Inside `folder` if that is there, else beside it.
    pub(super) fn new(folder: &Path, purpose: &str) -> io::Result<Self> {
        let mark = format!("{MARK}{purpose}-{}", std::process::id());
        let (parent, name) = if folder.is_dir() {
            (folder, OsString::from(format!(".{mark}")))
        } else {
            let mut name = beside(folder);
            name.push(mark);
            (folder.parent().unwrap_or(folder), name)
        };
        for attempt in 0..LEFT_BEHIND {
            let mut name = name.clone();
            if attempt > 0 {
                name.push(format!(".{attempt}"));
            }
            let path = parent.join(name);
            match fs::create_dir(&path) {
                Ok(()) => match hold(&path) {
                    // Another run took it for one that was left behind.
                    Err(error) if error.kind() == ErrorKind::NotFound => {}
                    held => {
                        return Ok(Self {
                            path,
                            kept: false,
                            _lock: held.ok().flatten(),
                        });
                    }
                },
                Err(error) if error.kind() == ErrorKind::AlreadyExists => {}
                Err(error) => return Err(error),
            }
        }
        Err(ErrorKind::AlreadyExists.into())
    }

    /// A folder in it that is not there yet.
    pub(super) fn below(&self, name: &str) -> PathBuf {
        self.path.join(name)
    }

    /// Leaves it behind: the next run brings to an end what could not be put back.
    pub(super) fn keep(&mut self) {
        self.kept = true;
    }
}

impl Drop for Staging {
    fn drop(&mut self) {
        if !self.kept {
            // A folder that is left behind is not what the user must hear of.
            let _ = remove(&self.path);
        }
    }
}

/// Removes such a folder with all that is in it, what was going to be moved first.
pub(super) fn remove(hidden: &Path) -> io::Result<()> {
    Plan::forget(hidden)?;
    held::remove(hidden)
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    /// A plan without the files that it names would take those of a whole result away.
    #[test]
    fn nothing_is_removed_before_the_plan_of_its_moves() {
        let folder = std::env::temp_dir().join(format!("thurible-staging-{}", std::process::id()));
        fs::create_dir_all(folder.join("old")).unwrap();
        fs::write(folder.join("old/report.json"), "{}").unwrap();
        // One that cannot be removed.
        fs::create_dir_all(folder.join(Plan::NAME).join("below")).unwrap();
        assert!(remove(&folder).is_err() && folder.join("old/report.json").is_file());
        fs::remove_dir_all(folder.join(Plan::NAME)).unwrap();
        fs::write(folder.join(Plan::NAME), "{}").unwrap();
        remove(&folder).unwrap();
        assert!(!folder.exists());
    }
}
