//! The state of a solve as plain bytes, to go on from later and elsewhere with the same bits.
//!
//! A head of [`HEAD`] bytes holds words of 8 bytes: what the bytes are, a checksum, every scalar of the state. The elements of the
//! fields follow as they are. All is little-endian. Whoever has state passes over a list of it with a [`Record`]; the one list
//! serves writing and reading, so that the two cannot drift apart. Scalars come before fields and are all checked before
//! anything is changed.

use crate::real::Real;

/// Bytes before the fields.
pub const HEAD: usize = 1024;
/// What the bytes begin with.
pub const MAGIC: u64 = u64::from_le_bytes(*b"thurible");
/// The format that is written, and the only one that is read.
pub const FORMAT: u64 = 3;
/// More than any count of iterations.
pub const MANY: usize = 1 << 30;
/// Words of what the bytes are: magic, format, bytes, fingerprint, checksum.
const LABEL: usize = 5;
/// The checksum's place among them.
const CHECKSUM: usize = 4;

/// The bytes are not what was written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Damaged;

enum Bytes<'a> {
    Write(&'a mut [u8]),
    Read(&'a [u8]),
}

/// Passes over a state to write it, or to read it back.
pub struct Record<'a> {
    bytes: Bytes<'a>,
    /// The next word of the head.
    word: usize,
    /// The next byte of the fields.
    at: usize,
}

impl<'a> Record<'a> {
    /// Writes into `bytes`, which have at least [`HEAD`].
    #[must_use]
    pub fn write(bytes: &'a mut [u8]) -> Self {
        if let Some(head) = bytes.get_mut(..HEAD) {
            head.fill(0);
        }
        Self {
            bytes: Bytes::Write(bytes),
            word: LABEL,
            at: HEAD,
        }
    }

    /// Reads back from `bytes` that [`Self::write`] filled.
    #[must_use]
    pub fn read(bytes: &'a [u8]) -> Self {
        Self {
            bytes: Bytes::Read(bytes),
            word: LABEL,
            at: HEAD,
        }
    }

    /// A word of the head.
    ///
    /// # Errors
    /// [`Damaged`] where the head is at its end.
    pub fn word(&mut self, value: &mut u64) -> Result<(), Damaged> {
        let (word, place) = (self.word, self.word * 8..self.word * 8 + 8);
        if place.end > HEAD {
            return Err(Damaged);
        }
        match &mut self.bytes {
            Bytes::Write(bytes) => bytes
                .get_mut(place)
                .ok_or(Damaged)?
                .copy_from_slice(&value.to_le_bytes()),
            Bytes::Read(bytes) => *value = word_at(bytes, word).ok_or(Damaged)?,
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

    /// The elements of a field. There are bytes for them: their count follows from the problem and was checked.
    pub fn elements<T: Real>(&mut self, elements: &mut [T]) {
        let place = self.at..self.at + elements.len() * T::BYTES;
        self.at = place.end;
        match &mut self.bytes {
            Bytes::Write(bytes) => {
                let bytes = bytes.get_mut(place).unwrap_or(&mut []);
                bytes
                    .chunks_exact_mut(T::BYTES)
                    .zip(elements)
                    .for_each(|(bytes, element)| element.write(bytes));
            }
            Bytes::Read(bytes) => {
                let bytes = bytes.get(place).unwrap_or(&[]);
                bytes
                    .chunks_exact(T::BYTES)
                    .zip(elements)
                    .for_each(|(bytes, element)| *element = T::read(bytes));
            }
        }
    }

    /// Bytes that head and fields take so far.
    #[must_use]
    pub fn bytes(&self) -> usize {
        self.at
    }

    /// Writes what the bytes are and their checksum, when all else is written.
    pub fn seal(self, fingerprint: u64) {
        if let Bytes::Write(bytes) = self.bytes {
            let label = [MAGIC, FORMAT, self.at as u64, fingerprint];
            for (place, word) in bytes.chunks_exact_mut(8).zip(label) {
                place.copy_from_slice(&word.to_le_bytes());
            }
            let sum = checksum(bytes);
            if let Some(place) = bytes.get_mut(CHECKSUM * 8..LABEL * 8) {
                place.copy_from_slice(&sum.to_le_bytes());
            }
        }
    }
}

/// What bytes say that they are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Label {
    /// First word: [`MAGIC`], or these are other bytes.
    pub magic: u64,
    /// Format of the bytes: [`FORMAT`], or they cannot be read.
    pub format: u64,
    /// Length of the whole, head included.
    pub bytes: u64,
    /// The problem and the choices that the state belongs to.
    pub fingerprint: u64,
    checksum: u64,
}

impl Label {
    /// Reads it, or `None` where there are too few bytes.
    #[must_use]
    pub fn of(bytes: &[u8]) -> Option<Self> {
        let word = |index| word_at(bytes, index);
        Some(Self {
            magic: word(0)?,
            format: word(1)?,
            bytes: word(2)?,
            fingerprint: word(3)?,
            checksum: word(CHECKSUM)?,
        })
    }

    /// Whether `bytes` are those that it was written for.
    #[must_use]
    pub fn fits(&self, bytes: &[u8]) -> bool {
        self.checksum == checksum(bytes)
    }
}

fn word_at(bytes: &[u8], index: usize) -> Option<u64> {
    let (word, _) = bytes.get(index * 8..)?.split_first_chunk::<8>()?;
    Some(u64::from_le_bytes(*word))
}

/// All bytes but those of the checksum itself.
fn checksum(bytes: &[u8]) -> u64 {
    let mut sum = Mix::new();
    sum.bytes(bytes.get(..CHECKSUM * 8).unwrap_or(&[]));
    sum.bytes(bytes.get(LABEL * 8..).unwrap_or(&[]));
    sum.finish()
}

/// Words mixed into one. Every step can be undone, so that one changed word always changes the end.
#[derive(Clone, Copy, Debug)]
pub struct Mix([u64; 4]);

impl Default for Mix {
    fn default() -> Self {
        Self::new()
    }
}

impl Mix {
    /// Nothing mixed in yet.
    #[must_use]
    pub fn new() -> Self {
        Self([1, 2, 3, 4])
    }

    fn step(lane: u64, word: u64) -> u64 {
        (lane ^ word).wrapping_mul(0x9E37_79B9_7F4A_7C15).rotate_left(29)
    }

    /// Mixes a word in.
    pub fn word(&mut self, word: u64) {
        let [a, b, c, d] = self.0;
        self.0 = [b, c, d, Self::step(a, word)];
    }

    /// Mixes the bits of a scalar in.
    pub fn real(&mut self, number: f64) {
        self.word(number.to_bits());
    }

    /// Mixes bytes in, four words at a time.
    fn bytes(&mut self, bytes: &[u8]) {
        let (blocks, rest) = bytes.as_chunks::<32>();
        for block in blocks {
            let (words, _) = block.as_chunks::<8>();
            for (lane, word) in self.0.iter_mut().zip(words) {
                *lane = Self::step(*lane, u64::from_le_bytes(*word));
            }
        }
        let mut last = [0; 32];
        last.iter_mut().zip(rest).for_each(|(to, &from)| *to = from);
        let (words, _) = last.as_chunks::<8>();
        words.iter().for_each(|word| self.word(u64::from_le_bytes(*word)));
        self.word(bytes.len() as u64);
    }

    /// The word that all those before were mixed into.
    #[must_use]
    pub fn finish(self) -> u64 {
        let all = self.0.into_iter().fold(0, Self::step);
        all ^ all >> 32
    }
}
