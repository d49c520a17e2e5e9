//! Blocks of values: packed or plain, full or half, all or the active ones alone.

use std::io::Read;

use flate2::read::ZlibDecoder;
use half::f16;

use super::bytes::{Bytes, broken};
use crate::keyframes::error::Fault;

/// How the values of a grid are kept.
#[derive(Clone, Copy)]
pub(super) struct Packing {
    /// Bits: 1 zip, 2 only active values, 4 Blosc.
    pub compression: u32,
    pub half: bool,
    pub background: f32,
}

/// Bits that say where something is.
#[derive(Clone, Copy)]
pub(super) struct Mask<'a>(pub &'a [u8]);

impl Mask<'_> {
    pub fn is_on(self, index: usize) -> bool {
        self.0
            .get(index / 8)
            .is_some_and(|byte| byte >> (index % 8) & 1 == 1)
    }

    pub fn count(self) -> usize {
        self.0.iter().map(|byte| byte.count_ones() as usize).sum()
    }

    pub fn all(self) -> impl Iterator<Item = usize> {
        (0..8 * self.0.len()).filter(move |&index| self.is_on(index))
    }
}

/// Reads `count` values of a node whose active ones `mask` tells.
pub(super) fn values(
    bytes: &mut Bytes<'_>,
    count: usize,
    mask: Mask<'_>,
    packing: Packing,
) -> Result<Vec<f32>, Fault> {
    let kind = bytes.byte()?;
    let mut first = if kind == 0 {
        packing.background
    } else {
        -packing.background
    };
    let mut second = packing.background;
    if matches!(kind, 2 | 4 | 5) {
        first = bytes.f32()?;
    }
    if kind == 5 {
        second = bytes.f32()?;
    }
    let selected = if matches!(kind, 3..=5) {
        bytes.take(count / 8)?
    } else {
        &[]
    };
    if kind > 6 {
        return Err(broken("a block of values is of an unknown kind"));
    }
    let packed = packing.compression & 2 != 0 && kind != 6;
    let kept = block(bytes, if packed { mask.count() } else { count }, packing)?;
    if !packed || kept.len() == count {
        return Ok(kept);
    }
    let mut kept = kept.into_iter();
    let inactive = |index: usize| {
        if Mask(selected).is_on(index) {
            second
        } else {
            first
        }
    };
    let value = |index: usize| {
        if mask.is_on(index) {
            kept.next().unwrap_or(first)
        } else {
            inactive(index)
        }
    };
    Ok((0..count).map(value).collect())
}

fn block(bytes: &mut Bytes<'_>, count: usize, packing: Packing) -> Result<Vec<f32>, Fault> {
    let size = if packing.half { 2 } else { 4 };
    // Nothing at all stands for no half values, a length of 0 for no full ones.
    if packing.half && count == 0 {
        return Ok(Vec::new());
    }
    let wanted = count * size;
    let raw = if packing.compression & 5 == 0 {
        bytes.take(wanted)?.to_vec()
    } else {
        let length = bytes.i64()?;
        let held = usize::try_from(length.unsigned_abs()).unwrap_or(usize::MAX);
        let held = bytes.take(held)?;
        let raw = if length <= 0 {
            held.to_vec()
        } else if packing.compression & 4 != 0 {
            blosc(held, wanted)?
        } else {
            let mut raw = Vec::with_capacity(wanted);
            let read = ZlibDecoder::new(held)
                .take(wanted as u64 + 1)
                .read_to_end(&mut raw);
            read.map_err(|error| broken(&error.to_string()))?;
            raw
        };
        if raw.len() != wanted {
            return Err(broken("a block of values has another length"));
        }
        raw
    };
    let words = raw.chunks_exact(size);
    Ok(words
        .map(|word| match *word {
            [a, b] => f16::from_le_bytes([a, b]).to_f32(),
            [a, b, c, d] => f32::from_le_bytes([a, b, c, d]),
            _ => 0.0,
        })
        .collect())
}

/// Unpacks a block of Blosc 1, packed by LZ4.
fn blosc(held: &[u8], wanted: usize) -> Result<Vec<u8>, Fault> {
    let mut head = Bytes(held);
    let (_, _, flags, size) = (head.byte()?, head.byte()?, head.byte()?, head.byte()? as usize);
    let (total, side, _) = (head.u32()? as usize, head.u32()? as usize, head.u32()?);
    if total != wanted {
        return Err(broken("a packed block has another length"));
    }
    if flags & 2 != 0 {
        return Ok(head.take(wanted)?.to_vec());
    }
    if flags >> 5 != 1 || flags & 4 != 0 || side == 0 || size == 0 {
        return Err(broken("a block is packed in another way than by LZ4"));
    }
    let mut whole = Vec::with_capacity(wanted);
    while whole.len() < wanted {
        let start = head.u32()? as usize;
        let length = side.min(wanted - whole.len());
        let splits = flags & 0x10 == 0 && length == side && size <= 16 && side / size >= 128;
        let parts = if splits { size } else { 1 };
        let mut source = Bytes(held.get(start..).unwrap_or_default());
        let mut plain = Vec::with_capacity(length);
        for _ in 0..parts {
            let bytes = source.u32()? as usize;
            let packed = source.take(bytes)?;
            if bytes == length / parts {
                plain.extend(packed);
                continue;
            }
            let mut part = vec![0; length / parts];
            let got = lz4_flex::block::decompress_into(packed, &mut part)
                .map_err(|error| broken(&error.to_string()))?;
            plain.extend(part.get(..got).unwrap_or_default());
        }
        if plain.len() != length {
            return Err(broken("a packed block has another length"));
        }
        if flags & 1 != 0 && size > 1 {
            unshuffled(&plain, size, &mut whole)
        } else {
            whole.extend(plain)
        }
    }
    Ok(whole)
}

/// Puts the bytes of each value together: first bytes of all stand first, then second ones. What is left over stays.
fn unshuffled(plain: &[u8], size: usize, whole: &mut Vec<u8>) {
    let count = plain.len() / size;
    for value in 0..count {
        whole.extend((0..size).filter_map(|byte| plain.get(byte * count + value)));
    }
    whole.extend(plain.get(count * size..).unwrap_or_default());
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two blocks of 8 bytes and one of 4, each as it is.
    fn packed(flags: u8, whole: &[u8]) -> Vec<u8> {
        let mut bytes = vec![2, 1, flags | 1 << 5 | 0x10, 4];
        for word in [whole.len(), 8, 0] {
            bytes.extend((word as u32).to_le_bytes());
        }
        let blocks: Vec<&[u8]> = whole.chunks(8).collect();
        let begin = bytes.len() + 4 * blocks.len();
        for block in 0..blocks.len() {
            bytes.extend(((begin + 12 * block) as u32).to_le_bytes());
        }
        for block in blocks {
            bytes.extend((block.len() as u32).to_le_bytes());
            bytes.extend(block);
        }
        bytes
    }

    #[test]
    fn the_last_block_may_be_shorter_and_bytes_are_shuffled_where_it_says_so() {
        let whole: Vec<u8> = (0..20).collect();
        assert_eq!(blosc(&packed(0, &whole), 20).ok(), Some(whole.clone()));
        let together = [0, 2, 4, 6, 1, 3, 5, 7];
        let shuffled: Vec<u8> = [0, 8]
            .iter()
            .flat_map(|first| together.map(|place| first + place))
            .collect();
        let expected = [shuffled, vec![16, 17, 18, 19]].concat();
        assert_eq!(blosc(&packed(1, &whole), 20).ok(), Some(expected));
        assert!(blosc(&packed(0, &whole), 24).is_err());
    }
}
