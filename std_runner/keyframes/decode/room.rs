//! How large a picture may be.

use crate::bytes::{are_free, grouped};
use crate::keyframes::error::Fault;

/// Decoding may take this much memory, in bytes.
pub(super) const MEMORY: usize = 1 << 30;
/// Sides beyond this are refused before anything is decoded.
pub(super) const LONGEST_SIDE: usize = 16384;

/// Refuses a picture of so many pixels of so many `bytes` each before it is decoded, if it is too large.
pub(super) fn check(width: usize, height: usize, bytes: usize) -> Result<(), Fault> {
    if width > LONGEST_SIDE || height > LONGEST_SIDE {
        let remedy =
            format!("make it at most {LONGEST_SIDE} pixels wide and high; the size of the grid is enough");
        return Err(Fault::content(format!("is {width} x {height} pixels"), remedy));
    }
    let needed = (bytes + size_of::<f64>()) * width * height;
    if are_free(needed) {
        return Ok(());
    }
    let found = format!(
        "takes {} bytes to read, and the system has not so many",
        grouped(needed)
    );
    Err(Fault::content(
        found,
        "make it smaller: the size of the grid is enough",
    ))
}
