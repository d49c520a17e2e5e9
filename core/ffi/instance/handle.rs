//! The handle: what C holds of an instance, and where it lies in the caller's memory.

use super::body::Body;
use core::cell::UnsafeCell;
use core::sync::atomic::{AtomicBool, AtomicUsize};
use thurible_core::Plan;

/// A solve in memory of the caller: a handle, whose inside is the library's.
#[repr(align(64))]
pub struct Thurible {
    pub(super) mark: AtomicUsize,
    pub(super) busy: AtomicBool,
    pub(super) body: UnsafeCell<Body>,
}

/// What marks an instance, together with its address.
const MARK: usize = 0x5468_7572;
/// Alignment of the caller's memory.
pub const ALIGN: usize = if align_of::<Thurible>() > Plan::ALIGN {
    align_of::<Thurible>()
} else {
    Plan::ALIGN
};
/// Where the solver's block begins.
pub(super) const BLOCK: usize = size_of::<Thurible>().next_multiple_of(ALIGN);

/// What `mark` holds in an instance at this address, and nowhere else.
pub(super) fn mark(instance: *const Thurible) -> usize {
    MARK ^ instance.addr()
}
