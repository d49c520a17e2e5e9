//! TIFF of one number a pixel in floating point or 32 bits, as mattes and depths are saved, which the crate `image` does not read.

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
    let (width, height) = decoder.dimensions().map_err(broken)?;
    let (width, height) = (width as usize, height as usize);
    // Each number as it is read, and as it is kept.
    let size = usize::from(bits) / 8 + size_of::<f32>();
    check(
        width,
        height,
        size.saturating_mul(width).saturating_mul(height),
        bytes.len(),
    )?;
    let samples = match decoder.read_image().map_err(broken)? {
        DecodingResult::F16(all) => all.into_iter().map(f32::from).collect(),
        DecodingResult::F32(all) => all,
        DecodingResult::F64(all) => all.into_iter().map(|level| level as f32).collect(),
        DecodingResult::U32(all) => all.into_iter().map(part).collect(),
        _ => return Err(Fault::content("has pixels of an unusual kind", "save it as PNG")),
    };
    Ok(Some(Pixels {
        width,
        height,
        channels: 1,
        samples: Samples::Real(samples),
        note: None,
    }))
}

/// The largest number is white.
fn part(level: u32) -> f32 {
    (f64::from(level) / f64::from(u32::MAX)) as f32
}
