//! TIFF of one number a pixel in floating point or 32 bits, as mattes and depths are saved, which the crate `image` does not read; turned as
//! its tag `Orientation` says.

use image::metadata::Orientation;
use image::{ImageBuffer, Luma, imageops};
use std::io::Cursor;

use tiff::ColorType;
use tiff::decoder::{Decoder, DecodingResult, Limits};
use tiff::tags::Tag;

use super::pixels::{Pixels, Samples};
use super::room::{check, most};
use crate::keyframes::error::Fault;

/// Floating point, among the values of the tag `SampleFormat`.
const FLOATS: u16 = 3;

/// Decodes the picture, if it is one of these.
pub(super) fn read(bytes: &[u8]) -> Result<Option<Pixels>, Fault> {
    let Ok(decoder) = Decoder::new(Cursor::new(bytes)) else {
        return Ok(None);
    };
    let mut limits = Limits::default();
    limits.decoding_buffer_size = most(bytes.len());
    limits.intermediate_buffer_size = most(bytes.len());
    let mut decoder = decoder.with_limits(limits);
    let Ok(ColorType::Gray(bits)) = decoder.colortype() else {
        return Ok(None);
    };
    let formats = decoder.find_tag_unsigned_vec::<u16>(Tag::SampleFormat);
    let floats = matches!(formats, Ok(Some(formats)) if formats.contains(&FLOATS));
    if !floats && bits != 32 {
        return Ok(None);
    }
    let broken = |error| Fault::content(format!("cannot be read as TIFF ({error})"), "save it as PNG");
    let size = decoder.dimensions().map_err(broken)?;
    let (width, height) = (size.0 as usize, size.1 as usize);
    let turn = decoder.find_tag_unsigned::<u16>(Tag::Orientation);
    let turn = turn.ok().flatten().and_then(|turn| u8::try_from(turn).ok());
    // What it does not know says nothing.
    let turn = turn
        .and_then(Orientation::from_exif)
        .unwrap_or(Orientation::NoTransforms);
    // Each number as it is read, as it is kept, and where it is turned to.
    let each =
        usize::from(bits) / 8 + size_of::<f32>() * if turn == Orientation::NoTransforms { 1 } else { 2 };
    check(
        width,
        height,
        each.saturating_mul(width).saturating_mul(height),
        bytes.len(),
    )?;
    let samples = match decoder.read_image().map_err(broken)? {
        DecodingResult::F16(all) => all.into_iter().map(f32::from).collect(),
        DecodingResult::F32(all) => all,
        DecodingResult::F64(all) => all.into_iter().map(|level| level as f32).collect(),
        DecodingResult::U32(all) => all.into_iter().map(part).collect(),
        _ => return Err(Fault::content("has pixels of an unusual kind", "save it as PNG")),
    };
    let turned = turned(size.into(), samples, turn)
        .ok_or_else(|| Fault::content("has fewer pixels than it says", "save it as PNG"))?;
    Ok(Some(Pixels {
        width: turned.width() as usize,
        height: turned.height() as usize,
        channels: 1,
        samples: Samples::Real(turned.into_raw()),
        note: None,
    }))
}

/// The largest number is white.
fn part(level: u32) -> f32 {
    (f64::from(level) / f64::from(u32::MAX)) as f32
}

/// A picture as its tag says that it is to be turned, or nothing where it has not all of its pixels.
fn turned(
    [width, height]: [u32; 2],
    samples: Vec<f32>,
    turn: Orientation,
) -> Option<ImageBuffer<Luma<f32>, Vec<f32>>> {
    let picture = ImageBuffer::from_raw(width, height, samples)?;
    let mut turned = match turn {
        Orientation::NoTransforms | Orientation::FlipHorizontal | Orientation::FlipVertical => picture,
        Orientation::Rotate90 | Orientation::Rotate90FlipH => imageops::rotate90(&picture),
        Orientation::Rotate180 => imageops::rotate180(&picture),
        Orientation::Rotate270 | Orientation::Rotate270FlipH => imageops::rotate270(&picture),
    };
    match turn {
        Orientation::FlipHorizontal | Orientation::Rotate90FlipH | Orientation::Rotate270FlipH => {
            imageops::flip_horizontal_in_place(&mut turned);
        }
        Orientation::FlipVertical => imageops::flip_vertical_in_place(&mut turned),
        _ => {}
    }
    Some(turned)
}
