//! Memory that a solution owns and NumPy's arrays borrow.

use core::mem::{MaybeUninit, size_of};
use thurible_core::Real;

/// A cache line, so that a block begins where the core wants it.
#[derive(Clone, Copy)]
#[repr(C, align(64))]
struct Line([MaybeUninit<u8>; LINE]);

const LINE: usize = 64;

/// Bytes that stay where they are until the block is dropped.
pub struct Block {
    lines: Vec<Line>,
    bytes: usize,
}

impl Block {
    /// Room for `bytes` bytes, or `None` if the system has not that much.
    pub fn new(bytes: usize) -> Option<Self> {
        let mut lines = Vec::new();
        lines.try_reserve_exact(bytes.div_ceil(LINE)).ok()?;
        Some(Self { lines, bytes })
    }

    /// All of it, to write.
    pub fn bytes_mut(&mut self) -> &mut [MaybeUninit<u8>] {
        let bytes = self.bytes;
        let spare = self.lines.spare_capacity_mut();
        assert!(bytes <= size_of_val(spare));
        // SAFETY: the capacity has `bytes` bytes, nobody else uses them while `self` is borrowed, and `MaybeUninit<u8>` needs neither
        // initialisation nor alignment.
        unsafe { core::slice::from_raw_parts_mut(spare.as_mut_ptr().cast(), bytes) }
    }

    /// The address of the first byte.
    pub fn address(&self) -> usize {
        self.lines.as_ptr().addr()
    }

    /// Number 0 of the `count` numbers that begin at byte `offset`.
    pub fn start<T: Real>(&self, offset: usize, count: usize) -> *const T {
        let end = count.checked_mul(size_of::<T>()).and_then(|size| size.checked_add(offset));
        assert!(offset.is_multiple_of(size_of::<T>()) && end.is_some_and(|end| end <= self.bytes));
        self.lines.as_ptr().cast::<u8>().wrapping_add(offset).cast()
    }
}
