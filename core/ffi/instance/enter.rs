//! How a call enters what a handle points to, and how that ends.

use super::handle::{Handle, Place, mark};
use super::refusal::Refusal;
use crate::result::ThuribleResult;
use core::ffi::c_char;
use core::sync::atomic::Ordering;

/// Enters what a handle points to: one call at a time.
///
/// # Safety
/// `handle` is null or points to readable memory of the size of its place.
pub unsafe fn enter<H: Handle>(
    handle: *const H,
    work: impl FnOnce(&mut H::Body) -> Result<(), Refusal>,
) -> ThuribleResult {
    let place: *const Place<H::Body> = handle.cast();
    if place.is_null() {
        return ThuribleResult::Null;
    }
    if !place.is_aligned() {
        return ThuribleResult::Misaligned;
    }
    // SAFETY: aligned and readable; an atomic has no wrong pattern of bits.
    let found = unsafe { (&raw const (*place).mark).as_ref() };
    if found.is_none_or(|found| found.load(Ordering::Acquire) != mark(handle)) {
        return ThuribleResult::NoInstance;
    }
    // SAFETY: the mark says that here is a place.
    let Place {
        busy, body, refusal, ..
    } = unsafe { &*place };
    if busy.swap(true, Ordering::Acquire) {
        return ThuribleResult::Busy;
    }
    // SAFETY: `busy` was false and is true now, so nobody else is in the body.
    let body = unsafe { &mut *body.get() };
    let refused = work(body).err().unwrap_or(ThuribleResult::Ok.into());
    // SAFETY: as above.
    unsafe { refusal.get().write(refused) };
    busy.store(false, Ordering::Release);
    refused.result()
}

/// Ends what a handle points to, so that the handle is refused from now on.
///
/// # Safety
/// As [`enter`].
pub unsafe fn close<H: Handle>(handle: *mut H) -> ThuribleResult {
    // SAFETY: the caller's promise.
    let result = unsafe { enter(handle, |_| Ok(())) };
    if result == ThuribleResult::Ok {
        let place: *mut Place<H::Body> = handle.cast();
        // SAFETY: a place is there. It has nothing to give back: its memory is the caller's.
        unsafe { (*place).mark.store(0, Ordering::Release) };
    }
    result
}

/// Writes why the last call with a handle was refused.
///
/// # Safety
/// As [`enter`]; `buffer` is null or points to `size` bytes.
pub unsafe fn message<H: Handle>(handle: *const H, buffer: *mut c_char, size: usize) -> usize {
    let mut last = Refusal::Result(ThuribleResult::Ok);
    let read = |_: &mut H::Body| {
        let place: *const Place<H::Body> = handle.cast();
        // SAFETY: a call is in the place, and this is it.
        last = unsafe { (*place).refusal.get().read() };
        Err(last)
    };
    // SAFETY: the caller's promise.
    let found = unsafe { enter(handle, read) };
    if let (Refusal::Result(ThuribleResult::Ok), false) = (last, found == ThuribleResult::Ok) {
        last = found.into();
    }
    // SAFETY: the caller's promise.
    unsafe { crate::text::write(buffer, size, &last) }
}
