//! Renames that take the place of nothing and can be taken back.

use super::written::stays_inside;
use crate::output::{OutputError, sync_file, sync_folder, write_bytes};
use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;
use std::fs;
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};

/// Which files of the earlier result go and which new ones come, written down before the first is moved, so that the next run can bring it to
/// an end if this one is killed.
#[derive(Debug, Serialize, Deserialize)]
pub(super) struct Plan {
    pub gone: BTreeSet<PathBuf>,
    pub new: Vec<PathBuf>,
}

impl Plan {
    /// Its name in a hidden folder.
    pub const NAME: &str = "moves.json";

    /// Writes it down, on the disc before anything is moved.
    pub fn write(&self, hidden: &Path) -> Result<(), OutputError> {
        let path = hidden.join(Self::NAME);
        let text = serde_json::to_vec(self).map_err(OutputError::of(&path))?;
        write_bytes(&path, &text)?;
        sync_file(&path)
            .and_then(|()| sync_folder(hidden))
            .map_err(OutputError::of(&path))
    }

    /// The one of a folder that was left behind, if anything was going to be moved.
    pub fn read(hidden: &Path) -> io::Result<Option<Self>> {
        let text = match fs::read(hidden.join(Self::NAME)) {
            Err(error) if error.kind() == ErrorKind::NotFound => return Ok(None),
            read => read?,
        };
        let plan = serde_json::from_slice(&text).ok();
        let inside = |plan: &Self| plan.gone.iter().chain(&plan.new).all(|file| stays_inside(file));
        Ok(plan.filter(inside))
    }

    /// Tears it up, on the disc before anything else of the folder is removed: by what is left of the folder then it would move too much.
    pub fn forget(hidden: &Path) -> io::Result<()> {
        match fs::remove_file(hidden.join(Self::NAME)) {
            Err(error) if error.kind() == ErrorKind::NotFound => Ok(()),
            removed => removed.and_then(|()| sync_folder(hidden)),
        }
    }
}

/// What has been moved and made so far.
#[derive(Debug, Default)]
pub(super) struct Moves {
    renamed: Vec<(PathBuf, PathBuf)>,
    made: Vec<PathBuf>,
}

impl Moves {
    /// Moves the file `file` from below `from` to below `to`, where nothing of that name may be, and makes the folders that it needs.
    pub(super) fn carry(&mut self, file: &Path, from: &Path, to: &Path) -> io::Result<()> {
        let mut folders: Vec<&Path> = file.ancestors().skip(1).collect();
        folders.reverse();
        for folder in folders {
            match fs::create_dir(to.join(folder)) {
                Ok(()) => self.made.push(to.join(folder)),
                Err(error) if error.kind() == ErrorKind::AlreadyExists => {}
                Err(error) => return Err(error),
            }
        }
        let (from, to) = (from.join(file), to.join(file));
        if fs::symlink_metadata(&to).is_ok() {
            return Err(ErrorKind::AlreadyExists.into());
        }
        fs::rename(&from, &to)?;
        self.renamed.push((from, to));
        Ok(())
    }

    /// Takes everything back; false if a file could not be.
    pub(super) fn undo(self) -> bool {
        let mut back = true;
        for (from, to) in self.renamed.iter().rev() {
            back &= fs::rename(to, from).is_ok();
        }
        for folder in self.made.iter().rev() {
            // Empty, but for what a user put there meanwhile.
            let _ = fs::remove_dir(folder);
        }
        back
    }
}

/// Makes sure that `files` below `folder` are on the disc, with what they hold.
pub(super) fn sync_files(folder: &Path, files: &[PathBuf]) -> Result<(), (PathBuf, io::Error)> {
    let at = |path: &Path| {
        let path = path.to_path_buf();
        move |error| (path, error)
    };
    files
        .iter()
        .try_for_each(|file| sync_file(&folder.join(file)).map_err(at(file)))?;
    sync_folders(folder, files)
}

/// Makes sure that `files` below `folder` stay where they are.
pub(super) fn sync_folders<'a>(
    folder: &Path,
    files: impl IntoIterator<Item = &'a PathBuf>,
) -> Result<(), (PathBuf, io::Error)> {
    let folders: BTreeSet<&Path> = files
        .into_iter()
        .flat_map(|file| file.ancestors().skip(1))
        .collect();
    let there = folders.into_iter().filter(|below| folder.join(below).is_dir());
    there
        .into_iter()
        .try_for_each(|below| sync_folder(&folder.join(below)).map_err(|error| (below.to_path_buf(), error)))
}

/// The files below `folder`, relative to it.
pub(super) fn files_below(folder: &Path) -> io::Result<Vec<PathBuf>> {
    let (mut files, mut folders) = (Vec::new(), vec![PathBuf::new()]);
    while let Some(below) = folders.pop() {
        for entry in fs::read_dir(folder.join(&below))? {
            let entry = entry?;
            let list = if entry.file_type()?.is_dir() {
                &mut folders
            } else {
                &mut files
            };
            list.push(below.join(entry.file_name()));
        }
    }
    Ok(files)
}
