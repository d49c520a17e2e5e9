//! Handles: what C holds of something in the caller's memory, and where that lies.

use super::refusal::Refusal;
use crate::result::ThuribleResult;
use core::cell::UnsafeCell;
use core::sync::atomic::{AtomicBool, AtomicUsize};
use thurible_core::Plan;

/// What a handle of C points to.
pub trait Handle {
    /// What is behind it.
    type Body;
    /// What marks it, together with its address.
    const MARK: usize;
}

/// The beginning of the caller's memory: what is entered by one call at a time.
#[repr(align(64))]
pub(super) struct Place<B> {
    pub mark: AtomicUsize,
    pub busy: AtomicBool,
    pub body: UnsafeCell<B>,
    /// Why the last call was refused, or that it was not.
    pub refusal: UnsafeCell<Refusal>,
}

/// Alignment of the caller's memory.
pub const ALIGN: usize = if Plan::ALIGN > 64 { Plan::ALIGN } else { 64 };

/// Where what is behind a handle may begin: after its place.
pub(super) const fn block<H: Handle>() -> usize {
    size_of::<Place<H::Body>>().next_multiple_of(ALIGN)
}

/// Bytes of a handle's place and of a block of `bytes` behind it.
///
/// # Errors
/// [`ThuribleResult::TooLarge`].
pub fn with_place<H: Handle>(bytes: usize) -> Result<usize, ThuribleResult> {
    let all = bytes.checked_add(const { block::<H>() });
    all.ok_or(ThuribleResult::TooLarge)
}

/// What `mark` holds in a place at this address, and nowhere else.
pub(super) fn mark<H: Handle>(handle: *const H) -> usize {
    H::MARK ^ handle.addr()
}
