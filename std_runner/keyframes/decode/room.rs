//! How large a picture may be.

use crate::bytes::{are_free, grouped, rounded};
use crate::keyframes::error::Fault;

/// Decoding may take so many bytes of memory whatever the file, and so many more for each byte of it: what takes more is no picture that
/// somebody drew or took, but a file that promises one.
const FREE: usize = 64 << 20;
const GROWTH: usize = 16;
/// Sides beyond this are refused before anything is decoded.
pub(super) const LONGEST_SIDE: usize = 16384;

/// Bytes that decoding a file of so many may take.
pub(super) fn most(file: usize) -> usize {
    file.saturating_mul(GROWTH).saturating_add(FREE)
}

/// Refuses a picture of so many pixels, which take so many `bytes` to decode, before it is decoded, if it is too large for a `file` of so
/// many bytes.
pub(super) fn check(width: usize, height: usize, bytes: usize, file: usize) -> Result<(), Fault> {
    if width > LONGEST_SIDE || height > LONGEST_SIDE {
        let remedy =
            format!("make it at most {LONGEST_SIDE} pixels wide and high; the size of the grid is enough");
        return Err(Fault::content(format!("is {width} x {height} pixels"), remedy));
    }
    let remedy = "make it smaller: the size of the grid is enough";
    let found = |why: &str| {
        format!(
            "is {width} x {height} pixels and takes {} bytes to read, {why}",
            grouped(bytes)
        )
    };
    if bytes > most(file) {
        let why = format!("more than {GROWTH} times the file and {}", rounded(FREE));
        return Err(Fault::content(found(&why), remedy));
    }
    if are_free(bytes) {
        return Ok(());
    }
    Err(Fault::content(found("and the system has not so many"), remedy))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_that_promises_more_than_it_can_hold_is_refused() {
        assert!(check(3840, 2160, 3840 * 2160 * 8, 20_000).is_ok());
        assert!(check(8192, 8192, 8192 * 8192 * 4, 12 << 20).is_ok());
        let fault = check(8192, 8192, 8192 * 8192 * 4, 20_000).err();
        let Some(Fault::Content { found, .. }) = fault else {
            unreachable!("{fault:?}");
        };
        assert!(
            found.ends_with("more than 16 times the file and 64.00 MiB"),
            "{found}"
        );
        assert!(check(LONGEST_SIDE + 1, 1, 1, 1).is_err());
    }
}
