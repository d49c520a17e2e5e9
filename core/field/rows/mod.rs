//! Loops over rows of values: element by element, and reductions.

mod elementwise;
mod halves;
mod reductions;

pub use elementwise::*;
pub use halves::*;
pub use reductions::*;

use core::ops::Range;

/// The length of a piece of a row. What combines many fields does so piece by piece: long enough for each field to be read as a
/// stream, short enough for the result to stay in the first cache. A multiple of [`LANES`].
pub const PIECE: usize = 512;

/// The pieces of a row of `len` values.
pub fn pieces(len: usize) -> impl Iterator<Item = Range<usize>> {
    (0..len)
        .step_by(PIECE)
        .map(move |start| start..(start + PIECE).min(len))
}

/// A part of a field that may be left out as a whole: then there is nothing of it.
#[inline(always)]
pub fn part<T>(field: &[T], range: Range<usize>) -> &[T] {
    debug_assert!(field.is_empty() || range.end <= field.len());
    field.get(range).unwrap_or(&[])
}

/// As [`part`], to write.
#[inline(always)]
pub fn part_mut<T>(field: &mut [T], range: Range<usize>) -> &mut [T] {
    debug_assert!(field.is_empty() || range.end <= field.len());
    field.get_mut(range).unwrap_or(&mut [])
}
