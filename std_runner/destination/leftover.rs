//! Hidden folders that killed runs left behind: what was under way in them is brought to one end or the other, and they are removed.

use super::moves::{Moves, Plan, sync_folders};
use super::staging::{MARK, beside, remove};
use crate::held::is_left_behind;
use std::fs;
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};

/// Puts `folder` in order after runs that were killed while they wrote to it. What another run is still at stays.
///
/// # Errors
/// The hidden folder whose files could not be moved; they stay in it, and nothing may be written to `folder` until they are.
pub(super) fn recover(folder: &Path) -> Result<(), (PathBuf, io::Error)> {
    for hidden in left_behind(folder) {
        if let Err(error) = finish(folder, &hidden) {
            return Err((hidden, error));
        }
        // A folder that cannot be removed is not what the user must hear of.
        let _ = remove(&hidden);
    }
    Ok(())
}

/// The hidden folders for `folder` whose runs are no more: in it, in its own folders, or beside it.
fn left_behind(folder: &Path) -> Vec<PathBuf> {
    let inside = |name: &str| name.strip_prefix('.').is_some_and(|name| name.starts_with(MARK));
    let own = format!("{}{MARK}", beside(folder).to_string_lossy());
    let mut found = named(folder, &inside);
    for below in named(folder, &|name: &str| !name.starts_with('.')) {
        found.extend(named(&below, &inside));
    }
    if let Some(parent) = folder.parent() {
        found.extend(named(parent, &|name: &str| name.starts_with(&own)));
    }
    // An empty one has no lock yet, or no more: whoever is making it just now makes another.
    found.retain(|hidden| fs::remove_dir(hidden).is_err() && is_left_behind(hidden));
    found
}

/// The folders in `folder` whose names are `wanted`.
fn named(folder: &Path, wanted: &dyn Fn(&str) -> bool) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    let folders = entries.filter(|entry| {
        let is_folder = entry.file_type().is_ok_and(|kind| kind.is_dir());
        is_folder && entry.file_name().to_str().is_some_and(wanted)
    });
    folders.map(|entry| entry.path()).collect()
}

/// Brings a move that was cut off to its end, where all of it had been written down.
fn finish(folder: &Path, hidden: &Path) -> io::Result<()> {
    let Some(plan) = Plan::read(hidden)? else {
        // Nothing of the earlier result was moved.
        return Ok(());
    };
    let (fresh, old) = (hidden.join("new"), hidden.join("old"));
    let mut moves = Moves::default();
    // Gone with the user's consent, or not there to be moved; what is in the way of a new one was put there by somebody else, and stays.
    let unless =
        |kind: ErrorKind| move |error: io::Error| if error.kind() == kind { Ok(()) } else { Err(error) };
    for file in &plan.gone {
        if !old.join(file).try_exists()? {
            moves
                .carry(file, folder, &old)
                .or_else(unless(ErrorKind::NotFound))?;
        }
    }
    for file in &plan.new {
        if fresh.join(file).try_exists()? {
            moves
                .carry(file, &fresh, folder)
                .or_else(unless(ErrorKind::AlreadyExists))?;
        }
    }
    sync_folders(folder, plan.gone.iter().chain(&plan.new)).map_err(|(_, error)| error)
}
