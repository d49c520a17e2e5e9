//! The result folder: checked before the solve, filled aside and moved in place when it is whole.

use crate::exit::Failure;
use std::ffi::{OsStr, OsString};
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

/// What a result folder holds; anything else in it belongs to the user and stays.
const OURS: [&str; 6] = [
    "result.npz",
    "report.json",
    "report.html",
    "frames",
    "animation.png",
    "animation.gif",
];

/// A folder that a result may be written to.
#[derive(Clone, Debug)]
pub struct Destination {
    folder: PathBuf,
    exists: bool,
}

impl Destination {
    /// Refuses a path that is a file, a folder of something else, or one that cannot be written.
    pub fn check(folder: &Path) -> Result<Self, Failure> {
        Self::check_for(folder, "report.json")
    }

    /// As [`Self::check`], where the JSON file `mark` tells that a folder holds a result.
    pub fn check_for(folder: &Path, mark: &str) -> Result<Self, Failure> {
        let shown = folder.display();
        let cannot = |error: io::Error| {
            Failure::File(format!(
                "cannot write the result folder {shown}: {error}; choose another one with -o DIR"
            ))
        };
        let exists = match fs::metadata(folder) {
            Ok(found) if found.is_dir() => true,
            Ok(_) => {
                return Err(Failure::File(format!(
                    "the result folder {shown} is a file; choose another one with -o DIR"
                )));
            }
            Err(error) if error.kind() == io::ErrorKind::NotFound => false,
            Err(error) => return Err(cannot(error)),
        };
        if exists && !is_empty(folder).map_err(cannot)? && !is_result(folder, mark) {
            let why = "is not empty and holds no result of thurible, so it is not overwritten; empty it or choose another one with -o DIR";
            return Err(Failure::File(format!("the folder {shown} {why}")));
        }
        let destination = Destination {
            folder: folder.to_path_buf(),
            exists,
        };
        let probe = destination.aside("probe");
        fs::create_dir_all(&probe)
            .and_then(|()| fs::remove_dir(&probe))
            .map_err(cannot)?;
        Ok(destination)
    }

    /// Calls `write` with an empty folder aside; if that goes well, moves what it wrote in the place of an earlier result.
    pub fn fill(&self, write: impl FnOnce(&Path) -> Result<(), Failure>) -> Result<(), Failure> {
        self.staged(&OURS, write)
    }

    /// Calls `write` with an empty folder aside; if that goes well, adds what it wrote to the result.
    pub fn add<R>(&self, write: impl FnOnce(&Path) -> Result<R, Failure>) -> Result<R, Failure> {
        self.staged(&[], write)
    }

    fn staged<R>(
        &self,
        replaced: &[&str],
        write: impl FnOnce(&Path) -> Result<R, Failure>,
    ) -> Result<R, Failure> {
        let shown = self.folder.display();
        let cannot = |error: io::Error| {
            Failure::File(format!(
                "cannot write the result folder {shown}: {error}; free some space or choose another one with -o DIR"
            ))
        };
        let staging = self.aside("new");
        let fresh = staging.join(self.folder.file_name().unwrap_or(OsStr::new("out")));
        fs::create_dir_all(&fresh).map_err(cannot)?;
        let done =
            write(&fresh).and_then(|answer| self.move_in(&fresh, replaced).map(|()| answer).map_err(cannot));
        // The failure itself is what the user must hear; a folder left behind is not.
        let _ = fs::remove_dir_all(&staging);
        done
    }

    fn move_in(&self, fresh: &Path, replaced: &[&str]) -> io::Result<()> {
        if !self.folder.exists() {
            return fs::rename(fresh, &self.folder);
        }
        let old = self.aside("old");
        fs::create_dir_all(&old)?;
        for name in names(&self.folder)? {
            if fresh.join(&name).exists() || replaced.iter().any(|ours| name == *ours) {
                fs::rename(self.folder.join(&name), old.join(&name))?;
            }
        }
        for name in names(fresh)? {
            fs::rename(fresh.join(&name), self.folder.join(&name))?;
        }
        fs::remove_dir_all(old)
    }

    /// A hidden folder on the same file system: inside an existing result folder, else beside it.
    fn aside(&self, purpose: &str) -> PathBuf {
        let mark = format!("thurible-{purpose}-{}", std::process::id());
        if self.exists {
            return self.folder.join(format!(".{mark}"));
        }
        let mut name = OsString::from(".");
        name.push(self.folder.file_name().unwrap_or(OsStr::new("out")));
        name.push(format!(".{mark}"));
        self.folder.with_file_name(name)
    }
}

fn names(folder: &Path) -> io::Result<Vec<OsString>> {
    fs::read_dir(folder)?
        .map(|entry| entry.map(|entry| entry.file_name()))
        .collect()
}

fn is_empty(folder: &Path) -> io::Result<bool> {
    Ok(fs::read_dir(folder)?.next().is_none())
}

fn is_result(folder: &Path, mark: &str) -> bool {
    let report = fs::read_to_string(folder.join(mark)).unwrap_or_default();
    serde_json::from_str::<serde_json::Value>(&report).is_ok_and(|report| report.get("format").is_some())
}
