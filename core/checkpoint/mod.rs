//! The state of a solve as plain bytes, to go on from later and elsewhere with the same bits.
//!
//! A head of [`HEAD`] bytes holds words of 8 bytes: what the bytes are, a checksum of the head, every scalar of the state. The fields
//! follow, each with its elements as they are and a checksum of its own, in [`CHECK`] bytes. All is little-endian. They pass piece
//! by piece, to a [`Sink`] or from a [`Source`], through one block of [`HEAD`] bytes, which is all the memory that it takes.
//!
//! Whoever has state passes over a list of it with a [`Record`]; the one list serves writing and reading, so that the two cannot
//! drift apart. Scalars come before fields and are all checked before anything is changed.

mod error;
mod label;
mod mix;
mod resumable;

pub use crate::memory::CHECK;
pub use error::SavedError;
pub use label::{FORMAT, HEAD, Label, MAGIC};
pub use mix::Mix;
pub use resumable::{Resumable, restore, restore_from, save, save_to};

use crate::memory::Ledger;
use crate::real::Real;
use label::{CHECKSUM, LABEL, checksum, word_at};

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

enum Pass<'a> {
    Write(&'a mut dyn Sink),
    Read(&'a mut dyn Source),
    /// Reads, and changes no field.
    Check(&'a mut dyn Source),
}

/// Passes over a state to write it, or to read it back.
pub struct Record<'a> {
    pass: Pass<'a>,
    /// The head, and then what passes of fields.
    block: [u8; HEAD],
    /// The next word of the head.
    word: usize,
    /// Bytes that head and fields take so far.
    at: usize,
    /// What ended the pass over the fields.
    broken: Option<Broken>,
}

impl<'a> Record<'a> {
    fn new(pass: Pass<'a>, block: [u8; HEAD]) -> Self {
        Self {
            pass,
            block,
            word: LABEL,
            at: HEAD,
            broken: None,
        }
    }

    /// Writes to `sink`: scalars, [`Self::seal`], then fields.
    #[must_use]
    pub fn write(sink: &'a mut dyn Sink) -> Self {
        Self::new(Pass::Write(sink), [0; HEAD])
    }

    /// Reads scalars and fields back from `source`, whose `head` was taken already.
    #[must_use]
    pub fn read(head: [u8; HEAD], source: &'a mut dyn Source) -> Self {
        Self::new(Pass::Read(source), head)
    }

    /// As [`Self::read`], and leaves fields as they are.
    #[must_use]
    pub fn check(head: [u8; HEAD], source: &'a mut dyn Source) -> Self {
        Self::new(Pass::Check(source), head)
    }

    /// A word of the head.
    ///
    /// # Errors
    /// [`Damaged`] where the head is at its end.
    pub fn word(&mut self, value: &mut u64) -> Result<(), Damaged> {
        let place = self.block.get_mut(self.word * 8..self.word * 8 + 8);
        let place = place.ok_or(Damaged)?;
        match self.pass {
            Pass::Write(_) => place.copy_from_slice(&value.to_le_bytes()),
            Pass::Read(_) | Pass::Check(_) => *value = word_at(place, 0).ok_or(Damaged)?,
        }
        self.word += 1;
        Ok(())
    }

    /// A scalar in one word of the head.
    ///
    /// # Errors
    /// As [`Self::word`].
    pub fn real(&mut self, value: &mut f64) -> Result<(), Damaged> {
        let mut word = value.to_bits();
        self.word(&mut word)?;
        *value = f64::from_bits(word);
        Ok(())
    }

    /// A count from 0 to `most`.
    ///
    /// # Errors
    /// As [`Self::word`], and where it is above `most`.
    pub fn count(&mut self, value: &mut usize, most: usize) -> Result<(), Damaged> {
        let mut word = *value as u64;
        self.word(&mut word)?;
        *value = usize::try_from(word)
            .ok()
            .filter(|&count| count <= most)
            .ok_or(Damaged)?;
        Ok(())
    }

    /// Yes or no.
    ///
    /// # Errors
    /// As [`Self::count`].
    pub fn flag(&mut self, value: &mut bool) -> Result<(), Damaged> {
        let mut count = usize::from(*value);
        self.count(&mut count, 1)?;
        *value = count == 1;
        Ok(())
    }

    /// Whether there is a value, and the value, which `each` passes over.
    ///
    /// # Errors
    /// As [`Self::flag`] and `each`.
    pub fn option<V: Copy + Default>(
        &mut self,
        value: &mut Option<V>,
        each: impl FnOnce(&mut Self, &mut V) -> Result<(), Damaged>,
    ) -> Result<(), Damaged> {
        let (mut there, mut inner) = (value.is_some(), value.unwrap_or_default());
        self.flag(&mut there)?;
        each(self, &mut inner)?;
        *value = there.then_some(inner);
        Ok(())
    }

    /// The elements of a field, and its checksum. Nothing passes any more once something is wrong: [`Self::ended`] tells it.
    pub fn elements<T: Real>(&mut self, elements: &mut [T]) {
        if self.broken.is_none() && !elements.is_empty() {
            self.broken = self.field(elements).err();
            self.at += elements.len() * T::BYTES + CHECK;
        }
    }

    fn field<T: Real>(&mut self, elements: &mut [T]) -> Result<(), Broken> {
        let mut sum = Mix::new();
        for piece in elements.chunks_mut(HEAD / T::BYTES) {
            let block = self.block.get_mut(..piece.len() * T::BYTES).unwrap_or(&mut []);
            match &mut self.pass {
                Pass::Write(sink) => {
                    let places = block.chunks_exact_mut(T::BYTES);
                    places
                        .zip(piece)
                        .for_each(|(bytes, element)| element.write(bytes));
                    sink.put(block)?;
                }
                Pass::Read(source) => {
                    source.take(block)?;
                    let places = block.chunks_exact(T::BYTES);
                    places
                        .zip(piece)
                        .for_each(|(bytes, element)| *element = T::read(bytes));
                }
                Pass::Check(source) => source.take(block)?,
            }
            sum.bytes(block);
        }
        let (sum, mut said) = (sum.finish().to_le_bytes(), [0; CHECK]);
        match &mut self.pass {
            Pass::Write(sink) => return Ok(sink.put(&sum)?),
            Pass::Read(source) | Pass::Check(source) => source.take(&mut said)?,
        }
        if sum == said { Ok(()) } else { Err(Broken::Damaged) }
    }

    /// Bytes that head and fields take so far.
    #[must_use]
    pub fn bytes(&self) -> usize {
        self.at
    }

    /// Writes the head, when all scalars are there: what the bytes are, how many, and a checksum.
    ///
    /// # Errors
    /// [`Broken::Refused`].
    pub fn seal(&mut self, bytes: usize, fingerprint: u64) -> Result<(), Broken> {
        let label = [MAGIC, FORMAT, bytes as u64, fingerprint];
        for (place, word) in self.block.chunks_exact_mut(8).zip(label) {
            place.copy_from_slice(&word.to_le_bytes());
        }
        let sum = checksum(&self.block);
        if let Some(place) = self.block.get_mut(CHECKSUM * 8..LABEL * 8) {
            place.copy_from_slice(&sum.to_le_bytes());
        }
        match &mut self.pass {
            Pass::Write(sink) => Ok(sink.put(&self.block)?),
            Pass::Read(_) | Pass::Check(_) => Ok(()),
        }
    }

    /// How the pass over the fields went.
    ///
    /// # Errors
    /// [`Broken`]: what came after it did not pass.
    pub fn ended(&self) -> Result<(), Broken> {
        self.broken.map_or(Ok(()), Err)
    }
}
