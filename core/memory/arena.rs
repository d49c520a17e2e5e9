//! The caller's block of bytes, handed out once as aligned slices of zeros.
#![allow(unsafe_code)]

use core::mem::{MaybeUninit, size_of};

/// Every buffer begins on a multiple of this many bytes.
pub const ALIGN: usize = 64;

mod sealed {
    pub trait Sealed {}
    impl Sealed for f32 {}
    impl Sealed for f64 {}
    impl Sealed for u16 {}
    impl Sealed for u32 {}
}

/// Numbers for which all bits zero is the value 0.
pub trait Plain: Copy + sealed::Sealed {}
impl Plain for f32 {}
impl Plain for f64 {}
impl Plain for u16 {}
impl Plain for u32 {}

/// The block is too small.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TooSmall {
    /// Bytes that the next buffer needs.
    pub needed: usize,
    /// Bytes that are left.
    pub left: usize,
}

/// Bytes that `len` values of `size` bytes take in an [`Arena`], or `None` when that overflows.
#[must_use]
pub const fn footprint(len: usize, size: usize) -> Option<usize> {
    match len.checked_mul(size) {
        Some(bytes) => bytes.checked_next_multiple_of(ALIGN),
        None => None,
    }
}

/// Hands out what is left of a block, front to back; nothing is ever given back.
#[derive(Debug)]
pub struct Arena<'m> {
    rest: &'m mut [MaybeUninit<u8>],
}

impl<'m> Arena<'m> {
    /// An arena over `memory`, which must begin on a multiple of [`ALIGN`].
    pub fn new(memory: &'m mut [MaybeUninit<u8>]) -> Self {
        Self { rest: memory }
    }

    /// An arena over the bytes of `numbers`, which hold whatever was written when it is gone.
    pub fn over<P: Plain>(numbers: &'m mut [P]) -> Self {
        let len = size_of_val(numbers);
        // SAFETY: the bytes are exclusively ours for 'm and any bytes are allowed as `MaybeUninit`; `take` is the only way to
        // write to them and leaves them initialised, and every pattern of bits is a value of a `Plain`.
        let memory =
            unsafe { core::slice::from_raw_parts_mut(numbers.as_mut_ptr().cast::<MaybeUninit<u8>>(), len) };
        Self { rest: memory }
    }

    /// Bytes that are left.
    #[must_use]
    pub fn left(&self) -> usize {
        self.rest.len()
    }

    /// The next `len` values, all zero.
    ///
    /// # Errors
    /// [`TooSmall`] when the block has fewer bytes left than [`footprint`] says, or begins unaligned.
    pub fn take<P: Plain>(&mut self, len: usize) -> Result<&'m mut [P], TooSmall> {
        let needed = footprint(len, size_of::<P>()).unwrap_or(usize::MAX);
        if needed > self.rest.len() || !self.rest.as_ptr().addr().is_multiple_of(ALIGN) {
            return Err(TooSmall {
                needed,
                left: self.rest.len(),
            });
        }
        let (taken, rest) = core::mem::take(&mut self.rest).split_at_mut(needed);
        self.rest = rest;
        taken.fill(MaybeUninit::new(0));
        // SAFETY: `taken` is exclusively ours for 'm, initialised to zero bytes (a value of every `Plain`), aligned to
        // 64 >= align_of::<P>(), and holds at least `len` values.
        Ok(unsafe { core::slice::from_raw_parts_mut(taken.as_mut_ptr().cast::<P>(), len) })
    }

    /// One buffer of `len` values for each of `dims` axes, the others empty: see [`Self::take`].
    ///
    /// # Errors
    /// [`TooSmall`].
    pub fn take_vector<P: Plain>(&mut self, dims: usize, len: usize) -> Result<[&'m mut [P]; 3], TooSmall> {
        let mut field: [&'m mut [P]; 3] = Default::default();
        for component in field.iter_mut().take(dims) {
            *component = self.take(len)?;
        }
        Ok(field)
    }
}
