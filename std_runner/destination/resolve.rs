//! Where a path leads, before anything is written there.

use std::io::{self, ErrorKind};
use std::path::{Component, Path, PathBuf};
use std::{env, fs};

/// Why a path leads nowhere.
#[derive(Debug)]
pub(super) enum Astray {
    /// A link on the way leads to what is not there.
    Dangling { link: PathBuf, to: PathBuf },
    /// The system said so.
    Unknown(io::Error),
}

impl From<io::Error> for Astray {
    fn from(error: io::Error) -> Self {
        Self::Unknown(error)
    }
}

/// Where `path` leads: absolute, without links, `.` and `..`. Parts that are not there yet are taken by name.
pub(super) fn resolved(path: &Path) -> Result<PathBuf, Astray> {
    let mut at = env::current_dir()?;
    for part in path.components() {
        match part {
            Component::CurDir => {}
            Component::ParentDir => {
                at.pop();
            }
            Component::Prefix(_) | Component::RootDir => at.push(part),
            Component::Normal(name) => at = step(at.join(name))?,
        }
    }
    Ok(at)
}

/// `path` itself, or where it leads if it is a link.
fn step(path: PathBuf) -> Result<PathBuf, Astray> {
    match fs::symlink_metadata(&path) {
        Ok(found) if found.is_symlink() => fs::canonicalize(&path).map_err(|error| match error.kind() {
            ErrorKind::NotFound => Astray::Dangling {
                to: fs::read_link(&path).unwrap_or_default(),
                link: path,
            },
            _ => Astray::Unknown(error),
        }),
        Ok(_) => Ok(path),
        Err(error) if error.kind() == ErrorKind::NotFound => Ok(path),
        Err(error) => Err(Astray::Unknown(error)),
    }
}

/// `path` as a user reads it best: without `.` and `..` where that leads to the same place, `folder`.
pub(crate) fn shown(path: &Path, folder: &Path) -> PathBuf {
    let plain = plain(path);
    match resolved(&plain) {
        Ok(place) if place == folder => plain,
        _ => folder.to_path_buf(),
    }
}

/// `path` with `.` left out and `a/..` too, as if no part of it were a link.
fn plain(path: &Path) -> PathBuf {
    let mut plain = PathBuf::new();
    for part in path.components() {
        match (part, plain.components().next_back()) {
            (Component::CurDir, _) | (Component::ParentDir, Some(Component::RootDir)) => {}
            (Component::ParentDir, Some(Component::Normal(_))) => {
                plain.pop();
            }
            _ => plain.push(part),
        }
    }
    if plain.as_os_str().is_empty() {
        plain.push(".");
    }
    plain
}
