//! What the calls have in common that explain, plan and make what a handle points to.

use super::handle::ALIGN;
use crate::config::ConfigError;
use crate::pointer::{put, required, writable};
use crate::result::ThuribleResult;
use crate::text;
use core::ffi::c_char;

/// Writes why a configuration is refused, or nothing where it is not; bytes of the whole text.
///
/// # Safety
/// `buffer` is null or points to `size` bytes to write.
pub unsafe fn explain<P>(planned: Result<P, ConfigError>, buffer: *mut c_char, size: usize) -> usize {
    match planned {
        // SAFETY: the caller's promise.
        Ok(_) => unsafe { text::write(buffer, size, &"") },
        // SAFETY: as above.
        Err(error) => unsafe { text::write(buffer, size, &error) },
    }
}

/// Writes the numbers of bytes that `plan` says to `counts`, and on which multiple of bytes the first of them begin to `alignment`; any of these
/// pointers may be null.
///
/// # Safety
/// They are null or may be written.
pub unsafe fn plan<const N: usize>(
    counts: [*mut usize; N],
    alignment: *mut usize,
    plan: impl FnOnce() -> Result<[usize; N], ConfigError>,
) -> ThuribleResult {
    let planned = || {
        counts.into_iter().chain([alignment]).try_for_each(writable)?;
        let found = plan().map_err(ConfigError::result)?;
        // SAFETY: the caller's promise; the places were checked.
        unsafe {
            for (place, count) in counts.into_iter().zip(found) {
                put(place, count);
            }
            put(alignment, ALIGN);
        }
        Ok(())
    };
    planned().err().unwrap_or(ThuribleResult::Ok)
}

/// Writes the handle that `make` makes to `out`, or null where it is refused.
///
/// # Safety
/// `out` is null or may be written.
pub unsafe fn init<H>(
    out: *mut *mut H,
    make: impl FnOnce() -> Result<*mut H, ThuribleResult>,
) -> ThuribleResult {
    if let Err(refused) = required(out) {
        return refused;
    }
    // SAFETY: the caller's promise; `out` was checked.
    unsafe {
        put(out, core::ptr::null_mut());
        match make() {
            Ok(handle) => {
                put(out, handle);
                ThuribleResult::Ok
            }
            Err(result) => result,
        }
    }
}
