//! The states that an earlier run left.

use super::parts::{are_whole, sums};
use super::words::MANY;
use super::{PART, PartFiles, SLOTS, Saving, Sealed, Solve, Unsealed, Words, beside, has_states, result_of};
use crate::console::quoted_path;
use crate::destination::place_of;
use crate::exit::Failure;
use crate::held::{LOCK, hold, remove};
use crate::report::REPORT;
use core::cmp::Reverse;
use serde_json::Value;
use std::ffi::OsStr;
use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use thurible_core::checkpoint::Refused;
use thurible_core::method::registry::simulates;
use thurible_core::{Method, Named, Params, Status};

/// A state to go on from.
#[derive(Clone, Debug)]
pub(crate) struct Found {
    /// The folder of states, which is held as long as this lives.
    pub place: PathBuf,
    pub lock: Arc<File>,
    /// The file.
    pub slot: PathBuf,
    pub solve: Solve,
    /// What is to be said of another one.
    pub note: Option<String>,
}

/// Whether there is a state of a solve into `folder` that was not finished.
pub(crate) fn is_there(folder: &Path) -> bool {
    has_states(&beside(folder))
}

fn was_interrupted(report: &Value) -> bool {
    report["status"] == Status::Cancelled.name()
}

fn is_one_pass(report: &Value) -> bool {
    let method = Method::ALL
        .iter()
        .find(|method| report["method"] == method.name());
    method.is_some_and(|&method| {
        simulates(&Params {
            method,
            ..Params::default()
        })
    })
}

/// Finds the last whole state of `folder`, a folder of states or that of the result.
///
/// # Errors
/// There is none, or another run holds it.
pub(crate) fn open(folder: &Path) -> Result<Found, Failure> {
    // Who names one of the states means them.
    let is_state = |name: &OsStr| SLOTS.iter().any(|slot| name == *slot);
    let folder = match folder.parent() {
        Some(place) if folder.is_file() && folder.file_name().is_some_and(is_state) => place,
        _ => folder,
    };
    let places = [folder.to_owned(), beside(folder)];
    let shown = folder.display();
    let place = places.iter().find(|place| has_states(place)).ok_or_else(|| {
        let report = fs::read(folder.join(REPORT));
        let report = report.map(|text| serde_json::from_slice::<Value>(&text).unwrap_or_default());
        let why = match report {
            Ok(report) if report.get("kind").is_some() => {
                "it is no solve, and what it holds is whole as far as it goes; make it anew with --force for more"
            }
            Ok(report) if was_interrupted(&report) && is_one_pass(&report) => {
                "it was simulated in one pass, of which no state is kept, and interrupted; simulate anew with --force"
            }
            Ok(report) if was_interrupted(&report) => {
                "its solve was interrupted and kept no state; solve anew with --force, and with --checkpoint every=60s where it may be interrupted again"
            }
            Ok(_) => "its solve was finished, and nothing is left to go on with",
            Err(_) => "there is no state of a solve in it or beside it",
        };
        Failure::File(format!("cannot go on with {shown}: {why}; give the folder of a solve that was not finished, or of its states"))
    })?;
    let lock = held(place)?;
    let mut found: Vec<(PathBuf, Solve)> = Vec::new();
    let mut broken = Vec::new();
    let mut tell = |slot: &Path, read: io::Result<Option<Solve>>| match read {
        Ok(Some(solve)) => Some((slot.to_owned(), solve)),
        Ok(None) => {
            broken.push(format!("{} is not whole", slot.display()));
            None
        }
        Err(error) if error.kind() == io::ErrorKind::NotFound => None,
        Err(error) => {
            broken.push(format!("{} cannot be read: {error}", slot.display()));
            None
        }
    };
    for slot in SLOTS.map(|slot| place.join(slot)) {
        found.extend(tell(&slot, head(&slot)));
    }
    // The parts of the earlier one are not looked at where the later one has all of its own.
    found.sort_by_key(|(_, solve)| Reverse(solve.number));
    let latest = found
        .into_iter()
        .find_map(|(slot, solve)| tell(&slot, with_parts(&slot, solve)));
    let broken = broken.join(", ");
    let (slot, mut solve) = latest.ok_or_else(|| {
        Failure::File(format!(
            "cannot go on with {shown}: {broken}; solve anew with --force"
        ))
    })?;
    // Who moved the result and its states, or a folder above them, wants it where they are now.
    if let Some(home) = result_of(place)
        && place_of(&home) != place_of(&solve.options.folder)
    {
        solve.move_to(home);
    }
    Ok(Found {
        place: place.clone(),
        lock: Arc::new(lock),
        slot,
        solve,
        note: (!broken.is_empty()).then(|| format!("{broken}, so the other state is gone on from")),
    })
}

