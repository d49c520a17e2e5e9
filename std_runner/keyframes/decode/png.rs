//! PNG.

use std::io::Cursor;

use png::{BitDepth, Decoder, Limits, Transformations};

use super::pixels::{Pixels, Samples};
use super::room::{check, most};
use crate::keyframes::error::Fault;

/// Decodes a PNG file.
pub(super) fn read(bytes: &[u8]) -> Result<Pixels, Fault> {
    let broken = |error: png::DecodingError| {
        Fault::content(format!("cannot be read as PNG ({error})"), "save it as PNG again")
    };
    let mut decoder = Decoder::new_with_limits(
        Cursor::new(bytes),
        Limits {
            bytes: most(bytes.len()),
        },
    );
    decoder.set_transformations(Transformations::EXPAND);
    let mut reader = decoder.read_info().map_err(broken)?;
    let size = reader.output_buffer_size().unwrap_or(usize::MAX);
    let header = reader.info();
    check(header.width as usize, header.height as usize, size, bytes.len())?;
    // The library counts on whole colours.
    if header
        .palette
        .as_ref()
        .is_some_and(|palette| palette.len() % 3 != 0)
    {
        return Err(Fault::content(
            "has a palette that ends inside a colour",
            "save it as PNG again",
        ));
    }
    let mut raw = vec![0; size];
    let frame = reader.next_frame(&mut raw).map_err(broken)?;
    raw.truncate(frame.buffer_size());
    let samples = match frame.bit_depth {
        BitDepth::Eight => Samples::Narrow(raw),
        BitDepth::Sixteen => Samples::Pairs(raw),
        _ => {
            return Err(Fault::content(
                "has an unusual depth",
                "save it with 8 or 16 bits a channel",
            ));
        }
    };
    Ok(Pixels {
        width: frame.width as usize,
        height: frame.height as usize,
        channels: frame.color_type.samples(),
        samples,
        note: None,
    })
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use png::{ColorType, Encoder};

    fn indexed(palette: &'static [u8]) -> Vec<u8> {
        let mut file = Vec::new();
        let mut encoder = Encoder::new(&mut file, 8, 8);
        encoder.set_color(ColorType::Indexed);
        encoder.set_depth(BitDepth::Eight);
        encoder.set_palette(palette);
        let mut writer = encoder.write_header().unwrap();
        writer.write_image_data(&[1; 64]).unwrap();
        writer.finish().unwrap();
        file
    }

    #[test]
    fn a_palette_that_ends_inside_a_colour_is_refused() {
        let read = read(&indexed(&[9; 6])).unwrap();
        assert_eq!((read.width, read.channels), (8, 3));
        assert!(super::read(&indexed(&[9; 7])).is_err());
    }
}
