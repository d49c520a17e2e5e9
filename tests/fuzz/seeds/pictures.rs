//! Good pictures, small ones, of each kind of file and of pixel; and a font.

use exr::prelude::*;
use image::{DynamicImage, ImageFormat, Luma, LumaA, Rgb, Rgba};
use std::io::Cursor;
use std::path::Path;
use tiff::encoder::{Compression as Packing, DeflateLevel, Predictor, TiffEncoder, colortype};
use tiff::tags::Tag;

/// Pictures of each kind of pixel.
pub fn pngs(_: &Path) -> Vec<Vec<u8>> {
    use png::{BitDepth, ColorType};
    let picture = |colour: ColorType, depth: BitDepth, bytes: usize| {
        let mut file = Vec::new();
        let mut encoder = png::Encoder::new(&mut file, 8, 8);
        encoder.set_color(colour);
        encoder.set_depth(depth);
        if colour == ColorType::Indexed {
            encoder.set_palette(vec![0, 0, 0, 255, 255, 255, 9, 9, 9]);
        }
        let mut writer = encoder.write_header().unwrap();
        let values: Vec<u8> = (0..bytes)
            .map(|index| {
                if colour == ColorType::Indexed {
                    1
                } else {
                    (index * 37 % 251) as u8
                }
            })
            .collect();
        writer.write_image_data(&values).unwrap();
        writer.finish().unwrap();
        file
    };
    vec![
        picture(ColorType::Grayscale, BitDepth::Eight, 64),
        picture(ColorType::Rgba, BitDepth::Eight, 256),
        picture(ColorType::Rgb, BitDepth::Sixteen, 384),
        picture(ColorType::Indexed, BitDepth::Eight, 64),
        picture(ColorType::GrayscaleAlpha, BitDepth::Sixteen, 256),
        picture(ColorType::Grayscale, BitDepth::One, 8),
    ]
}
/// A level of a pixel.
fn level(x: u32, y: u32) -> u8 {
    (31 * x + 17 * y) as u8
}

/// 8 x 8 pixels of several kinds.
fn plain() -> Vec<DynamicImage> {
    let clear = |x, y| LumaA([level(x, y), level(y, x).wrapping_mul(9)]);
    vec![
        image::ImageBuffer::from_fn(8, 8, |x, y| Luma([level(x, y)])).into(),
        image::ImageBuffer::from_fn(8, 8, clear).into(),
        image::ImageBuffer::from_fn(8, 8, |x, y| Rgb([level(x, y), level(y, x), 7])).into(),
        image::ImageBuffer::from_fn(8, 8, |x, y| Rgba([level(x, y), level(y, x), 7, level(x, x)])).into(),
    ]
}

fn written(pictures: impl IntoIterator<Item = DynamicImage>, format: ImageFormat) -> Vec<Vec<u8>> {
    let file = |picture: DynamicImage| {
        let mut file = Cursor::new(Vec::new());
        picture.write_to(&mut file, format).unwrap();
        file.into_inner()
    };
    pictures.into_iter().map(file).collect()
}

/// JPEG: grey, in colour, in passes with colours of half the size, with four inks.
pub fn jpegs(_: &Path) -> Vec<Vec<u8>> {
    let [grey, _, colour, _] = plain().try_into().unwrap();
    let mut files = written([grey, colour], ImageFormat::Jpeg);
    files.push(include_bytes!("progressive.jpg").to_vec());
    files.push(include_bytes!("cmyk.jpg").to_vec());
    files
}

/// WebP without loss, and one with loss and alpha.
pub fn webps(_: &Path) -> Vec<Vec<u8>> {
    let mut files = written(plain(), ImageFormat::WebP);
    files.push(include_bytes!("lossy.webp").to_vec());
    files
}

/// TIFF: packed in each way, levels of several widths.
pub fn tiffs(_: &Path) -> Vec<Vec<u8>> {
    // The library writes no grey with alpha.
    let [grey, _, colour, clear] = plain().try_into().unwrap();
    let mut files = written([grey, colour, clear], ImageFormat::Tiff);
    let packings = [
        Packing::Lzw,
        Packing::Packbits,
        Packing::Deflate(DeflateLevel::Fast),
    ];
    for packing in packings {
        let mut file = Cursor::new(Vec::new());
        let mut encoder = TiffEncoder::new(&mut file)
            .unwrap()
            .with_compression(packing)
            .with_predictor(Predictor::Horizontal);
        let levels: Vec<u16> = (0..64).map(|index| 1000 * index).collect();
        encoder.write_image::<colortype::Gray16>(8, 8, &levels).unwrap();
        files.push(file.into_inner());
    }
    let mut file = Cursor::new(Vec::new());
    let levels: Vec<f32> = (0..192).map(|index| index as f32 / 192.0).collect();
    TiffEncoder::new(&mut file)
        .unwrap()
        .write_image::<colortype::RGB32Float>(8, 8, &levels)
        .unwrap();
    files.push(file.into_inner());
    files.push(matte(&levels));
    files
}

/// One number a pixel, to be turned.
fn matte(levels: &[f32]) -> Vec<u8> {
    let mut file = Cursor::new(Vec::new());
    let mut encoder = TiffEncoder::new(&mut file).unwrap();
    let mut picture = encoder.new_image::<colortype::Gray32Float>(24, 8).unwrap();
    picture.encoder().write_tag(Tag::Orientation, 6_u16).unwrap();
    picture.write_data(levels).unwrap();
    file.into_inner()
}

/// EXR: packed in each way.
pub fn exrs(_: &Path) -> Vec<Vec<u8>> {
    let light = |place: Vec2<usize>| (place.x() as f32 / 8.0, 0.5_f32, f16::from_f32(place.y() as f32));
    let packings = [
        Compression::Uncompressed,
        Compression::RLE,
        Compression::ZIP1,
        Compression::ZIP16,
        Compression::PIZ,
        Compression::PXR24,
        Compression::B44,
    ];
    let lines = packings.map(|compression| Encoding {
        compression,
        blocks: Blocks::ScanLines,
        line_order: LineOrder::Increasing,
    });
    let tiles = Encoding {
        compression: Compression::ZIP16,
        blocks: Blocks::Tiles(Vec2(4, 4)),
        line_order: LineOrder::Increasing,
    };
    let file = |encoding: Encoding| {
        let channels = SpecificChannels::rgb(light);
        let attributes = LayerAttributes::default();
        let layer = Layer::new((8, 8), attributes, encoding, channels);
        let mut file = Cursor::new(Vec::new());
        Image::from_layer(layer)
            .write()
            .non_parallel()
            .to_buffered(&mut file)
            .unwrap();
        file.into_inner()
    };
    lines.into_iter().chain([tiles]).map(file).collect()
}

/// A font.
pub fn fonts(_: &Path) -> Vec<Vec<u8>> {
    vec![super::font::small(dejavu::sans::bold())]
}
