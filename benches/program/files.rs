//! Files of a folder that pages and figures go to.

use std::fs;
use std::path::Path;
use thurible::exit::Failure;

/// Refuses a folder that cannot be written, before anything is measured.
pub(crate) fn check(folder: &Path) -> Result<(), Failure> {
    let probe = folder.join(format!(".thurible-probe-{}", std::process::id()));
    let tried = fs::create_dir_all(folder)
        .and_then(|()| fs::write(&probe, ""))
        .and_then(|()| fs::remove_file(&probe));
    tried.map_err(|error| {
        Failure::File(format!(
            "cannot write the folder {}: {error}; choose another one with --out DIR",
            folder.display()
        ))
    })
}

/// Writes a file of the folder.
pub(crate) fn put(folder: &Path, name: &str, text: &str) -> Result<(), Failure> {
    let path = folder.join(name);
    fs::write(&path, text).map_err(|error| {
        Failure::File(format!(
            "cannot write {}: {error}; free some space or choose another folder",
            path.display()
        ))
    })
}
