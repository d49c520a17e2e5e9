//! The caller's block of bytes, handed out once as aligned slices of zeros.
#![allow(unsafe_code)]

use super::footprint::{ALIGN, footprint};
use super::ledger::Ledger;
use core::mem::{MaybeUninit, size_of};

mod sealed {
    pub trait Sealed {}
    impl Sealed for u8 {}
    impl Sealed for f32 {}
    impl Sealed for f64 {}
    impl Sealed for u16 {}
    impl Sealed for u32 {}
    impl Sealed for u64 {}
    impl Sealed for usize {}
}

/// Numbers for which all bits zero is the value 0.
pub trait Plain: Copy + sealed::Sealed {}
impl Plain for u8 {}
impl Plain for f32 {}
impl Plain for f64 {}
impl Plain for u16 {}
impl Plain for u32 {}
impl Plain for u64 {}
impl Plain for usize {}

/// The block is too small.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TooSmall {
    /// Bytes that the next buffer needs.
    pub needed: usize,
    /// Bytes that are left.
    pub left: usize,
}

/// Hands out what is left of a block, front to back, or only counts what it is asked for; nothing is ever given back.
#[derive(Debug)]
pub struct Arena<'m> {
    rest: &'m mut [MaybeUninit<u8>],
    /// Where buffers are counted, in an arena that measures.
    ledger: Option<&'m mut Ledger>,
}

impl<'m> Arena<'m> {
    /// An arena over `memory`, which must begin on a multiple of [`ALIGN`].
    pub fn new(memory: &'m mut [MaybeUninit<u8>]) -> Self {
        Self {
            rest: memory,
            ledger: None,
        }
    }

    /// An arena that hands out empty slices and writes into `ledger` what it was asked for.
    pub fn measuring(ledger: &'m mut Ledger) -> Self {
        Self {
            rest: &mut [],
            ledger: Some(ledger),
        }
    }

    /// An arena over the bytes of `elements`, which hold whatever was written when it is gone.
    pub fn over<P: Plain>(elements: &'m mut [P]) -> Self {
        let len = size_of_val(elements);
        // SAFETY: the bytes are exclusively ours for 'm and any bytes are allowed as `MaybeUninit`; `take` is the only way to
        // write to them and leaves them initialised, and every pattern of bits is a value of a `Plain`.
        let memory =
            unsafe { core::slice::from_raw_parts_mut(elements.as_mut_ptr().cast::<MaybeUninit<u8>>(), len) };
        Self::new(memory)
    }

    /// Bytes that are left.
    #[must_use]
    pub fn left(&self) -> usize {
        self.rest.len()
    }

    /// The ledger of an arena that measures: its slices are empty, and there is nothing to fill.
    pub fn ledger(&mut self) -> Option<&mut Ledger> {
        self.ledger.as_deref_mut()
    }

    /// The same, when all is measured.
    #[must_use]
    pub fn into_ledger(self) -> Option<&'m mut Ledger> {
        self.ledger
    }

    /// Counts `len` values among those that a checkpoint keeps.
    pub(super) fn keep<P: Plain>(&mut self, len: usize) {
        if let Some(ledger) = self.ledger() {
            ledger.count_kept(len, size_of::<P>());
        }
    }

    /// The next `len` values, all zero; `name` is their line in the ledger.
    ///
    /// # Errors
    /// [`TooSmall`] when the block has fewer bytes left than [`footprint`] says, or begins unaligned.
    pub fn take<P: Plain>(&mut self, name: &'static str, len: usize) -> Result<&'m mut [P], TooSmall> {
        if let Some(ledger) = self.ledger() {
            ledger.line(name, len, size_of::<P>());
            return Ok(&mut []);
        }
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
    pub fn take_vector<P: Plain>(
        &mut self,
        name: &'static str,
        dims: usize,
        len: usize,
    ) -> Result<[&'m mut [P]; 3], TooSmall> {
        if let Some(ledger) = self.ledger() {
            ledger.vector(name, dims, len, size_of::<P>());
            return Ok(Default::default());
        }
        let mut field: [&'m mut [P]; 3] = Default::default();
        for component in field.iter_mut().take(dims) {
            *component = self.take(name, len)?;
        }
        Ok(field)
    }
}