/// What the state at `slot` belongs to; `None` if it is not whole.
fn head(slot: &Path) -> io::Result<Option<Solve>> {
    let Some(mut file) = Unsealed::open(slot)? else {
        return Ok(None);
    };
    let head = file.block().ok();
    let solve: Option<Solve> = head.and_then(|head| serde_json::from_slice(&head).ok());
    // The states after it are counted on.
    Ok(solve.filter(|solve| solve.number < MANY))
}

/// `solve` of the state at `slot`, if it has all its parts.
fn with_parts(slot: &Path, solve: Solve) -> io::Result<Option<Solve>> {
    let is_whole = solve
        .cut
        .map_or(Ok(true), |cut| are_whole(slot, solve.number, cut))?;
    Ok(is_whole.then_some(solve))
}

/// What the runner remembered in the state at `slot`, and the file where the core's state follows.
pub(crate) fn read(slot: &Path) -> Result<(Words, Unsealed), Failure> {
    let file = Unsealed::open(slot).unwrap_or(None);
    let mut file = file.ok_or_else(|| damaged(slot))?;
    let words = file.block().and_then(|_| file.block());
    let words = words.map_err(|Refused| damaged(slot))?;
    Ok((Words::read(words), file))
}

/// The checksums of the parts of a state, or its own.
pub(crate) fn sums_of(found: &Found) -> Result<Vec<u64>, Failure> {
    let sums = sums(&found.slot, found.solve.cut).unwrap_or(None);
    sums.ok_or_else(|| damaged(&found.slot))
}

/// The failure of a state that is whole and yet not what it should be.
pub(crate) fn damaged(slot: &Path) -> Failure {
    Failure::File(format!(
        "{} is damaged, or was kept by another version of thurible; solve anew with --force",
        slot.display()
    ))
}

/// Holds a folder of states.
pub(super) fn held(place: &Path) -> Result<File, Failure> {
    let shown = place.display();
    match hold(place) {
        Ok(Some(lock)) => Ok(lock),
        Ok(None) => Err(Failure::File(format!(
            "another run is writing to {shown} just now; wait for it, or choose another folder with -o DIR"
        ))),
        Err(error) => Err(Failure::File(format!(
            "cannot write to {shown}: {error}; make it writable, or copy it elsewhere and go on with the copy"
        ))),
    }
}

/// Whether a folder of states, which is there, was made by us.
fn is_ours(place: &Path) -> bool {
    let is_empty = fs::read_dir(place).is_ok_and(|mut entries| entries.next().is_none());
    is_empty || has_states(place) || place.join(LOCK).is_file()
}

/// Refuses a new solve into `folder` where the states of an earlier one are in its way; those that may go if it is `forced` are left until
/// [`make_way`]. What is left without a state is removed, whether the solve is refused later on or not.
///
/// # Errors
/// They are there, or another run holds them.
pub(crate) fn refuse_states(folder: &Path, forced: bool) -> Result<(), Failure> {
    let place = beside(folder);
    if !place.is_dir() {
        return Ok(());
    }
    if !is_ours(&place) {
        return Err(Failure::File(format!(
            "{} is where the states of this solve would go, but it is there and was not made by thurible; move it away, or choose another folder with -o DIR",
            place.display()
        )));
    }
    let _lock = held(&place)?;
    if !has_states(&place) {
        // A run was killed before its first state, or while it threw its states away. Who solves hears of what cannot be removed.
        let _ = remove(&place);
    } else if !forced {
        let result = folder.display();
        return Err(Failure::File(format!(
            "the solve into {result} was not finished: go on with it by `thurible resume {}`, or solve anew with --force, which throws its state away",
            quoted_path(folder)
        )));
    }
    Ok(())
}

/// Makes way for a new solve into `folder` that nothing stands against any more: what an earlier one left without a state is removed, its
/// states too if that is `forced`.
///
/// # Errors
/// Another run holds them, or the system refused.
pub(crate) fn make_way(folder: &Path, forced: bool) -> Result<(), Failure> {
    let place = beside(folder);
    if !place.is_dir() || !is_ours(&place) || (has_states(&place) && !forced) {
        return Ok(());
    }
    let shown = place.display();
    let _lock = held(&place)?;
    remove(&place).map_err(|error| {
        Failure::File(format!(
            "cannot remove the states in {shown}: {error}; remove that folder yourself"
        ))
    })
}

/// Writes the state at `slot`: its head, what the runner remembers, and what `fields` adds; with their `parts` where ranks share it.
pub(super) fn write(
    slot: &Path,
    (solve, words): (&Solve, &Words),
    mut parts: Option<PartFiles>,
    fields: &mut dyn FnMut(&mut Saving<'_>) -> Result<(), Refused>,
) -> io::Result<()> {
    let head = serde_json::to_vec(solve)?;
    Sealed::write(slot, &slot.with_file_name(PART), &mut |file| {
        file.block(&head)?;
        file.block(words.bytes())?;
        let parts = parts.take();
        let mut saving = Saving { file, parts };
        fields(&mut saving)?;
        let Saving { file, parts } = saving;
        parts.map_or(Ok(()), |parts| parts.seal(file))
    })?;
    Ok(())
}
