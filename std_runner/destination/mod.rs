//! The result folder: checked before the solve, filled aside and moved in place when it is whole.
//!
//! What lies in it and was not written by thurible stays. The files that were written are listed in a manifest beside them, and only
//! those are replaced, if they still are what was found before the solve. Where something of the user's stands in the way of a file
//! by then, or the folder cannot be written to any more, the result goes elsewhere.

mod alone;
mod fill;
mod leftover;
mod moves;
mod resolve;
mod staging;
mod written;

pub(crate) use alone::refuse_others;
pub(crate) use fill::RUN_AGAIN;
pub(crate) use resolve::shown;

use crate::exit::Failure;
use crate::output::{sync_folder, write_bytes};
use resolve::{Astray, resolved};
use staging::Staging;
use std::collections::BTreeSet;
use std::fs;
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};

/// Why a name that begins so is none of a result.
pub(crate) const HOME: &str = "begins with ~, which only a shell takes for a home folder; write the whole path, or ./~ for a folder of that name";
use written::{MANIFEST, Written, is_of_ours, is_result, manifest_of};

/// A folder for what grows while a result is made.
#[derive(Debug)]
pub struct Aside(Folder);

/// Whose folder it is.
#[derive(Debug)]
enum Folder {
    /// A hidden one, which is removed with what is left in it.
    Hidden(Staging),
    /// One that somebody else looks after.
    Other(PathBuf),
}

impl Aside {
    /// The folder `other`, which somebody else looks after.
    pub(crate) fn within(other: PathBuf) -> Self {
        Self(Folder::Other(other))
    }

    /// A file in it.
    #[must_use]
    pub fn file(&self, name: &str) -> PathBuf {
        match &self.0 {
            Folder::Hidden(staging) => staging.below(name),
            Folder::Other(folder) => folder.join(name),
        }
    }
}

/// Brings to an end what killed runs were at in `folder`.
pub(crate) fn put_in_order(folder: &Path) {
    if let Ok(place) = resolved(folder) {
        // Who writes there hears of what cannot be.
        let _ = leftover::recover(&place);
    }
}

/// Removes the file `name` of the result in `folder`, if it is there and ours.
///
/// # Errors
/// As [`Destination::check`], or the system refused.
pub(crate) fn remove_written(folder: &Path, name: &str) -> Result<(), Failure> {
    if folder.join(name).exists() {
        Destination::check(folder, Vec::new())?.remove(name)?;
    }
    Ok(())
}

/// Where `folder` is: absolute, without links; as it is named where that cannot be known.
pub(crate) fn place_of(folder: &Path) -> PathBuf {
    resolved(folder).unwrap_or_else(|_| folder.to_path_buf())
}

/// What becomes of results and pages that are there.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Earlier {
    /// They are not written over.
    Refused,
    /// They are.
    Replaced,
}

impl Earlier {
    /// As `--force` has it.
    pub(crate) fn by(force: bool) -> Self {
        if force { Self::Replaced } else { Self::Refused }
    }

    /// Refuses a folder whose whole result would be lost; `others` are the options that choose another one.
    ///
    /// # Errors
    /// It holds one, which is not to be replaced.
    pub(crate) fn check(self, folder: &Path, others: &str) -> Result<(), Failure> {
        if self == Self::Replaced {
            return Ok(());
        }
        let Ok(place) = resolved(folder) else {
            return Ok(());
        };
        // Who writes there hears of what cannot be.
        let _ = leftover::recover(&place);
        if !is_result(&place, "report.json") {
            return Ok(());
        }
        let shown = folder.display();
        Err(Failure::File(format!(
            "{shown} holds a result already: keep it and choose another folder with {others}, or write over it with --force"
        )))
    }
}

/// A folder that a result may be written to.
#[derive(Clone, Debug)]
pub struct Destination {
    /// Where it is: absolute, without links.
    folder: PathBuf,
    /// As the user knows it.
    shown: PathBuf,
    /// The files that are going to be written, as far as that is known.
    planned: Vec<PathBuf>,
    /// The files in it that are ours.
    written: Written,
    /// Why the result is elsewhere than it should be, and where, if it is.
    diverted: Option<String>,
}

impl Destination {
    /// Checks `folder` for a result with the files `planned`.
    ///
    /// # Errors
    /// The path is a file, a link to nowhere or a folder of something else, it cannot be written to, or one of the files is there and is
    /// not ours.
    pub fn check(folder: &Path, planned: Vec<PathBuf>) -> Result<Self, Failure> {
        Self::check_for(folder, "report.json", planned)
    }

