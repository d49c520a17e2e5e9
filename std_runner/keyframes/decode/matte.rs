//! TIFF of one number a pixel in floating point or 32 bits, as mattes and depths are saved, which the crate `image` does not read; turned as
//! its tag `Orientation` says.

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
    let turn = decoder.find_tag_unsigned::<u16>(Tag::Orientation);
    let turn = turn.ok().flatten().unwrap_or(1);
    // Each number as it is read, as it is kept, and where it is turned to.
    let size = usize::from(bits) / 8 + size_of::<f32>() * if is_turned(turn) { 2 } else { 1 };
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
    let ([width, height], samples) = turned([width, height], samples, turn);
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

/// Whether a value of the tag `Orientation` says that a picture is to be turned. What it does not know says nothing.
fn is_turned(turn: u16) -> bool {
    (2..=8).contains(&turn)
}

/// A picture turned as the tag says: 2 mirrors left and right, 3 both, 4 top and bottom; from 5 to 8 rows become columns, and 7 and 8 begin
/// with the last of them, 6 and 7 with the last row (TIFF 6.0, Orientation).
fn turned([width, height]: [usize; 2], samples: Vec<f32>, turn: u16) -> ([usize; 2], Vec<f32>) {
    if !is_turned(turn) {
        return ([width, height], samples);
    }
    let size = if turn >= 5 {
        [height, width]
    } else {
        [width, height]
    };
    let stored = |x: usize, y: usize| {
        let [x, y] = if turn >= 5 { [y, x] } else { [x, y] };
        let x = if matches!(turn, 2 | 3 | 7 | 8) {
            width - 1 - x
        } else {
            x
        };
        let y = if matches!(turn, 3 | 4 | 6 | 7) {
            height - 1 - y
        } else {
            y
        };
        samples.get(y * width + x).copied().unwrap_or_default()
    };
    let rows = (0..size[1]).flat_map(|y| (0..size[0]).map(move |x| (x, y)));
    (size, rows.map(|(x, y)| stored(x, y)).collect())
}
