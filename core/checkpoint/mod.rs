//! The state of a solve as plain bytes, to go on from later and elsewhere with the same bits.
//!
//! A head of [`HEAD`] bytes holds words of 8 bytes: what the bytes are, a checksum of the head, every scalar of the state. The buffers
//! follow, each with the elements of its fields as they are and a checksum of its own, in [`CHECK`] bytes. All is little-endian. They pass piece
//! by piece, to a [`Sink`] or from a [`Source`], through one block of [`HEAD`] bytes, which is all the memory that it takes.
//!
//! Whoever has state passes over a list of it with a [`Record`]; the one list serves writing and reading, so that the two cannot
//! drift apart. Scalars come before buffers and are all checked before anything is changed.
//!
//! Of a state that ranks share the first one writes what one program would write, and reads it: the others send it their parts, or are sent
//! them ([`Buffers`]). So any number of ranks goes on with it.

mod buffers;
mod error;
mod label;
mod mix;
mod resumable;

pub use crate::memory::CHECK;
pub use buffers::{Among, Buffers};
pub use error::SavedError;
pub use label::{FORMAT, HEAD, Label, MAGIC};
pub use mix::Mix;
pub use resumable::{Resumable, restore, restore_from, save, save_to};

use crate::exec::Ranks;
use crate::exec::ranks::tell;
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
    /// Reads, and changes nothing.
    Check(&'a mut dyn Source),
    /// Of a rank that follows: sends what the first one writes, or is sent what that one reads.
    Send,
    Receive,
}

/// Passes over a state to write it, or to read it back.
pub struct Record<'a> {
    pass: Pass<'a>,
    /// The head, and then what passes of buffers.
    block: [u8; HEAD],
    /// The next word of the head.
    word: usize,
    /// Bytes that head and buffers take so far.
    at: usize,
    /// Bytes of the current buffer that are not in the block yet, those in it, and those of them that were taken out again.
    left: usize,
    full: usize,
    taken: usize,
    /// The checksum of the current buffer.
    sum: Mix,
    /// What ended the pass over the buffers.
    broken: Option<Broken>,
}

impl<'a> Record<'a> {
    fn new(pass: Pass<'a>, block: [u8; HEAD]) -> Self {
        Self {
            pass,
            block,
            word: LABEL,
            at: HEAD,
            left: 0,
            full: 0,
            taken: 0,
            sum: Mix::new(),
            broken: None,
        }
    }

    /// Writes to `sink`: scalars, [`Self::seal`], then buffers.
    #[must_use]
    pub fn write(sink: &'a mut dyn Sink) -> Self {
        Self::new(Pass::Write(sink), [0; HEAD])
    }

    /// Reads scalars and buffers back from `source`, whose `head` was taken already.
    #[must_use]
    pub fn read(head: [u8; HEAD], source: &'a mut dyn Source) -> Self {
        Self::new(Pass::Read(source), head)
    }

    /// As [`Self::read`], and leaves fields as they are.
    #[must_use]
    pub fn check(head: [u8; HEAD], source: &'a mut dyn Source) -> Self {
        Self::new(Pass::Check(source), head)
    }

    /// Of a rank that follows: sends what the first one writes.
    #[must_use]
    pub fn send() -> Self {
        Self::new(Pass::Send, [0; HEAD])
    }

    /// Of a rank that follows: is sent what the first one reads, after its `head`.
    #[must_use]
    pub fn receive(head: [u8; HEAD]) -> Self {
        Self::new(Pass::Receive, head)
    }

    /// Whether nothing becomes what is read, so that one rank reads it alone.
    #[must_use]
    pub fn is_checked(&self) -> bool {
        matches!(self.pass, Pass::Check(_))
    }

    /// Whether fields become what is read.
    #[must_use]
    pub fn is_read(&self) -> bool {
        matches!(self.pass, Pass::Read(_) | Pass::Receive)
    }

    /// The head, until a buffer passes.
    #[must_use]
    pub fn head(&self) -> [u8; HEAD] {
        self.block
    }

