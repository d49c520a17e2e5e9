//! What the directory of a TIFF promises, looked at before the library makes room for it.

use crate::keyframes::error::Fault;

/// The numbers of a file of either order of bytes.
#[derive(Clone, Copy)]
struct Words<'a> {
    bytes: &'a [u8],
    big_endian: bool,
}

impl Words<'_> {
    /// The number of `size` bytes at `at`, at most 8.
    fn at(self, at: usize, size: usize) -> Option<u64> {
        let bytes = self.bytes.get(at..at.checked_add(size)?)?;
        let add = |sum: u64, &byte: &u8| sum << 8 | u64::from(byte);
        Some(if self.big_endian {
            bytes.iter().fold(0, add)
        } else {
            bytes.iter().rev().fold(0, add)
        })
    }
}

/// Refuses a file whose directory has an entry of more values than the file has bytes for. What else is wrong with it the library says.
pub(super) fn check(bytes: &[u8]) -> Result<(), Fault> {
    let held = bytes.len() as u64;
    match counts(bytes).find(|&(_, size)| size > held) {
        None => Ok(()),
        Some((tag, size)) => Err(Fault::content(
            format!("cannot be read as TIFF (its entry {tag} takes {size} bytes, more than the file)"),
            "save it as PNG",
        )),
    }
}

/// The tag that says what samples beyond the colours are, and its value where they are an alpha that colours are multiplied by.
const EXTRA_SAMPLES: u64 = 338;
const ASSOCIATED_ALPHA: u64 = 1;

/// Whether colours are multiplied by alpha in the file.
pub(super) fn are_multiplied(bytes: &[u8]) -> bool {
    let found = entries(bytes).find(|entry| entry.tag == EXTRA_SAMPLES);
    found.is_some_and(|entry| entry.first == Some(ASSOCIATED_ALPHA))
}

/// The tags of the first directory, each with the bytes of its values.
fn counts(bytes: &[u8]) -> impl Iterator<Item = (u64, u64)> {
    entries(bytes).map(|entry| (entry.tag, entry.bytes))
}

/// An entry of a directory.
struct Entry {
    tag: u64,
    /// Bytes of its values.
    bytes: u64,
    /// The first of them, where they are whole numbers.
    first: Option<u64>,
}

/// The entries of the first directory.
fn entries(bytes: &[u8]) -> impl Iterator<Item = Entry> {
    let words = Words {
        bytes,
        big_endian: bytes.starts_with(b"MM"),
    };
    // A large file has numbers of 8 bytes where others have 4.
    let large = words.at(2, 2) == Some(43);
    let (place, size) = if large { (8, 8) } else { (4, 4) };
    let (head, entry) = if large { (8, 20) } else { (2, 12) };
    let begin = words.at(place, size).and_then(|at| usize::try_from(at).ok());
    let count = begin.and_then(|begin| words.at(begin, head)).unwrap_or(0);
    let most = count.min(bytes.len() as u64 / entry as u64) as usize;
    (0..most).map_while(move |index| {
        let at = begin?.checked_add(head + index * entry)?;
        let each = width(words.at(at + 2, 2)?);
        let bytes = words.at(at + 4, size)?.saturating_mul(each);
        // What has no room in the entry is elsewhere.
        let field = at + 4 + size;
        let place = if bytes <= size as u64 {
            Some(field)
        } else {
            words.at(field, size).and_then(|at| usize::try_from(at).ok())
        };
        Some(Entry {
            tag: words.at(at, 2)?,
            bytes,
            first: place.and_then(|place| words.at(place, each as usize)),
        })
    })
}

/// Bytes of a value of a type.
fn width(kind: u64) -> u64 {
    match kind {
        3 | 8 => 2,
        4 | 9 | 11 | 13 => 4,
        5 | 10 | 12 | 16..=18 => 8,
        _ => 1,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A pixel of white smoke, half transparent, as both kinds of files keep it.
    #[test]
    fn colours_that_are_multiplied_are_divided() {
        let read = |extra: u16, colour: u8| {
            let mut bytes = b"II*\0\x08\0\0\0\x0a\0".to_vec();
            let entries: [(u16, u16, u32, u32); 10] = [
                (256, 3, 1, 1),
                (257, 3, 1, 1),
                (258, 3, 4, 134),
                (259, 3, 1, 1),
                (262, 3, 1, 2),
                (273, 4, 1, 142),
                (277, 3, 1, 4),
                (278, 3, 1, 1),
                (279, 4, 1, 4),
                (338, 3, 1, extra.into()),
            ];
            for (tag, kind, count, value) in entries {
                bytes.extend(tag.to_le_bytes());
                bytes.extend(kind.to_le_bytes());
                bytes.extend(count.to_le_bytes());
                bytes.extend(value.to_le_bytes());
            }
            bytes.extend([0; 4]);
            assert_eq!(bytes.len(), 134);
            bytes.extend([8, 0, 8, 0, 8, 0, 8, 0]);
            bytes.extend([colour, colour, colour, 128]);
            assert_eq!(are_multiplied(&bytes), extra == 1);
            let pixels = super::super::photo::read(&bytes, image::ImageFormat::Tiff);
            pixels.map(|pixels| pixels.all().collect::<Vec<_>>())
        };
        let white = vec![[255.0, 255.0, 255.0, 128.0]];
        for (extra, colour) in [(1, 128), (2, 255)] {
            let Ok(pixels) = read(extra, colour) else {
                unreachable!("it was refused");
            };
            assert_eq!(pixels, white);
        }
    }

    #[test]
    fn a_directory_that_promises_more_than_the_file_is_refused() {
        let file = |count: u32| {
            let mut bytes = b"II*\0\x08\0\0\0\x02\0".to_vec();
            for (kind, count) in [(3_u16, 1_u32), (4, count)] {
                bytes.extend(257_u16.to_le_bytes());
                bytes.extend(kind.to_le_bytes());
                bytes.extend(count.to_le_bytes());
                bytes.extend([0; 4]);
            }
            bytes
        };
        assert!(check(&file(8)).is_ok());
        let Err(Fault::Content { found, .. }) = check(&file(0x0056_0001)) else {
            unreachable!("it was taken");
        };
        assert!(found.contains("entry 257 takes 22544388 bytes"), "{found}");
        // The same in the other order of bytes, and with larger numbers.
        let mut large = b"MM\0+\0\x08\0\0\0\0\0\0\0\0\0\x10\0\0\0\0\0\0\0\x01".to_vec();
        large.extend([1, 1, 0, 12, 0, 0, 1, 0, 0, 0, 0, 0]);
        large.extend([0; 8]);
        assert!(check(&large).is_err());
        assert!(check(b"II*\0").is_ok());
    }
}
