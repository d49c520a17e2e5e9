//! One pass over a state, to write it or to read it back.

use super::gather::{Gather, SavedParts, WHOLE};
use super::label::{CHECKSUM, FORMAT, HEAD, LABEL, MAGIC, checksum, word_at};
use super::mix::Mix;
use super::{Broken, CHECK, Damaged, Sink, Source};
use crate::memory::Held;
use crate::real::Real;

enum Pass<'a> {
    Write(&'a mut dyn Sink),
    Read(&'a mut dyn Source),
    /// Reads, and changes nothing.
    Check(&'a mut dyn Source),
    /// Writes the part of this rank.
    Part(&'a mut dyn Sink, usize),
    /// Reads out of parts what is needed here.
    Gather(Gather<'a>),
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

    /// Writes the part of `rank` to `sink`: scalars, [`Self::seal`], then buffers.
    #[must_use]
    pub fn part(sink: &'a mut dyn Sink, rank: usize) -> Self {
        Self::new(Pass::Part(sink, rank), [0; HEAD])
    }

    /// Reads scalars and buffers back from `saved`, whose `head` was taken already.
    #[must_use]
    pub fn gather(head: [u8; HEAD], saved: &'a mut dyn SavedParts) -> Self {
        Self::new(Pass::Gather(Gather::new(saved)), head)
    }

    /// Whether fields become what is read.
    #[must_use]
    pub fn is_read(&self) -> bool {
        matches!(self.pass, Pass::Read(_) | Pass::Gather(_))
    }

    /// Whether they are gathered from the parts of others.
    pub(super) fn is_gathered(&self) -> bool {
        matches!(self.pass, Pass::Gather(_))
    }

    /// A word of the head.
    ///
    /// # Errors
    /// [`Damaged`] where the head is at its end.
    pub fn word(&mut self, value: &mut u64) -> Result<(), Damaged> {
        let place = self.block.get_mut(self.word * 8..self.word * 8 + 8);
        let place = place.ok_or(Damaged)?;
        match self.pass {
            Pass::Write(_) | Pass::Part(..) => place.copy_from_slice(&value.to_le_bytes()),
            Pass::Read(_) | Pass::Check(_) | Pass::Gather(_) => {
                *value = word_at(place, 0).ok_or(Damaged)?;
            }
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

    /// Counts from 0 to `most`, which is below 256: eight of them in a word.
    ///
    /// # Errors
    /// As [`Self::count`].
    pub fn small_counts<'v>(
        &mut self,
        values: impl Iterator<Item = &'v mut usize>,
        most: usize,
    ) -> Result<(), Damaged> {
        let mut values = values.peekable();
        while values.peek().is_some() {
            let mut eight: [Option<&mut usize>; 8] = core::array::from_fn(|_| values.next());
            let byte = |value: &Option<&mut usize>| {
                value
                    .as_ref()
                    .map_or(0, |value| u8::try_from(**value).unwrap_or(u8::MAX))
            };
            let mut word = u64::from_le_bytes(eight.each_ref().map(byte));
            self.word(&mut word)?;
            for (value, byte) in eight.iter_mut().zip(word.to_le_bytes()) {
                let byte = usize::from(byte);
                match value {
                    Some(value) if byte <= most => **value = byte,
                    None if byte == 0 => {}
                    _ => return Err(Damaged),
                }
            }
        }
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
    pub(super) fn begin<T: Real>(&mut self, len: usize) {
        let bytes = len * T::BYTES;
        self.left = match &mut self.pass {
            // A part has what fields fill of it, and no more.
            Pass::Part(..) => usize::MAX,
            Pass::Gather(gather) => {
                gather.begin(bytes);
                0
            }
            _ => bytes,
        };
        (self.full, self.taken, self.sum) = (0, 0, Mix::new());
        if len > 0 {
            self.at += bytes + CHECK;
        }
    }

    /// The next field of the buffer, of which this program has what is `held`. Nothing passes any more once something is wrong: [`Self::ended`] tells
    /// it.
    pub(super) fn field<T: Real>(&mut self, values: &mut [T], held: Held) {
        if self.broken.is_some() || values.is_empty() {
            return;
        }
        let passed = match (&mut self.pass, held) {
            (Pass::Part(_, rank), _) => {
                let rank = *rank;
                self.put_part(rank, values, held)
            }
            (Pass::Gather(gather), _) => gather.take(&mut self.block, values, held),
            // What is only checked is read to its end.
            (Pass::Check(_), _) => self.skip(held.whole(values.len()) * T::BYTES),
            (Pass::Write(_), Held::All) => self.put(values),
            (Pass::Read(_), Held::All) => self.take(values),
            // A part alone is no state.
            (Pass::Write(_) | Pass::Read(_), Held::Part { .. }) => Err(Broken::Refused),
        };
        self.broken = passed.err();
    }

    /// The part of a rank: what it has of the field, after how that is cut where it is the first one.
    fn put_part<T: Real>(&mut self, rank: usize, values: &[T], held: Held) -> Result<(), Broken> {
        let Held::Part { parts, .. } = held else {
            // The first one writes it for all.
            return match rank {
                0 => self.put_words(WHOLE).and_then(|()| self.put(values)),
                _ => Ok(()),
            };
        };
        if rank == 0 {
            self.put_words(parts.words())?;
        }
        let own = parts.own(values.len());
        own.ranges()
            .try_for_each(|strip| self.put(values.get(strip).unwrap_or(&[])))?;
        let most = parts.most(parts.whole(values.len()));
        (own.total()..most).try_for_each(|_| self.put(&[T::ZERO]))
    }

    fn put_words(&mut self, words: [u64; 3]) -> Result<(), Broken> {
        words.into_iter().try_for_each(|word| {
            // In two halves: the block may have room for one of them.
            let bytes = word.to_le_bytes();
            bytes.chunks_exact(4).try_for_each(|half| {
                let end = self.full + half.len();
                let place = self.block.get_mut(self.full..end);
                place.ok_or(Broken::Damaged)?.copy_from_slice(half);
                self.filled(end)
            })
        })
    }

    fn put<T: Real>(&mut self, mut elements: &[T]) -> Result<(), Broken> {
        while !elements.is_empty() {
            let room = (HEAD - self.full) / T::BYTES;
            let next = elements.len().min(room);
            let (now, later) = elements.split_at_checked(next).ok_or(Broken::Damaged)?;
            let end = self.full + now.len() * T::BYTES;
            let places = self.block.get_mut(self.full..end).unwrap_or(&mut []);
            places
                .chunks_exact_mut(T::BYTES)
                .zip(now)
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
            self.full = 0;
            match &mut self.pass {
                Pass::Write(sink) => {
                    self.sum.bytes(block);
                    sink.put(block)?;
                }
                Pass::Part(sink, _) => sink.put(block)?,
                Pass::Read(_) | Pass::Check(_) | Pass::Gather(_) => {}
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
                Pass::Write(_) | Pass::Part(..) | Pass::Gather(_) => {}
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
    pub(super) fn end(&mut self, len: usize) {
        if self.broken.is_none() && len > 0 {
            self.broken = self.checked().err();
        }
    }

    fn checked(&mut self) -> Result<(), Broken> {
        match &mut self.pass {
            Pass::Write(_) => self.sealed(),
            Pass::Read(_) | Pass::Check(_) => self.compared(),
            Pass::Part(..) => {
                self.left = 0;
                self.filled(self.full)
            }
            Pass::Gather(gather) => {
                gather.end();
                Ok(())
            }
        }
    }

    fn sealed(&mut self) -> Result<(), Broken> {
        while self.left > 0 {
            let end = HEAD.min(self.full + self.left);
            self.block.get_mut(self.full..end).unwrap_or(&mut []).fill(0);
            self.filled(end)?;
        }
        let sum = self.sum.finish().to_le_bytes();
        match &mut self.pass {
            Pass::Write(sink) => Ok(sink.put(&sum)?),
            _ => Ok(()),
        }
    }

    fn compared(&mut self) -> Result<(), Broken> {
        self.skip(self.left + self.full - self.taken)?;
        let mut said = [0; CHECK];
        if let Pass::Read(source) | Pass::Check(source) = &mut self.pass {
            source.take(&mut said)?;
        }
        if self.sum.finish().to_le_bytes() == said {
            Ok(())
        } else {
            Err(Broken::Damaged)
        }
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
            Pass::Write(sink) | Pass::Part(sink, 0) => Ok(sink.put(&self.block)?),
            Pass::Part(..) | Pass::Read(_) | Pass::Check(_) | Pass::Gather(_) => Ok(()),
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
