//! What the frames of a WebP promise, looked at before the library makes room for them: each says its size once more, and where its data end
//! too soon the library goes on with nothing.

use super::room;
use crate::keyframes::error::Fault;

/// Bytes that a pixel takes while it is decoded, without loss, with loss, and with loss and an alpha of its own.
const LOSSLESS: usize = 4 + 4;
const LOSSY: usize = 2 + 3;
const LOSSY_WITH_ALPHA: usize = 2 + 4 + 1 + 4;
/// Bytes of an animation's frame before its own parts.
const FRAME: usize = 16;

/// Refuses a file whose frames take more memory than it is worth.
pub(super) fn check(bytes: &[u8]) -> Result<(), Fault> {
    let file = bytes.len();
    let mut has_alpha = false;
    for (kind, part) in parts(bytes.get(12..).unwrap_or_default()) {
        let inner: Vec<_> = match kind {
            b"ANMF" => parts(part.get(FRAME..).unwrap_or_default()).collect(),
            _ => vec![(kind, part)],
        };
        for (kind, part) in inner {
            has_alpha |= kind == b"ALPH";
            let Some(([width, height], lossless)) = size(kind, part) else {
                continue;
            };
            let pixel = match (lossless, has_alpha) {
                (true, _) => LOSSLESS,
                (_, false) => LOSSY,
                (_, true) => LOSSY_WITH_ALPHA,
            };
            room::check(width, height, width * height * pixel, file)?;
        }
    }
    Ok(())
}

/// Parts one after the other, each with its name and all bytes from there on: the library reads a size wherever a part says that it ends.
fn parts(mut bytes: &[u8]) -> impl Iterator<Item = (&[u8; 4], &[u8])> {
    core::iter::from_fn(move || {
        let (kind, rest) = bytes.split_first_chunk::<4>()?;
        let (size, rest) = rest.split_first_chunk::<4>()?;
        let size = u32::from_le_bytes(*size) as usize;
        // What has an odd length ends at an even one.
        bytes = rest.get(size.saturating_add(size % 2)..).unwrap_or_default();
        Some((kind, rest))
    })
}

/// Width and height of a frame, and whether it is one without loss.
fn size(kind: &[u8; 4], part: &[u8]) -> Option<([usize; 2], bool)> {
    match kind {
        b"VP8 " => {
            let [a, b, c, d] = *part.get(6..)?.first_chunk()?;
            let side = |low, high| usize::from(u16::from_le_bytes([low, high]) & 0x3FFF);
            Some(([side(a, b), side(c, d)], false))
        }
        b"VP8L" => {
            let word = u32::from_le_bytes(*part.get(1..)?.first_chunk()?) as usize;
            Some(([(word & 0x3FFF) + 1, (word >> 14 & 0x3FFF) + 1], true))
        }
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn file(parts: &[(&[u8; 4], &[u8])]) -> Vec<u8> {
        let mut bytes = b"RIFF\0\0\0\0WEBP".to_vec();
        for (kind, part) in parts {
            bytes.extend(*kind);
            bytes.extend((part.len() as u32).to_le_bytes());
            bytes.extend(*part);
            bytes.resize(bytes.len().next_multiple_of(2), 0);
        }
        bytes
    }

    #[test]
    fn frames_of_more_pixels_than_the_file_is_worth_are_refused() {
        let lossy = |side: u16| {
            let [low, high] = side.to_le_bytes();
            vec![0x10, 0, 0, 0x9D, 1, 0x2A, low, high, low, high]
        };
        let lossless = |side: u32| {
            let word = (side - 1) << 14 | (side - 1);
            [&[0x2F][..], &word.to_le_bytes()].concat()
        };
        let canvas = [0_u8; 10];
        let (small, large) = (lossy(64), lossy(0x3FFF));
        assert!(
            check(&file(&[
                (b"VP8X", &canvas),
                (b"ALPH", &[1, 2, 3]),
                (b"VP8 ", &small)
            ]))
            .is_ok()
        );
        assert!(check(&file(&[(b"VP8 ", &large)])).is_err());
        assert!(
            check(&file(&[
                (b"VP8X", &canvas),
                (b"EXIF", &[1]),
                (b"VP8L", &lossless(8000))
            ]))
            .is_err()
        );
        assert!(check(&file(&[(b"VP8L", &lossless(2000))])).is_ok());
        // 3000 x 3000 with loss fits without an alpha, and not with one.
        assert!(check(&file(&[(b"VP8 ", &lossy(3000))])).is_ok());
        assert!(check(&file(&[(b"ALPH", &[0]), (b"VP8 ", &lossy(3000))])).is_err());
        // A part that says that it is empty.
        let mut empty = file(&[(b"VP8L", &lossless(8000))]);
        empty[16..20].fill(0);
        assert!(check(&empty).is_err());
        let frame = [&[0; FRAME][..], b"VP8 ", &[10, 0, 0, 0], &large].concat();
        assert!(check(&file(&[(b"ANMF", &frame)])).is_err());
    }
}
