//! The state of a solve as plain bytes, to go on from later and elsewhere with the same bits.
//!
//! A head of [`HEAD`] bytes holds words of 8 bytes: what the bytes are, a checksum of the head, every scalar of the state. The buffers
//! follow, each with the elements of its fields as they are and a checksum of its own, in [`CHECK`] bytes. All is little-endian. They pass piece
//! by piece, to a [`Sink`] or from a [`Source`], through one block of [`HEAD`] bytes, which is all the memory that it takes.
//!
//! Whoever has state passes over a list of it with a [`Record`]; the one list serves writing and reading, so that the two cannot
//! drift apart. Scalars come before buffers and are all checked before anything is changed.
//!
//! Of a state that ranks share each writes its part ([`save_parts`]), the first one with the head before it. Of each field there is
//! what a rank has of it and no other, filled up with zeros to as much as any has; the first one's part says how the field is cut before,
//! and has what all ranks have. Whoever goes on, one program or any number of ranks, reads what it needs out of all parts, or out of the state of one
//! program ([`restore_parts`]). Checksums are left to the files.

mod buffers;
mod error;
mod gather;
mod label;
mod mix;
mod parts;
mod record;
mod resumable;

pub use crate::memory::CHECK;
pub use buffers::Buffers;
pub use error::SavedError;
pub use gather::SavedParts;
pub use label::{FORMAT, HEAD, Label, MAGIC};
pub use mix::Mix;
pub use parts::{PartStore, restore_parts, save_parts};
pub use record::Record;
pub use resumable::{Resumable, restore, restore_from, save, save_to};

use crate::memory::Ledger;

/// Bytes of a checkpoint of what keeps these buffers, or `None` when they do not fit `usize`.
#[must_use]
pub fn bytes(ledger: &Ledger) -> Option<usize> {
    ledger.kept()?.checked_add(HEAD)
}

/// More than any count of iterations.
pub const MANY: usize = 1 << 30;

/// The bytes are not what was written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Damaged;

/// Bytes could not be put or taken: whose they are knows why.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Refused;

/// Where saved bytes go, one piece after the other.
pub trait Sink {
    /// Takes the next bytes, all of them.
    ///
    /// # Errors
    /// [`Refused`].
    fn put(&mut self, bytes: &[u8]) -> Result<(), Refused>;
}

/// Where saved bytes come from, one piece after the other.
pub trait Source {
    /// Fills `bytes` with the next ones.
    ///
    /// # Errors
    /// [`Refused`], also where there are too few.
    fn take(&mut self, bytes: &mut [u8]) -> Result<(), Refused>;
}

impl Sink for &mut [u8] {
    fn put(&mut self, bytes: &[u8]) -> Result<(), Refused> {
        let (here, rest) = core::mem::take(self)
            .split_at_mut_checked(bytes.len())
            .ok_or(Refused)?;
        here.copy_from_slice(bytes);
        *self = rest;
        Ok(())
    }
}

impl Source for &[u8] {
    fn take(&mut self, bytes: &mut [u8]) -> Result<(), Refused> {
        let (here, rest) = self.split_at_checked(bytes.len()).ok_or(Refused)?;
        bytes.copy_from_slice(here);
        *self = rest;
        Ok(())
    }
}

/// Why a pass over bytes ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Broken {
    /// They are not what was written.
    Damaged,
    /// They could not be put or taken.
    Refused,
}

impl From<Damaged> for Broken {
    fn from(Damaged: Damaged) -> Self {
        Self::Damaged
    }
}

impl From<Refused> for Broken {
    fn from(Refused: Refused) -> Self {
        Self::Refused
    }
}
