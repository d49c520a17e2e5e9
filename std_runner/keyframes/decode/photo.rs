//! JPEG, TIFF and WebP, by the crate `image`; turned as the camera says.

use std::io::Cursor;

use image::metadata::Orientation;
use image::{DynamicImage, ImageDecoder, ImageFormat, ImageReader, Limits};

use super::pixels::{Pixels, Samples};
use super::room::{LONGEST_SIDE, check, most};
use super::tiff;
use crate::keyframes::error::Fault;

/// Whether a JPEG of so many pixels has more bytes than these: the mean of a block of 8 x 8 pixels takes a bit at least (ITU-T T.81, annex F),
/// and what is missing would be drawn in grey, for a second where it is much.
fn is_cut_off(width: u32, height: u32, bytes: usize) -> bool {
    let blocks = u64::from(width.div_ceil(8)) * u64::from(height.div_ceil(8));
    blocks / 8 > bytes as u64
}

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
    if format == ImageFormat::Jpeg && is_cut_off(width, height, bytes.len()) {
        let found = format!(
            "is {width} x {height} pixels, most of which {} bytes cannot hold",
            bytes.len()
        );
        return Err(Fault::content(found, "save it again"));
    }
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
    let mut pixels = Pixels {
        width,
        height,
        channels,
        samples,
        note: None,
    };
    if format == ImageFormat::Tiff && tiff::are_multiplied(bytes) {
        pixels.divide();
    }
    Ok(pixels)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_jpeg_of_many_pixels_in_few_bytes_is_cut_off() {
        assert!(is_cut_off(6641, 6641, 400));
        assert!(!is_cut_off(1920, 1080, 4050));
        assert!(is_cut_off(1920, 1080, 4049));
        let mut bytes = Vec::new();
        let flat = image::RgbImage::new(512, 512);
        let encoder = image::codecs::jpeg::JpegEncoder::new(&mut bytes);
        assert!(flat.write_with_encoder(encoder).is_ok());
        assert!(read(&bytes, ImageFormat::Jpeg).is_ok());
        // Height and width of the frame's header.
        let frame = bytes
            .windows(2)
            .position(|mark| mark == [0xff, 0xc0])
            .unwrap_or(0);
        bytes[frame + 5..frame + 9].copy_from_slice(&[0x10, 0, 0x10, 0]);
        let fault = read(&bytes, ImageFormat::Jpeg).err();
        let Some(Fault::Content { found, .. }) = fault else {
            unreachable!("{fault:?}");
        };
        assert!(
            found.starts_with("is 4096 x 4096 pixels, most of which"),
            "{found}"
        );
    }
}
