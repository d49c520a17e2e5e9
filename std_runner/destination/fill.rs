//! Writing to a [`Destination`]: aside first, then in place, or elsewhere.

use super::Destination;
use super::moves::{Moves, Plan, files_below, sync_files, sync_folders};
use super::staging::Staging;
use super::written::{MANIFEST, Written, is_of_ours, manifest_of};
use crate::exit::Failure;
use crate::output::{OutputError, create_folder, sync_folder, write_bytes};
use std::collections::BTreeSet;
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};
use std::{env, fs};

/// The remedy where no folder could be written to.
pub(crate) const RUN_AGAIN: &str = "free some space and run it again";

/// Why files could not be put into a folder.
enum Trouble {
    /// The user has something at this path of the folder.
    InTheWay(PathBuf),
    /// The system refused to write this path of the folder.
    Refused(PathBuf, io::Error),
    /// Another folder would not help.
    Other(OutputError),
}

impl Destination {
    /// Calls `write` with an empty folder aside and moves what it wrote in the place of an earlier result. Where that cannot be, all of
    /// it is done in another folder.
    ///
    /// # Errors
    /// No folder could be written to.
    pub fn fill(&mut self, mut write: impl FnMut(&Path) -> Result<(), OutputError>) -> Result<(), Failure> {
        let trouble = match self.attempt(&|_| false, &mut write) {
            Ok(()) => return Ok(()),
            Err(Trouble::Other(error)) => return Err(error.into()),
            Err(trouble) => self.told(&trouble),
        };
        for place in elsewhere(&self.folder) {
            let mut other = Self {
                shown: self.shown_beside(&place),
                folder: place,
                planned: self.planned.clone(),
                written: Written::default(),
                diverted: None,
            };
            if other.attempt(&|_| false, &mut write).is_ok() {
                let shown = other.shown.display();
                other.diverted = Some(format!(
                    "{trouble}, so the result is in {shown}; move it from there"
                ));
                *self = other;
                return Ok(());
            }
        }
        Err(Failure::File(format!(
            "{trouble}, nor could a folder beside it or one for temporary files be written; {RUN_AGAIN}"
        )))
    }

    /// Calls `write` with an empty folder aside and adds what it wrote to the result.
    ///
    /// # Errors
    /// The folder could not be written to, or something of the user's is in the way.
    pub fn add<R>(&mut self, write: impl FnMut(&Path) -> Result<R, OutputError>) -> Result<R, Failure> {
        self.exchange(&|_| true, write)
    }

    /// The same, but that our files stay only where `keep` says so.
    ///
    /// # Errors
    /// As [`Self::add`].
    pub fn exchange<R>(
        &mut self,
        keep: &dyn Fn(&Path) -> bool,
        mut write: impl FnMut(&Path) -> Result<R, OutputError>,
    ) -> Result<R, Failure> {
        self.attempt(keep, &mut write).map_err(|trouble| {
            let remedy = match &trouble {
                Trouble::Other(OutputError::Source(failure)) => return failure.clone(),
                Trouble::InTheWay(_) => "; move it away or choose another folder with -o DIR",
                Trouble::Refused(..) => "; free some space or choose another folder with -o DIR",
                Trouble::Other(_) => "",
            };
            Failure::File(self.told(&trouble) + remedy)
        })
    }

    /// Has files written aside and moves them in; what else is ours stays where `keep` says so.
    fn attempt<R>(
        &mut self,
        keep: &dyn Fn(&Path) -> bool,
        write: &mut dyn FnMut(&Path) -> Result<R, OutputError>,
    ) -> Result<R, Trouble> {
        let refused = |error| Trouble::Refused(PathBuf::new(), error);
        let mut staging = Staging::new(&self.folder, "new").map_err(refused)?;
        let fresh = staging.below("new");
        let unwritten = |error: OutputError| match error {
            OutputError::Write { path, source } => {
                Trouble::Refused(path.strip_prefix(&fresh).unwrap_or(&path).to_path_buf(), source)
            }
            other => Trouble::Other(other),
        };
        let answer = create_folder(&fresh)
            .and_then(|()| write(&fresh))
            .map_err(unwritten)?;
        let mut new = files_below(&fresh).map_err(refused)?;
        if let Some(path) = self.in_the_way(&new) {
            return Err(Trouble::InTheWay(path));
        }
        let gone = self.replaced(&new, keep);
        let held = |file: &&PathBuf| keep(file) && self.written.holds(&self.folder, file);
        let stay = self.written.files().filter(held).cloned();
        let stay = stay.filter(|file| !gone.contains(file));
        let mut all: BTreeSet<PathBuf> = stay.chain(new.iter().cloned()).collect();
        write_bytes(&fresh.join(MANIFEST), manifest_of(&all).as_bytes()).map_err(unwritten)?;
        new.push(MANIFEST.into());
        all.insert(MANIFEST.into());
        // What comes in the place of an earlier result, and what a solve forgets its states for, is on the disc.
        sync_files(&fresh, &new).map_err(|(path, error)| Trouble::Refused(path, error))?;
        if fs::symlink_metadata(&self.folder).is_err_and(|error| error.kind() == ErrorKind::NotFound) {
            self.put_down(&fresh).map_err(refused)?;
        } else {
            let plan = Plan { gone, new };
            plan.write(&staging.below("")).map_err(unwritten)?;
            self.move_in(&plan, &mut staging)?;
        }
        self.written = Written::now(&self.folder, all);
        Ok(answer)
    }

