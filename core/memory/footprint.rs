//! How many bytes a buffer takes.

/// Every buffer begins on a multiple of this many bytes.
pub const ALIGN: usize = 64;

/// Bytes that `len` values of `size` bytes take in a block, or `None` when that overflows.
#[must_use]
pub const fn footprint(len: usize, size: usize) -> Option<usize> {
    match len.checked_mul(size) {
        Some(bytes) => bytes.checked_next_multiple_of(ALIGN),
        None => None,
    }
}
