//! The caller's memory, before anything is carved out of it.

use super::errors::SolverError;
use crate::memory::{ALIGN, Arena};
use core::mem::MaybeUninit;

/// The first `needed` bytes of `memory`, to be carved.
///
/// # Errors
/// [`SolverError::Misaligned`], [`SolverError::TooSmall`].
pub(crate) fn block(memory: &mut [MaybeUninit<u8>], needed: usize) -> Result<Arena<'_>, SolverError> {
    let given = memory.len();
    if !memory.as_ptr().addr().is_multiple_of(ALIGN) {
        return Err(SolverError::Misaligned);
    }
    let (memory, _) = memory
        .split_at_mut_checked(needed)
        .ok_or(SolverError::TooSmall { needed, given })?;
    Ok(Arena::new(memory))
}
