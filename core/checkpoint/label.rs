//! The first words of saved bytes: what they are, and a checksum of the head.

use super::mix::Mix;

/// Bytes before the fields, and of the block that all passes through: room for the scalars of a search with the most pairs of L-BFGS.
pub const HEAD: usize = 1024;
/// What the bytes begin with.
pub const MAGIC: u64 = u64::from_le_bytes(*b"thurible");
/// The format that is written, and the only one that is read.
pub const FORMAT: u64 = 7;
/// Words of what the bytes are: magic, format, bytes, fingerprint, checksum.
pub(super) const LABEL: usize = 5;
/// The checksum's place among them.
pub(super) const CHECKSUM: usize = 4;

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

    /// Whether `head` is the one that it was written for.
    #[must_use]
    pub fn fits(&self, head: &[u8; HEAD]) -> bool {
        self.checksum == checksum(head)
    }
}

/// The word at `index`, where there are so many.
pub(super) fn word_at(bytes: &[u8], index: usize) -> Option<u64> {
    let (word, _) = bytes.get(index * 8..)?.split_first_chunk::<8>()?;
    Some(u64::from_le_bytes(*word))
}

/// All bytes of a head but those of the checksum itself.
pub(super) fn checksum(head: &[u8; HEAD]) -> u64 {
    let mut sum = Mix::new();
    sum.bytes(head.get(..CHECKSUM * 8).unwrap_or(&[]));
    sum.bytes(head.get(LABEL * 8..).unwrap_or(&[]));
    sum.finish()
}