    /// A word of the head.
    ///
    /// # Errors
    /// [`Damaged`] where the head is at its end.
    pub fn word(&mut self, value: &mut u64) -> Result<(), Damaged> {
        let place = self.block.get_mut(self.word * 8..self.word * 8 + 8);
        let place = place.ok_or(Damaged)?;
        match self.pass {
            Pass::Write(_) | Pass::Send => place.copy_from_slice(&value.to_le_bytes()),
            Pass::Read(_) | Pass::Check(_) | Pass::Receive => *value = word_at(place, 0).ok_or(Damaged)?,
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

    /// Begins a buffer of `len` elements.
    fn begin<T: Real>(&mut self, len: usize) {
        self.left = len * T::BYTES;
        (self.full, self.taken, self.sum) = (0, 0, Mix::new());
        if len > 0 {
            self.at += self.left + CHECK;
        }
    }

    /// The next elements of the buffer, so many, of which others have parts: they can be checked, but what one rank has is no state.
    fn pass_over<T: Real>(&mut self, len: usize) {
        if self.broken.is_none() {
            self.broken = match self.pass {
                Pass::Check(_) => self.skip(len * T::BYTES).err(),
                _ => Some(Broken::Refused),
            };
        }
    }

    /// The next elements of the buffer. Nothing passes any more once something is wrong: [`Self::ended`] tells it.
    fn elements<T: Real>(&mut self, elements: &mut [T]) {
        if self.broken.is_none() {
            let passed = match self.pass {
                Pass::Write(_) => self.put(elements),
                Pass::Read(_) => self.take(elements),
                Pass::Check(_) => self.skip(elements.len() * T::BYTES),
                Pass::Send | Pass::Receive => Ok(()),
            };
            self.broken = passed.err();
        }
    }

    fn put<T: Real>(&mut self, mut elements: &mut [T]) -> Result<(), Broken> {
        while !elements.is_empty() {
            let room = (HEAD - self.full) / T::BYTES;
            let next = elements.len().min(room);
            let split = core::mem::take(&mut elements).split_at_mut_checked(next);
            let (now, later) = split.ok_or(Broken::Damaged)?;
            let end = self.full + now.len() * T::BYTES;
            let places = self.block.get_mut(self.full..end).unwrap_or(&mut []);
            places
                .chunks_exact_mut(T::BYTES)
                .zip(&*now)
                .for_each(|(bytes, element)| element.write(bytes));
            self.filled(end)?;
            elements = later;
        }
        Ok(())
    }

    /// The block is full as far as `end`: it is put where it has no room any more, or where the buffer ends.
    fn filled(&mut self, end: usize) -> Result<(), Broken> {
        self.left = self.left.saturating_sub(end - self.full);
        self.full = end;
        if end == HEAD || self.left == 0 {
            let block = self.block.get(..end).unwrap_or(&[]);
            self.sum.bytes(block);
            self.full = 0;
            if let Pass::Write(sink) = &mut self.pass {
                sink.put(block)?;
            }
        }
        Ok(())
    }

    /// Bytes that are next in the block, at most so many; it is taken anew where it is empty.
    fn next(&mut self, most: usize) -> Result<&[u8], Broken> {
        if self.taken == self.full {
            let count = self.left.min(HEAD);
            let block = self.block.get_mut(..count).unwrap_or(&mut []);
            match &mut self.pass {
                Pass::Read(source) | Pass::Check(source) => source.take(block)?,
                Pass::Write(_) | Pass::Send | Pass::Receive => {}
            }
            self.sum.bytes(block);
            (self.left, self.full, self.taken) = (self.left - count, count, 0);
        }
        let begin = self.taken;
        self.taken = self.full.min(begin + most);
        let next = self.block.get(begin..self.taken).unwrap_or(&[]);
        if next.is_empty() {
            Err(Broken::Damaged)
        } else {
            Ok(next)
        }
    }

    fn take<T: Real>(&mut self, mut elements: &mut [T]) -> Result<(), Broken> {
        while !elements.is_empty() {
            let bytes = self.next(elements.len() * T::BYTES)?.chunks_exact(T::BYTES);
            let split = core::mem::take(&mut elements).split_at_mut_checked(bytes.len());
            let (now, later) = split.ok_or(Broken::Damaged)?;
            now.iter_mut()
                .zip(bytes)
                .for_each(|(element, bytes)| *element = T::read(bytes));
            elements = later;
        }
        Ok(())
    }

    fn skip(&mut self, mut bytes: usize) -> Result<(), Broken> {
        while bytes > 0 {
            bytes -= self.next(bytes)?.len();
        }
        Ok(())
    }

    /// Ends a buffer: what no field fills of it is 0, and its checksum follows. An empty one has none.
    fn end(&mut self, len: usize) {
        if self.broken.is_none() && len > 0 {
            self.broken = self.checked().err();
        }
    }

    fn checked(&mut self) -> Result<(), Broken> {
        match self.pass {
            Pass::Write(_) => {
                while self.left > 0 {
                    let end = HEAD.min(self.full + self.left);
                    self.block.get_mut(self.full..end).unwrap_or(&mut []).fill(0);
                    self.filled(end)?;
                }
            }
            Pass::Read(_) | Pass::Check(_) => self.skip(self.left + self.full - self.taken)?,
            Pass::Send | Pass::Receive => return Ok(()),
        }
        let (sum, mut said) = (self.sum.finish().to_le_bytes(), [0; CHECK]);
        match &mut self.pass {
            Pass::Write(sink) => return Ok(sink.put(&sum)?),
            Pass::Read(source) | Pass::Check(source) => source.take(&mut said)?,
            Pass::Send | Pass::Receive => return Ok(()),
        }
        if sum == said { Ok(()) } else { Err(Broken::Damaged) }
    }

    /// Ends the pass over the buffers of a rank that follows as it ended in the first one.
    fn agree(&mut self, ranks: &dyn Ranks) {
        let mut number = [match self.broken {
            None => 0usize,
            Some(Broken::Damaged) => 1,
            Some(Broken::Refused) => 2,
        }];
        tell(ranks, 0, &mut number);
        self.broken = match number {
            [0] => None,
            [1] => Some(Broken::Damaged),
            _ => Some(Broken::Refused),
        };
    }

    /// Bytes that head and buffers take so far.
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
            Pass::Read(_) | Pass::Check(_) | Pass::Send | Pass::Receive => Ok(()),
        }
    }

    /// How the pass over the buffers went.
    ///
    /// # Errors
    /// [`Broken`]: what came after it did not pass.
    pub fn ended(&self) -> Result<(), Broken> {
        self.broken.map_or(Ok(()), Err)
    }
}
