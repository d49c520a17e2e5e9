//! Memory that a solution owns and NumPy's arrays borrow.

use core::mem::{MaybeUninit, size_of};
use memmap2::{MmapMut, MmapRaw};
use pyo3::exceptions::PyMemoryError;
use pyo3::prelude::*;
use thurible::bytes::{are_free, grouped};
use thurible_core::Real;

/// Bytes that stay where they are, from the start of a page on, until the block is dropped; the system has them back then, which an
/// allocator does not promise.
pub struct Block {
    map: MmapRaw,
}

impl Block {
    /// Room for `bytes` bytes, or `None` if the system has not that much.
    pub fn new(bytes: usize) -> Option<Self> {
        Some(Self {
            map: MmapMut::map_anon(bytes).ok()?.into(),
        })
    }

    /// Room for the bytes of a plan of `what`, refused with a remedy where they are not free: the system grants more than there is, and
    /// ends the program when it is written to.
    pub fn planned(bytes: usize, what: &str, remedy: &str) -> PyResult<Self> {
        let block = if are_free(bytes) { Self::new(bytes) } else { None };
        block.ok_or_else(|| {
            PyMemoryError::new_err(format!(
                "{what} needs {} bytes, and the system has not so many free; close other programs, or {remedy}",
                grouped(bytes)
            ))
        })
    }

    /// All of it, to write.
    pub fn bytes_mut(&mut self) -> &mut [MaybeUninit<u8>] {
        // SAFETY: the map has so many bytes, nobody else uses them while `self` is borrowed, and `MaybeUninit<u8>` needs neither
        // initialisation nor alignment.
        unsafe { core::slice::from_raw_parts_mut(self.map.as_mut_ptr().cast(), self.map.len()) }
    }

    /// The address of the first byte.
    pub fn address(&self) -> usize {
        self.map.as_ptr().addr()
    }

    /// Number 0 of the `count` numbers that begin at byte `offset`.
    pub fn start<T: Real>(&self, offset: usize, count: usize) -> *const T {
        let end = count
            .checked_mul(size_of::<T>())
            .and_then(|size| size.checked_add(offset));
        assert!(offset.is_multiple_of(size_of::<T>()) && end.is_some_and(|end| end <= self.map.len()));
        self.map.as_ptr().wrapping_add(offset).cast()
    }
}
