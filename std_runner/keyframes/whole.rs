//! A file at once.

use std::path::Path;

use super::error::Fault;
use crate::bytes::{are_free, grouped};

/// All bytes of a file for which, `growth` times over, there is memory; `remedy` is what to do where there is not. What is no file on a disk
/// may have no end and is refused.
pub(super) fn whole(path: &Path, growth: usize, remedy: &str) -> Result<Vec<u8>, Fault> {
    let about = std::fs::metadata(path)?;
    // Of a folder the system says itself that it is one.
    if !about.is_file() && !about.is_dir() {
        return Err(Fault::content(
            "is no regular file",
            "save what it gives to one, and name that",
        ));
    }
    let size = usize::try_from(about.len()).unwrap_or(usize::MAX);
    if !are_free(size.saturating_mul(growth)) {
        return Err(Fault::content(
            format!(
                "has {} bytes, more than there is memory to read them",
                grouped(size)
            ),
            remedy,
        ));
    }
    Ok(std::fs::read(path)?)
}
