//! Checksums are made right again, often, so that changes come to what is behind them.

use crate::change::ODD;
use crate::random::Random;
use crate::seeds::kept::{core_state, parts, state_sum};
use core::ops::Range;
use thurible_core::checkpoint::{CHECK, HEAD, Mix};

pub fn nothing(_: &mut [u8], _: &mut Random) {}

/// CRC-32 as PNG and zip have it.
fn crc(bytes: &[u8]) -> u32 {
    let mut sum = flate2::Crc::new();
    sum.update(bytes);
    sum.sum()
}

/// The checksums of the parts of a PNG, half of the time.
pub fn png(bytes: &mut [u8], random: &mut Random) {
    if random.below(2) == 0 {
        return;
    }
    let mut at = 8;
    while let Some(head) = bytes.get(at..at + 8) {
        let length = usize::try_from(u32::from_be_bytes(head[..4].try_into().unwrap())).unwrap();
        let Some(end) = at.checked_add(8 + length).filter(|end| end + 4 <= bytes.len()) else {
            break;
        };
        let sum = crc(&bytes[at + 4..end]);
        bytes[end..end + 4].copy_from_slice(&sum.to_be_bytes());
        at = end + 4;
    }
}

fn word(bytes: &[u8], at: usize) -> usize {
    let word = bytes
        .get(at..at + 4)
        .map_or([0; 4], |word| word.try_into().unwrap());
    usize::try_from(u32::from_le_bytes(word)).unwrap()
}

/// The checksums of stored members of a zip archive, half of the time: at the member and in the list at the end.
pub fn zip(bytes: &mut [u8], random: &mut Random) {
    if random.below(2) == 0 {
        return;
    }
    let starts = |kind: &[u8; 4], bytes: &[u8]| -> Vec<usize> {
        let windows = bytes.windows(4).enumerate();
        windows
            .filter(|(_, part)| part == kind)
            .map(|(at, _)| at)
            .collect()
    };
    let (members, listed) = (starts(b"PK\x03\x04", bytes), starts(b"PK\x01\x02", bytes));
    for (member, listed) in members.into_iter().zip(listed) {
        if bytes.len() < listed + 46 || bytes.get(member + 8..member + 10) != Some(&[0, 0]) {
            continue;
        }
        let lengths = word(bytes, member + 26);
        let begin = member + 30 + (lengths & 0xFFFF) + (lengths >> 16);
        let size = word(bytes, listed + 20);
        if let Some(held) = bytes.get(begin..begin.saturating_add(size)) {
            let sum = crc(held).to_le_bytes();
            bytes[member + 14..member + 18].copy_from_slice(&sum);
            bytes[listed + 16..listed + 20].copy_from_slice(&sum);
        }
    }
}

/// The checksums of saved bytes, mostly: that of the head, and of every field.
pub fn saved(bytes: &mut [u8], random: &mut Random) {
    if random.below(4) > 0 {
        mend_head(bytes);
    }
    if random.below(4) > 0 {
        mend_fields(bytes);
    }
}

fn mend_head(bytes: &mut [u8]) {
    let mut sum = Mix::new();
    sum.bytes(bytes.get(..32).unwrap_or(&[]));
    sum.bytes(bytes.get(40..HEAD).unwrap_or(&[]));
    if let Some(place) = bytes.get_mut(32..40) {
        place.copy_from_slice(&sum.finish().to_le_bytes());
    }
}

fn mend_fields(bytes: &mut [u8]) {
    let said = bytes.get(16..24).map(|word| word.try_into().unwrap());
    for part in parts(said.map_or(0, u64::from_le_bytes)) {
        let Some(field) = bytes.get_mut(part) else {
            continue;
        };
        if let Some((elements, place)) = field.split_last_chunk_mut::<CHECK>() {
            let mut sum = Mix::new();
            elements.chunks(HEAD).for_each(|piece| sum.bytes(piece));
            *place = sum.finish().to_le_bytes();
        }
    }
}

/// What the program remembers in a state: the second block behind the name.
fn remembered(state: &[u8]) -> Option<Range<usize>> {
    let block = |at: usize| Some(at + 8..(at + 8).checked_add(word(state, at))?);
    let words = block(block(16)?.end)?;
    (words.end <= state.len()).then_some(words)
}

/// The checksum of a state, mostly, and those of the saved bytes in it. Of what the program remembers a word is odd, half of the time.
pub fn state(bytes: &mut [u8], random: &mut Random) {
    if random.below(2) == 0
        && let Some(words) = remembered(bytes)
    {
        let at = words.start + 8 * random.below(words.len() / 8 + 1);
        let odd = ODD[random.below(ODD.len())].to_le_bytes();
        let places = bytes.iter_mut().skip(at + random.below(8) * random.below(2));
        places.zip(odd).for_each(|(place, byte)| *place = byte);
    }
    if let Some(held) = core_state(bytes).and_then(|begin| bytes.get_mut(begin..)) {
        saved(held, random);
    }
    if random.below(8) > 0
        && let Some((all, sum)) = bytes.split_last_chunk_mut::<8>()
    {
        *sum = state_sum(all).to_le_bytes();
    }
}
