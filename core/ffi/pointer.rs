//! Pointers of the caller, checked as far as they can be.

use crate::result::ThuribleResult;
use core::ffi::c_void;
use thurible_core::Real;

/// Elements of a field of the caller, as a slice.
///
/// # Safety
/// `values` is null or points to `bytes` bytes that live as long as the call.
pub unsafe fn elements<'a, T: Real>(values: *const c_void, bytes: usize) -> Result<&'a [T], ThuribleResult> {
    let values: *const T = values.cast();
    if values.is_null() {
        return Err(ThuribleResult::Null);
    }
    if !values.is_aligned() {
        return Err(ThuribleResult::Misaligned);
    }
    if !bytes.is_multiple_of(T::BYTES) || bytes > isize::MAX as usize {
        return Err(ThuribleResult::Length);
    }
    // SAFETY: not null, aligned, and the caller promises the bytes; every pattern of bits is a floating-point number.
    Ok(unsafe { core::slice::from_raw_parts(values, bytes / T::BYTES) })
}

/// Flags of the caller, as a slice.
///
/// # Safety
/// `flags` is null or points to `bytes` bytes that live as long as the call.
pub unsafe fn flags<'a>(flags: *const u8, bytes: usize) -> Result<&'a [bool], ThuribleResult> {
    if flags.is_null() {
        return Err(ThuribleResult::Null);
    }
    if bytes > isize::MAX as usize {
        return Err(ThuribleResult::Length);
    }
    // SAFETY: not null, and the caller promises the bytes.
    let given = unsafe { core::slice::from_raw_parts(flags, bytes) };
    if given.iter().any(|&flag| flag > 1) {
        return Err(ThuribleResult::AboveOne);
    }
    // SAFETY: as above, and all bytes are 0 or 1, which are the two of `bool`.
    Ok(unsafe { core::slice::from_raw_parts(flags.cast(), bytes) })
}

/// An array of the caller to write, of exactly `count` elements. They are zero: a slice must not hold what was never written.
///
/// # Safety
/// `values` is null or points to `bytes` bytes to write that live as long as the call.
pub unsafe fn array<'a, T: Real>(
    values: *mut c_void,
    bytes: usize,
    count: usize,
) -> Result<&'a mut [T], ThuribleResult> {
    let values: *mut T = values.cast();
    required(values)?;
    if count.checked_mul(T::BYTES) != Some(bytes) {
        return Err(ThuribleResult::Length);
    }
    // SAFETY: not null, aligned, and the caller promises the bytes; all bits zero is a floating-point number.
    Ok(unsafe {
        values.write_bytes(0, count);
        core::slice::from_raw_parts_mut(values, count)
    })
}

/// Refuses a place that may be null but is misaligned, before anything is done.
pub fn writable<V>(place: *mut V) -> Result<(), ThuribleResult> {
    if place.is_null() || place.is_aligned() {
        Ok(())
    } else {
        Err(ThuribleResult::Misaligned)
    }
}

/// Refuses a place that is null or misaligned.
pub fn required<V>(place: *mut V) -> Result<(), ThuribleResult> {
    if place.is_null() {
        return Err(ThuribleResult::Null);
    }
    writable(place)
}

/// Writes to a place of the caller that is null or [`writable`].
///
/// # Safety
/// `place` is null, or aligned and may be written.
pub unsafe fn put<V>(place: *mut V, value: V) {
    if !place.is_null() {
        // SAFETY: not null, and the caller promises the rest.
        unsafe { place.write(value) };
    }
}
