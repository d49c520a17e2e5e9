//! A file that a command writes by itself, outside of result folders.

use crate::exit::Failure;
use std::fs::{self, File};
use std::io::Read;
use std::path::Path;

/// Refuses to write a file, called `kind`, over one that begins otherwise than those `begin`, such as the scene itself. What is empty, or no
/// file, as a terminal, loses nothing.
///
/// # Errors
/// Such a file is at `path`.
pub(crate) fn refuse_others(path: &Path, begin: &[u8], kind: &str) -> Result<(), Failure> {
    let is_filled = fs::metadata(path).is_ok_and(|found| found.is_file() && found.len() > 0);
    let begins_so = || {
        let mut found = Vec::new();
        let read = File::open(path).and_then(|file| file.take(begin.len() as u64).read_to_end(&mut found));
        read.is_ok() && found == begin
    };
    // What is no file is not opened: a pipe would wait for whoever writes to it.
    if !is_filled || begins_so() {
        return Ok(());
    }
    Err(Failure::File(format!(
        "{} is there and is no {kind}, so it is not overwritten; choose another name with -o, or move it away",
        path.display()
    )))
}
