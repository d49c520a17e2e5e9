//! JPEG, TIFF and WebP, by the crate `image`; turned as the camera says.

use std::io::Cursor;

use image::metadata::Orientation;
use image::{DynamicImage, ImageDecoder, ImageFormat, ImageReader, Limits};

use super::pixels::{Pixels, Samples};
use super::room::{LONGEST_SIDE, check, most};
use crate::keyframes::error::Fault;

/// Decodes a picture of this format.
pub(super) fn read(bytes: &[u8], format: ImageFormat) -> Result<Pixels, Fault> {
    let name = format
        .extensions_str()
        .first()
        .copied()
        .unwrap_or_default()
        .to_ascii_uppercase();
    let broken = |error: image::ImageError| {
        Fault::content(format!("cannot be read as {name} ({error})"), "save it as PNG")
    };
    let mut limits = Limits::no_limits();
    limits.max_image_width = Some(LONGEST_SIDE as u32);
    limits.max_image_height = Some(LONGEST_SIDE as u32);
    limits.max_alloc = Some(most(bytes.len()) as u64);
    let mut reader = ImageReader::with_format(Cursor::new(bytes), format);
    reader.limits(limits);
    let mut decoder = reader.into_decoder().map_err(broken)?;
    let (width, height) = decoder.dimensions();
    let size = usize::try_from(decoder.total_bytes()).unwrap_or(usize::MAX);
    check(width as usize, height as usize, size, bytes.len())?;
    let turn = decoder.orientation().unwrap_or(Orientation::NoTransforms);
    let mut picture = DynamicImage::from_decoder(decoder).map_err(broken)?;
    picture.apply_orientation(turn);
    let (width, height) = (picture.width() as usize, picture.height() as usize);
    let channels = usize::from(picture.color().channel_count());
    let samples = match picture {
        DynamicImage::ImageLuma8(all) => Samples::Narrow(all.into_raw()),
        DynamicImage::ImageLumaA8(all) => Samples::Narrow(all.into_raw()),
        DynamicImage::ImageRgb8(all) => Samples::Narrow(all.into_raw()),
        DynamicImage::ImageRgba8(all) => Samples::Narrow(all.into_raw()),
        DynamicImage::ImageLuma16(all) => Samples::Wide(all.into_raw()),
        DynamicImage::ImageLumaA16(all) => Samples::Wide(all.into_raw()),
        DynamicImage::ImageRgb16(all) => Samples::Wide(all.into_raw()),
        DynamicImage::ImageRgba16(all) => Samples::Wide(all.into_raw()),
        DynamicImage::ImageRgb32F(all) => Samples::Real(all.into_raw()),
        DynamicImage::ImageRgba32F(all) => Samples::Real(all.into_raw()),
        _ => return Err(Fault::content("has pixels of an unusual kind", "save it as PNG")),
    };
    Ok(Pixels {
        width,
        height,
        channels,
        samples,
        note: None,
    })
}