    /// As [`Self::check`], where the JSON file `mark` tells that a folder holds a result.
    ///
    /// # Errors
    /// As [`Self::check`].
    pub fn check_for(folder: &Path, mark: &str, planned: Vec<PathBuf>) -> Result<Self, Failure> {
        let cannot = |error: io::Error| {
            Failure::File(format!(
                "cannot write the result folder {}: {error}; choose another one with -o DIR",
                folder.display()
            ))
        };
        if folder.starts_with("~") {
            return Err(Failure::Input(format!(
                "the result folder {} {HOME}",
                folder.display()
            )));
        }
        let place = resolved(folder).map_err(|astray| match astray {
            Astray::Unknown(error) => cannot(error),
            Astray::Dangling { link, to } => Failure::File(format!(
                "cannot write the result folder {}: {} is a link to {}, which is not there; make that folder, or choose another one with -o DIR",
                folder.display(),
                link.display(),
                to.display()
            )),
        })?;
        let mut destination = Self {
            shown: shown(folder, &place),
            folder: place,
            planned,
            written: Written::default(),
            diverted: None,
        };
        leftover::recover(&destination.folder).map_err(|(hidden, error)| {
            Failure::File(format!(
                "cannot write the result folder {}: what an earlier run was moving there when it was ended is in {} and cannot be moved: {error}; make the folder writable and run it again, or choose another one with -o DIR",
                folder.display(),
                hidden.display()
            ))
        })?;
        match fs::metadata(&destination.folder) {
            Ok(found) if found.is_dir() => destination.look(mark)?,
            Ok(_) => {
                let shown = folder.display();
                let why = format!("the result folder {shown} is a file; choose another one with -o DIR");
                return Err(Failure::File(why));
            }
            Err(error) if error.kind() == ErrorKind::NotFound => {}
            Err(error) => return Err(cannot(error)),
        }
        destination.probe().map_err(cannot)?;
        Ok(destination)
    }

    /// Looks at what is in the folder.
    fn look(&mut self, mark: &str) -> Result<(), Failure> {
        let shown = self.shown.display();
        let mut entries = fs::read_dir(&self.folder)
            .map_err(|error| {
                Failure::File(format!(
                    "cannot read the result folder {shown}: {error}; choose another one with -o DIR"
                ))
            })?
            .peekable();
        self.written = Written::found(&self.folder, mark);
        if entries.peek().is_some() && self.written.is_empty() && !is_result(&self.folder, mark) {
            let why = if is_of_ours(&self.folder) {
                "holds a result of another kind, so it is not overwritten; choose another one with -o DIR"
            } else {
                "is not empty and holds no result of thurible, so it is not overwritten; empty it or choose another one with -o DIR"
            };
            return Err(Failure::File(format!("the folder {shown} {why}")));
        }
        match self.in_the_way(&[]) {
            None => Ok(()),
            Some(path) => Err(Failure::File(format!(
                "{} is there and was not written by thurible, so it is not overwritten; move it away or choose another folder with -o DIR",
                self.shown.join(path).display()
            ))),
        }
    }

    /// Finds out whether the folder and those in it that are ours can be written to.
    fn probe(&self) -> io::Result<()> {
        if !self.folder.is_dir()
            && let Some(parent) = self.folder.parent()
        {
            let missing: Vec<&Path> = parent.ancestors().take_while(|folder| !folder.is_dir()).collect();
            fs::create_dir_all(parent)?;
            let above = missing.iter().filter_map(|folder| folder.parent());
            above.into_iter().try_for_each(sync_folder)?;
        }
        Staging::new(&self.folder, "probe")?;
        // The folders in it alone: an array in pieces has a thousand below its own.
        let below: BTreeSet<PathBuf> = self
            .planned
            .iter()
            .chain(self.written.files())
            .filter_map(|file| {
                let mut parts = file.components();
                let first = parts.next().filter(|_| parts.next().is_some())?;
                Some(self.folder.join(first))
            })
            .collect();
        let mut there = below.into_iter().filter(|folder| folder.is_dir());
        there.try_for_each(|folder| Staging::new(&folder, "probe").map(drop))
    }

    /// A hidden folder on the file system of the result, which is removed with what is left in it.
    ///
    /// # Errors
    /// The system refused.
    pub fn aside(&self) -> Result<Aside, Failure> {
        let staging = Staging::new(&self.folder, "growing").map_err(|error| {
            let shown = self.shown.display();
            Failure::File(format!(
                "cannot write beside {shown}: {error}; choose another folder with -o DIR"
            ))
        })?;
        Ok(Aside(Folder::Hidden(staging)))
    }

    /// Where the result is, absolute.
    #[must_use]
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// Where the result is, as the user knows it.
    #[must_use]
    pub fn shown(&self) -> &Path {
        &self.shown
    }

    /// Why the result is elsewhere than it should be, and where, if it is.
    #[must_use]
    pub fn diverted(&self) -> Option<&str> {
        self.diverted.as_deref()
    }

    /// Removes the file `name` if it is still ours.
    ///
    /// # Errors
    /// The system refused.
    pub fn remove(&mut self, name: &str) -> Result<(), Failure> {
        let name = Path::new(name);
        let path = self.folder.join(name);
        if !self.written.holds(&self.folder, name) {
            return Ok(());
        }
        let left: Vec<PathBuf> = self
            .written
            .files()
            .filter(|file| *file != name)
            .cloned()
            .collect();
        let text = manifest_of(left.iter().filter(|file| *file != Path::new(MANIFEST)));
        fs::remove_file(&path).map_err(|error| {
            Failure::File(format!(
                "cannot remove {}: {error}; remove it yourself",
                path.display()
            ))
        })?;
        write_bytes(&self.folder.join(MANIFEST), text.as_bytes())?;
        self.written = Written::now(&self.folder, left);
        Ok(())
    }

    /// What of the user's stands in the way of what is planned, of `new` or of the manifest.
    fn in_the_way(&self, new: &[PathBuf]) -> Option<PathBuf> {
        let manifest = PathBuf::from(MANIFEST);
        let files = new.iter().chain(&self.planned).chain([&manifest]);
        files
            .filter_map(|file| self.written.in_the_way(&self.folder, file))
            .next()
    }
}
