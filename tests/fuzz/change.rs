//! Changes of good inputs: bits, bytes, numbers of every width, parts cut, doubled, moved, taken from another input; of texts their numbers and
//! words too.

use crate::random::Random;
use core::ops::Range;

/// Numbers that readers stumble over.
pub const ODD: [u64; 20] = [
    0,
    1,
    2,
    3,
    7,
    16,
    0x7F,
    0x80,
    0xFF,
    0x7FFF,
    0x8000,
    0xFFFF,
    0x10000,
    0x7FFF_FFFF,
    0x8000_0000,
    0xFFFF_FFFF,
    1 << 40,
    i64::MAX as u64,
    1 << 63,
    u64::MAX,
];

/// What stands in texts where it should not.
const WORDS: [&str; 28] = [
    "-1",
    "0",
    "1e400",
    "-0.0",
    "nan",
    "inf",
    "1e-320",
    "4096",
    "4097",
    "18446744073709551615",
    "-9223372036854775808",
    "true",
    "\"\"",
    "[]",
    "{}",
    "[[",
    "]]",
    "=",
    "\n",
    "'''",
    "\"\\u0000\"",
    "..",
    "/",
    "\u{202E}",
    "\u{FEFF}",
    "*",
    ",",
    "1979-05-27T07:32:00Z",
];

/// One of `seeds`, changed a few times.
pub fn changed(seeds: &[Vec<u8>], is_text: bool, random: &mut Random) -> Vec<u8> {
    let mut bytes = seeds.get(random.below(seeds.len())).cloned().unwrap_or_default();
    let other = seeds.get(random.below(seeds.len())).cloned().unwrap_or_default();
    for _ in 0..1 + random.below(4) {
        if is_text && random.below(3) > 0 {
            change_text(&mut bytes, random);
        } else {
            change(&mut bytes, &other, random);
        }
    }
    bytes
}

/// A part of so many bytes at most.
fn part(length: usize, most: usize, random: &mut Random) -> Range<usize> {
    let from = random.below(length + 1);
    let to = (from + random.below(most + 1)).min(length);
    from..to
}

fn change(bytes: &mut Vec<u8>, other: &[u8], random: &mut Random) {
    let at = random.below(bytes.len());
    match random.below(10) {
        0 if !bytes.is_empty() => bytes[at] ^= 1 << random.below(8),
        1 if !bytes.is_empty() => bytes[at] = random.next() as u8,
        2 | 3 => {
            // A number of 1, 2, 4 or 8 bytes, of either order.
            let width = 1 << random.below(4);
            let mut number = ODD[random.below(ODD.len())]
                .wrapping_add((random.below(3) as u64).wrapping_sub(1))
                .to_le_bytes();
            let number = &mut number[..width];
            if random.below(2) == 0 {
                number.reverse();
            }
            for (place, byte) in bytes.iter_mut().skip(at).zip(number) {
                *place = *byte;
            }
        }
        4 => bytes.truncate(at),
        5 => {
            let gone = part(bytes.len(), 64, random);
            bytes.drain(gone);
        }
        6 => {
            let doubled = part(bytes.len(), 64, random);
            let doubled = bytes[doubled].to_vec();
            bytes.splice(at..at, doubled);
        }
        7 => {
            let taken = part(other.len(), 256, random);
            let place = part(bytes.len(), 256, random);
            bytes.splice(place, other[taken].iter().copied());
        }
        8 => {
            let place = part(bytes.len(), 32, random);
            let value = random.next() as u8;
            bytes[place].fill(value);
        }
        _ => {
            let [one, two] = [part(bytes.len(), 32, random), part(bytes.len(), 32, random)];
            let (one, to) = (bytes[one].to_vec(), two.start.min(bytes.len()));
            bytes.splice(to..to, one);
        }
    }
}

/// Changes a number, a word or a line.
fn change_text(bytes: &mut Vec<u8>, random: &mut Random) {
    let text = String::from_utf8_lossy(bytes).into_owned();
    let word = WORDS[random.below(WORDS.len())];
    let changed = match random.below(4) {
        0 | 1 if let Some(number) = number_behind(text.as_bytes(), random.below(text.len() + 1)) => {
            [&text[..number.start], word, &text[number.end..]].concat()
        }
        _ if text.lines().next().is_none() => word.to_owned(),
        kind => {
            let mut lines: Vec<&str> = text.lines().collect();
            let one = random.below(lines.len());
            if kind == 2 {
                lines.insert(random.below(lines.len() + 1), lines[one]);
            } else {
                lines.remove(one);
            }
            lines.join("\n")
        }
    };
    *bytes = changed.into_bytes();
}

/// The first number of a text that begins at `from` or later, or else of all.
fn number_behind(text: &[u8], from: usize) -> Option<Range<usize>> {
    let is_of_number = |at: usize| {
        text.get(at)
            .is_some_and(|letter| letter.is_ascii_digit() || b"+-.e_".contains(letter))
    };
    let begins = |&at: &usize| is_of_number(at) && !(at > 0 && is_of_number(at - 1));
    let start = (from..text.len()).chain(0..from).find(begins)?;
    let length = (start..).take_while(|&at| is_of_number(at)).count();
    Some(start..start + length)
}
