//! The state of what is behind a handle as bytes, and back.

use super::refusal::Refusal;
use crate::result::ThuribleResult;
use core::ffi::c_void;
use thurible_core::checkpoint::{self, Resumable};

/// Saves the state of `one` into `bytes` of `size` bytes.
///
/// # Errors
/// [`Refusal`].
///
/// # Safety
/// `bytes` is null or points to `size` bytes to write.
pub unsafe fn save(one: &mut dyn Resumable, bytes: *mut c_void, size: usize) -> Result<(), Refusal> {
    if bytes.is_null() {
        return Err(ThuribleResult::Null.into());
    }
    let needed = one.saved_bytes();
    if size < needed {
        return Err(ThuribleResult::Length.into());
    }
    // SAFETY: the caller's promise. No byte is read before it is written, but a slice must not hold what was never written.
    let bytes = unsafe {
        bytes.cast::<u8>().write_bytes(0, needed);
        core::slice::from_raw_parts_mut(bytes.cast::<u8>(), needed)
    };
    Ok(checkpoint::save(one, bytes)?)
}

/// Goes on from `bytes` of `size` bytes.
///
/// # Errors
/// [`Refusal`].
///
/// # Safety
/// `bytes` is null or points to `size` bytes.
pub unsafe fn restore(one: &mut dyn Resumable, bytes: *const c_void, size: usize) -> Result<(), Refusal> {
    if bytes.is_null() {
        return Err(ThuribleResult::Null.into());
    }
    if size > isize::MAX as usize {
        return Err(ThuribleResult::Length.into());
    }
    // SAFETY: not null, and the caller promises the bytes.
    let bytes = unsafe { core::slice::from_raw_parts(bytes.cast::<u8>(), size) };
    Ok(checkpoint::restore(one, bytes)?)
}
