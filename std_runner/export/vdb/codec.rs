//! How OpenVDB packs a block of values: as it is, by zlib, or by Blosc with LZ4.

use flate2::Compression;
use flate2::write::ZlibEncoder;
use std::io::{self, Write};

/// The flag of a grid that only active values are written.
const ACTIVE_MASK: u32 = 2;
/// Blosc leaves blocks below so many bytes alone.
const SMALLEST: usize = 48;

/// How blocks are packed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Codec {
    /// Blosc with LZ4: small and fast.
    Blosc,
    /// zlib.
    Zip,
    /// As they are.
    None,
}

impl Codec {
    /// The compression word of a grid.
    pub fn word(self) -> u32 {
        ACTIVE_MASK
            + match self {
                Self::Blosc => 4,
                Self::Zip => 1,
                Self::None => 0,
            }
    }

    /// The name that OpenVDB gives it in metadata.
    pub fn name(self) -> &'static str {
        match self {
            Self::Blosc => "blosc + active values",
            Self::Zip => "zip + active values",
            Self::None => "active values",
        }
    }

    /// Writes `block`, whose values have `size` bytes each; `half` says that they are halves, of which an empty block is nothing at all.
    pub fn write(self, sink: &mut impl Write, block: &[u8], size: usize, half: bool) -> io::Result<()> {
        if self == Self::None || (half && block.is_empty()) {
            return sink.write_all(block);
        }
        let packed = match self {
            Self::Blosc => blosc(block, size),
            _ => zip(block)?,
        };
        // A negative count says that as many bytes follow as they are.
        let length = block.len() as i64;
        if packed.is_empty() || packed.len() >= block.len() {
            sink.write_all(&(-length).to_le_bytes())?;
            return sink.write_all(block);
        }
        sink.write_all(&(packed.len() as i64).to_le_bytes())?;
        sink.write_all(&packed)
    }
}

fn zip(block: &[u8]) -> io::Result<Vec<u8>> {
    let mut encoder = ZlibEncoder::new(Vec::new(), Compression::default());
    encoder.write_all(block)?;
    encoder.finish()
}

/// A Blosc chunk of one LZ4 block, its bytes shuffled; nothing where that is not worth it.
fn blosc(block: &[u8], size: usize) -> Vec<u8> {
    if block.len() < SMALLEST {
        return Vec::new();
    }
    let count = block.len() / size;
    let mut shuffled = vec![0; block.len()];
    for (byte, plane) in shuffled.chunks_exact_mut(count).enumerate() {
        let from = block.iter().skip(byte).step_by(size);
        plane.iter_mut().zip(from).for_each(|(to, &from)| *to = from);
    }
    let packed = lz4_flex::block::compress(&shuffled);
    const HEADER: u32 = 16;
    const START: u32 = HEADER + 4;
    let (bytes, length) = (block.len() as u32, packed.len() as u32);
    // Version 2, LZ4 format 1; shuffled, in one stream, by LZ4; bytes of a value.
    let mut chunk = vec![2, 1, 0x01 | 0x10 | (1 << 5), size as u8];
    for word in [bytes, bytes, START + 4 + length, START, length] {
        chunk.extend(word.to_le_bytes());
    }
    chunk.extend(packed);
    chunk
}

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a test")]
mod tests {
    use super::*;

    fn written(codec: Codec, block: &[u8], size: usize, half: bool) -> Vec<u8> {
        let mut bytes = Vec::new();
        codec.write(&mut bytes, block, size, half).unwrap();
        bytes
    }

    #[test]
    fn an_empty_block_is_a_zero_and_of_halves_nothing() {
        for codec in [Codec::Blosc, Codec::Zip] {
            assert_eq!(written(codec, &[], 4, false), [0; 8]);
            assert_eq!(written(codec, &[], 2, true), [0; 0]);
        }
        assert_eq!(written(Codec::None, &[], 4, false), [0; 0]);
    }

    #[test]
    fn what_does_not_shrink_is_written_as_it_is() {
        let block: Vec<u8> = (0..=255).map(|k: u8| k.wrapping_mul(k) ^ (k >> 3)).collect();
        for codec in [Codec::Blosc, Codec::Zip] {
            let bytes = written(codec, &block[..40], 4, false);
            assert_eq!(bytes[..8], (-40_i64).to_le_bytes());
            assert_eq!(bytes[8..], block[..40]);
        }
    }

    #[test]
    fn a_chunk_of_blosc_holds_the_shuffled_bytes() {
        let block: Vec<u8> = (0..96_u32).flat_map(|k| (k / 3).to_le_bytes()).collect();
        let bytes = written(Codec::Blosc, &block, 12, false);
        let (count, chunk) = bytes.split_at(8);
        assert_eq!(count, (chunk.len() as i64).to_le_bytes());
        assert_eq!(chunk[..4], [2, 1, 0x31, 12]);
        let word = |at: usize| u32::from_le_bytes(chunk[at..at + 4].try_into().unwrap()) as usize;
        assert_eq!(
            [word(4), word(8), word(12), word(16)],
            [block.len(), block.len(), chunk.len(), 20]
        );
        let shuffled = lz4_flex::block::decompress(&chunk[24..24 + word(20)], block.len()).unwrap();
        let back: Vec<u8> = (0..block.len())
            .map(|k| shuffled[k % 12 * (block.len() / 12) + k / 12])
            .collect();
        assert_eq!(back, block);
    }
}
