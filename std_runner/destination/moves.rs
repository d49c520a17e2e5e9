//! Renames that take the place of nothing and can be taken back.

use std::fs;
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};

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
