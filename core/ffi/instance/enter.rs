//! How a call enters an instance, and how an instance ends.

use super::body::Body;
use super::handle::{Thurible, mark};
use super::refusal::Refusal;
use crate::result::ThuribleResult;
use core::ffi::c_char;
use core::sync::atomic::Ordering;

/// Enters an instance: one call at a time.
///
/// # Safety
/// `instance` is null or points to readable memory of an instance's size.
pub unsafe fn enter(
    instance: *const Thurible,
    work: impl FnOnce(&mut Body) -> Result<(), Refusal>,
) -> ThuribleResult {
    if instance.is_null() {
        return ThuribleResult::Null;
    }
    if !instance.is_aligned() {
        return ThuribleResult::Misaligned;
    }
    // SAFETY: aligned and readable; an atomic has no wrong pattern of bits.
    let found = unsafe { (&raw const (*instance).mark).as_ref() };
    if found.is_none_or(|found| found.load(Ordering::Acquire) != mark(instance)) {
        return ThuribleResult::NoInstance;
    }
    // SAFETY: the mark says that here is an instance.
    let Thurible { busy, body, .. } = unsafe { &*instance };
    if busy.swap(true, Ordering::Acquire) {
        return ThuribleResult::Busy;
    }
    // SAFETY: `busy` was false and is true now, so nobody else is in the body.
    let body = unsafe { &mut *body.get() };
    let refused = work(body).err().unwrap_or(ThuribleResult::Ok.into());
    body.refusal = refused;
    busy.store(false, Ordering::Release);
    refused.result()
}

/// Ends an instance, so that its handle is refused from now on.
///
/// # Safety
/// As [`enter`].
pub unsafe fn close(instance: *mut Thurible) -> ThuribleResult {
    // SAFETY: the caller's promise.
    let result = unsafe { enter(instance, |_| Ok(())) };
    if result == ThuribleResult::Ok {
        // SAFETY: an instance is there. It has nothing to give back: its memory is the caller's.
        unsafe { (*instance).mark.store(0, Ordering::Release) };
    }
    result
}

/// Writes why the last call that entered the instance was refused.
///
/// # Safety
/// As [`enter`]; `buffer` is null or points to `size` bytes.
pub unsafe fn message(instance: *const Thurible, buffer: *mut c_char, size: usize) -> usize {
    let mut last = Refusal::Result(ThuribleResult::Ok);
    let read = |body: &mut Body| {
        last = body.refusal;
        Err(last)
    };
    // SAFETY: the caller's promise.
    let found = unsafe { enter(instance, read) };
    if let (Refusal::Result(ThuribleResult::Ok), false) = (last, found == ThuribleResult::Ok) {
        last = found.into();
    }
    // SAFETY: the caller's promise.
    unsafe { crate::text::write(buffer, size, &last) }
}