    /// Makes the folder `fresh` the one of the result, where there is none.
    fn put_down(&self, fresh: &Path) -> io::Result<()> {
        fs::rename(fresh, &self.folder)?;
        let synced = self.folder.parent().map_or(Ok(()), sync_folder);
        if synced.is_err() {
            // All or nothing; if it stays it is whole.
            let _ = fs::rename(&self.folder, fresh);
        }
        synced
    }

    /// Moves the files `gone` out and the files `new` in; all of them or none.
    fn move_in(&self, Plan { gone, new }: &Plan, staging: &mut Staging) -> Result<(), Trouble> {
        let (fresh, old) = (staging.below("new"), staging.below("old"));
        let mut moves = Moves::default();
        let out = gone.iter().map(|file| (file, &self.folder, &old));
        let moved = out
            .chain(new.iter().map(|file| (file, &fresh, &self.folder)))
            .try_for_each(|(file, from, to)| {
                moves.carry(file, from, to).map_err(|error| match error.kind() {
                    ErrorKind::AlreadyExists => Trouble::InTheWay(file.clone()),
                    _ => Trouble::Refused(file.clone(), error),
                })
            })
            .and_then(|()| {
                sync_folders(&self.folder, gone.iter().chain(new))
                    .map_err(|(path, error)| Trouble::Refused(path, error))
            });
        if moved.is_err() && !moves.undo() {
            staging.keep();
        }
        if moved.is_ok() {
            // Folders that were ours and are empty now; those that are not empty stay.
            for folder in gone
                .iter()
                .flat_map(|file| file.ancestors().skip(1))
                .filter(|folder| !folder.as_os_str().is_empty())
            {
                let _ = fs::remove_dir(self.folder.join(folder));
            }
        }
        moved
    }

    /// Our files that make room for `new`: those of the same names, and all that `keep` does not want. What changed meanwhile is not ours.
    fn replaced(&self, new: &[PathBuf], keep: &dyn Fn(&Path) -> bool) -> BTreeSet<PathBuf> {
        let new: BTreeSet<&PathBuf> = new.iter().collect();
        let named = |file: &PathBuf| new.contains(file) || file == Path::new(MANIFEST);
        self.written
            .files()
            .filter(|file| (!keep(file) || named(file)) && self.written.holds(&self.folder, file))
            .cloned()
            .collect()
    }

    /// The first half of a sentence about `trouble`.
    fn told(&self, trouble: &Trouble) -> String {
        match trouble {
            Trouble::InTheWay(path) => {
                let path = self.shown.join(path);
                if self.written.is_empty() && is_of_ours(&self.folder) {
                    format!("{} came there meanwhile, from another run", path.display())
                } else {
                    format!("{} is there and was not written by thurible", path.display())
                }
            }
            Trouble::Refused(path, error) if path.as_os_str().is_empty() => {
                format!("cannot write {}: {error}", self.shown.display())
            }
            Trouble::Refused(path, error) => {
                format!("cannot write {}: {error}", self.shown.join(path).display())
            }
            Trouble::Other(error) => error.to_string(),
        }
    }

    /// How the user knows the folder `place`: as beside this one, if it is.
    fn shown_beside(&self, place: &Path) -> PathBuf {
        match (place.file_name(), self.shown.file_name()) {
            (Some(name), Some(_)) if place.parent() == self.folder.parent() => {
                self.shown.with_file_name(name)
            }
            _ => place.to_path_buf(),
        }
    }
}

/// Folders that are not there yet, for a result that cannot go to `folder`: beside it, and where temporary files go.
fn elsewhere(folder: &Path) -> [PathBuf; 2] {
    let name = folder.file_name().unwrap_or("out".as_ref());
    let free = |parent: &Path| {
        let numbered = |number: usize| {
            let mut name = name.to_os_string();
            name.push(format!(".{number}"));
            parent.join(name)
        };
        let taken = |path: &PathBuf| fs::symlink_metadata(path).is_ok();
        (1..)
            .map(numbered)
            .find(|path| !taken(path))
            .unwrap_or_else(|| numbered(0))
    };
    [free(folder.parent().unwrap_or(folder)), free(&env::temp_dir())]
}
