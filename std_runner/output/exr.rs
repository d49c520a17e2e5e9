//! OpenEXR files of half-precision numbers without compression: light as it is, for compositing.
//!
//! The layout is that of "OpenEXR File Layout" (Academy Software Foundation): a header of attributes, the place of every line, and
//! lines whose channels are in the order of their names.

use super::render::Film;

const MAGIC: [u8; 4] = [0x76, 0x2f, 0x31, 0x01];
/// Version 2: one part of lines.
const VERSION: [u8; 4] = [2, 0, 0, 0];
/// The type of a channel of half-precision numbers.
const HALF: u32 = 1;
/// In the order of the file, and their places in a colour.
const CHANNELS: [(&[u8], usize); 3] = [(b"B", 2), (b"G", 1), (b"R", 0)];

/// The bytes of a file.
pub(super) fn exr(film: &Film) -> Vec<u8> {
    let mut bytes = header(film.width as u32, film.height as u32);
    let line = CHANNELS.len() * 2 * film.width;
    let first = bytes.len() + 8 * film.height;
    for row in 0..film.height {
        bytes.extend(((first + row * (8 + line)) as u64).to_le_bytes());
    }
    for (row, light) in film.light.chunks_exact(film.width).enumerate() {
        bytes.extend((row as u32).to_le_bytes());
        bytes.extend((line as u32).to_le_bytes());
        for (_, channel) in CHANNELS {
            let values = light.iter().filter_map(|colour| colour.get(channel));
            bytes.extend(values.flat_map(|&value| half(value).to_le_bytes()));
        }
    }
    bytes
}

fn header(width: u32, height: u32) -> Vec<u8> {
    let mut bytes = [MAGIC, VERSION].concat();
    let mut channels = Vec::new();
    for (name, _) in CHANNELS {
        channels.extend(name);
        channels.push(0);
        for number in [HALF, 0, 1, 1] {
            channels.extend(number.to_le_bytes());
        }
    }
    channels.push(0);
    let window: Vec<u8> = [0, 0, width - 1, height - 1]
        .into_iter()
        .flat_map(u32::to_le_bytes)
        .collect();
    let mut attribute = |name: &str, kind: &str, value: &[u8]| {
        for text in [name, kind] {
            bytes.extend(text.as_bytes());
            bytes.push(0);
        }
        bytes.extend((value.len() as u32).to_le_bytes());
        bytes.extend(value);
    };
    attribute("channels", "chlist", &channels);
    attribute("compression", "compression", &[0]);
    attribute("dataWindow", "box2i", &window);
    attribute("displayWindow", "box2i", &window);
    attribute("lineOrder", "lineOrder", &[0]);
    attribute("pixelAspectRatio", "float", &1.0_f32.to_le_bytes());
    attribute("screenWindowCenter", "v2f", &[0; 8]);
    attribute("screenWindowWidth", "float", &1.0_f32.to_le_bytes());
    bytes.push(0);
    bytes
}

/// The nearest half-precision number to a light, which is not negative; what is too large becomes the largest.
fn half(value: f32) -> u16 {
    const LARGEST: f32 = 65504.0;
    const SMALLEST_NORMAL: f32 = 6.103_515_6e-5;
    let value = value.clamp(0.0, LARGEST);
    if value < SMALLEST_NORMAL {
        return (value * 16_777_216.0).round() as u16;
    }
    // 10 bits of the fraction, rounded, and an exponent with a bias of 15 for one of 127.
    let bits = value.to_bits();
    let rounded = bits + 0x0fff + ((bits >> 13) & 1);
    ((rounded - (112 << 23)) >> 13) as u16
}

#[cfg(test)]
mod tests {
    use super::half;

    #[test]
    fn halves_are_the_nearest() {
        for (value, expected) in [
            (0.0, 0),
            (1.0, 0x3c00),
            (0.5, 0x3800),
            (65504.0, 0x7bff),
            (1e9, 0x7bff),
            (-1.0, 0),
            (1.0 + 0.6 / 1024.0, 0x3c01),
            (5.960_464_5e-8, 1),
        ] {
            assert_eq!(half(value), expected, "{value}");
        }
    }
}
