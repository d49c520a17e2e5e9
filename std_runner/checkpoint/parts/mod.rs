//! The parts of a state that ranks share: a file for each in the folder of the states, `state.NUMBER.RANK`, which all machines see. The state itself
//! is their manifest: it is written when all of them are, and has their checksums at its end.

use super::sealed::{BEGIN, Sealed, seal, sum_of};
use super::solve::{Cut, unlike_ranks};
use crate::among::{agreed, shared_folder, told};
use crate::exit::Failure;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io::{self, BufReader, ErrorKind, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};
use thurible_core::checkpoint::{PartStore, Refused, SavedError, SavedParts, Sink};
use thurible_core::exec::Ranks;
use thurible_core::exec::ranks::{Alone, swap};
use thurible_core::grid::Share;

/// Bytes of a number.
const WORD: usize = 8;
/// Files that are open at once: every system allows a program as many.
const OPEN: usize = 128;
/// What to do where ranks do not see the folder of the states that they write, or read.
const WRITTEN: &str = "take a result folder that all machines share, with -o DIR";
const READ: &str = "copy the folder of states to where all machines see it, and go on with that";

/// Where the parts of a state are, or the state of one program.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(crate) struct Place {
    /// The state's number.
    pub number: u64,
    /// The name of the state, and where in it the core's begins.
    pub slot: String,
    pub begin: u64,
    /// The ranks that wrote it.
    pub cut: Option<Cut>,
    /// The checksums of its parts, or its own: the files are to be those that the first rank sees.
    pub sums: Vec<u64>,
}

/// A state that is written: its file, and where ranks share a solve the parts that belong to it.
pub(crate) struct Saving<'a> {
    pub file: &'a mut Sealed,
    pub parts: Option<PartFiles>,
}

/// The files of one rank.
pub(crate) struct PartFiles {
    ranks: &'static dyn Ranks,
    folder: PathBuf,
    place: Place,
    /// The checksums of the parts that were written, which the first rank has.
    sums: Option<Vec<u64>>,
    /// Why they could not be written or read.
    pub trouble: Option<String>,
}

impl PartFiles {
    /// Those of a rank, `place` in `folder`; one that follows is told where they are.
    pub fn new(ranks: Option<&'static dyn Ranks>, folder: &Path, place: Place) -> Self {
        Self {
            ranks: ranks.unwrap_or(&Alone),
            folder: folder.to_owned(),
            place,
            sums: None,
            trouble: None,
        }
    }

    /// Those of a rank that follows.
    pub fn following(ranks: Option<&'static dyn Ranks>) -> Self {
        Self::new(ranks, Path::new(""), Place::default())
    }

    /// Hears from the first rank where they are.
    fn hear(&mut self, remedy: &str) -> Result<(), Failure> {
        self.folder = shared_folder(self.ranks, &self.folder, remedy)?;
        let place = serde_json::to_vec(&self.place).unwrap_or_default();
        let place = serde_json::from_slice(&told(self.ranks, 0, place));
        self.place = agreed(self.ranks, place.map_err(|_| unlike_ranks()))?;
        Ok(())
    }

    fn write_part(
        &mut self,
        fill: &mut dyn FnMut(&mut dyn Sink) -> Result<(), Refused>,
    ) -> Result<Vec<u64>, Failure> {
        self.hear(WRITTEN)?;
        let path = part_at(&self.folder, self.place.number, self.ranks.rank());
        let written = Sealed::write(&path, &grows(&path), &mut |file| fill(file));
        let cannot = |error: &dyn core::fmt::Display| {
            Failure::File(format!("cannot write {}: {error}", path.display()))
        };
        let own = agreed(self.ranks, written.map_err(|error| cannot(&error)))?;
        let mut sums = vec![own];
        if self.ranks.rank() > 0 {
            swap(self.ranks, Some(0), &sums, None, &mut []);
        } else {
            sums.resize(self.ranks.count(), 0);
            let others = sums.iter_mut().enumerate().skip(1);
            others.for_each(|(rank, sum)| {
                swap(self.ranks, None, &[], Some(rank), core::slice::from_mut(sum));
            });
        }
        // The first one sees them all.
        let mut files = (0..sums.len()).map(|rank| part_at(&self.folder, self.place.number, rank));
        let unseen = files.find(|path| self.ranks.rank() == 0 && !path.is_file());
        let unseen =
            unseen.map(|path| Failure::File(format!("{} is on another machine; {WRITTEN}", path.display())));
        agreed(self.ranks, unseen.map_or(Ok(sums), Err))
    }

    /// Writes the manifest's end: whether there are parts, and their checksums.
    pub fn seal(&self, file: &mut Sealed) -> Result<(), Refused> {
        let none = vec![0; self.ranks.count()];
        file.put(&u64::from(self.sums.is_some()).to_le_bytes())?;
        let sums = self.sums.as_ref().unwrap_or(&none);
        sums.iter().try_for_each(|sum| file.put(&sum.to_le_bytes()))
    }
}

impl PartStore for PartFiles {
    fn write(&mut self, fill: &mut dyn FnMut(&mut dyn Sink) -> Result<(), Refused>) -> Result<(), Refused> {
        match self.write_part(fill) {
            Ok(sums) => {
                self.sums = Some(sums);
                Ok(())
            }
            Err(failure) => {
                self.trouble = Some(failure.to_string());
                Err(Refused)
            }
        }
    }

    fn read(
        &mut self,
        take: &mut dyn FnMut(&mut dyn SavedParts) -> Result<(), SavedError>,
    ) -> Result<(), SavedError> {
        if let Err(failure) = self.hear(READ) {
            self.trouble = Some(failure.to_string());
            return Err(SavedError::Refused);
        }
        let mut open = Open {
            folder: &self.folder,
            place: &self.place,
            files: BTreeMap::new(),
            trouble: None,
        };
        let taken = take(&mut open);
        if taken.is_err() {
            // So it is in all of them.
            let own = open.trouble.map_or(Ok(()), |trouble| Err(Failure::File(trouble)));
            self.trouble = agreed(self.ranks, own).err().map(|failure| failure.to_string());
        }
        taken
    }
}

/// Files that are read, each where it was read last.
struct Open<'a> {
    folder: &'a Path,
    place: &'a Place,
    files: BTreeMap<usize, (BufReader<File>, u64)>,
    trouble: Option<String>,
}

impl Open<'_> {
    fn path(&self, rank: usize) -> PathBuf {
        match self.place.cut {
            Some(_) => part_at(self.folder, self.place.number, rank),
            None => self.folder.join(&self.place.slot),
        }
    }

    fn read(&mut self, rank: usize, at: u64, bytes: &mut [u8]) -> io::Result<()> {
        if self.files.len() >= OPEN && !self.files.contains_key(&rank) {
            self.files.clear();
        }
        let begin = self.place.cut.map_or(self.place.begin, |_| BEGIN);
        if !self.files.contains_key(&rank) {
            let mut file = File::open(self.path(rank))?;
            if self.place.sums.get(rank) != Some(&seal(&mut file)?) {
                return Err(io::Error::other("it is not what the first rank sees there"));
            }
            let mut file = BufReader::new(file);
            file.seek(SeekFrom::Start(begin))?;
            self.files.insert(rank, (file, 0));
        }
        let Some((file, place)) = self.files.get_mut(&rank) else {
            return Ok(());
        };
        // Two places in a file are less apart than a signed number can tell.
        file.seek_relative(at.wrapping_sub(*place).cast_signed())?;
        file.read_exact(bytes)?;
        *place = at + bytes.len() as u64;
        Ok(())
    }
}

impl SavedParts for Open<'_> {
    fn share(&self) -> Share {
        self.place.cut.map_or(Share::new(0, 1), Cut::share)
    }

    fn take(&mut self, rank: usize, at: u64, bytes: &mut [u8]) -> Result<(), Refused> {
        self.read(rank, at, bytes).map_err(|error| {
            let path = self.path(rank);
            self.trouble = Some(format!("cannot read {}: {error}", path.display()));
            Refused
        })
    }
}

/// The file of a rank's part.
fn part_at(folder: &Path, number: u64, rank: usize) -> PathBuf {
    folder.join(format!("state.{number}.{rank}"))
}

/// Where it grows.
fn grows(path: &Path) -> PathBuf {
    let mut name = path.as_os_str().to_owned();
    name.push(".part");
    name.into()
}

/// The number of the state that a file is a part of.
fn number_of(name: &str) -> Option<u64> {
    let (number, _) = name.strip_prefix("state.")?.split_once('.')?;
    number.parse().ok()
}

/// Removes the parts of all states in `folder` but `number` and the one before. What cannot be removed takes room, and nothing else.
pub(super) fn clean(folder: &Path, number: u64) {
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        let of = entry.file_name().to_str().and_then(number_of);
        if of.is_some_and(|of| of != number && of.checked_add(1) != Some(number)) {
            let _ = fs::remove_file(entry.path());
        }
    }
}

/// The checksums of the parts of the state at `slot`, which is whole, or its own where it has none; `None` where it is not what it says.
pub(super) fn sums(slot: &Path, cut: Option<Cut>) -> io::Result<Option<Vec<u64>>> {
    let mut file = File::open(slot)?;
    let Some(cut) = cut else {
        return Ok(Some(vec![seal(&mut file)?]));
    };
    let count = (2 + cut.ranks()).saturating_mul(WORD);
    let Some(begin) = file.metadata()?.len().checked_sub(count as u64) else {
        return Ok(None);
    };
    file.seek(SeekFrom::Start(begin))?;
    // The last word is the checksum of the manifest.
    let mut bytes = vec![0; count - WORD];
    file.read_exact(&mut bytes)?;
    let words = bytes.as_chunks::<WORD>().0.iter();
    let mut words = words.map(|word| u64::from_le_bytes(*word));
    // Between two windows there is nothing to have parts of.
    let has_parts = words.next() == Some(1);
    Ok(Some(words.filter(|_| has_parts).collect()))
}

/// Whether the parts of the state at `slot`, which is whole, are those that it was made of.
pub(super) fn are_whole(slot: &Path, number: u64, cut: Cut) -> io::Result<bool> {
    let folder = slot.parent().unwrap_or(Path::new(""));
    let Some(sums) = sums(slot, Some(cut))? else {
        return Ok(false);
    };
    for (rank, sum) in sums.into_iter().enumerate() {
        match sum_of(&part_at(folder, number, rank)) {
            Ok(found) if found == Some(sum) => {}
            Err(error) if error.kind() != ErrorKind::NotFound => return Err(error),
            _ => return Ok(false),
        }
    }
    Ok(true)
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests;
