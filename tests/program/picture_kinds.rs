//! Pictures of every kind: the same disc from each, and no file is trusted.

use super::shape_keys::folder;
use exr::prelude::WritableImage;
use image::{ImageFormat, Luma, Rgba};
use std::fs;
use std::io::Write;
use std::path::Path;
use thurible::keyframes::{Canvas, Note, ShapeSpec};
use tiff::encoder::colortype::{ColorType, Gray16, Gray32Float};
use tiff::encoder::{TiffEncoder, TiffValue};
use tiff::tags::Tag;

const SIDE: u32 = 64;

fn inside(x: u32, y: u32) -> bool {
    (f64::from(x) - 19.5).hypot(f64::from(y) - 24.5) < 12.0
}

fn box_of(cells: usize) -> Canvas {
    Canvas {
        cells: vec![cells; 2],
        periodic: vec![false; 2],
        length: 1.0,
    }
}

fn draw(base: &Path, name: &str) -> (Vec<f64>, Vec<Note>) {
    let spec: ShapeSpec = toml::from_str(&format!("image = \"{name}\"")).unwrap();
    let mut notes = Vec::new();
    let cells = spec.rasterise_noting(&box_of(64), base, &mut notes);
    (cells.unwrap_or_else(|error| panic!("{name}: {error}")), notes)
}

/// A disc of half density in 16 bits, a full one in 8, in every kind of file.
fn write_all(base: &Path) -> Vec<&'static str> {
    let grey = image::ImageBuffer::from_fn(SIDE, SIDE, |x, y| Luma([if inside(x, y) { 255_u8 } else { 0 }]));
    let wide = image::ImageBuffer::from_fn(SIDE, SIDE, |x, y| {
        Luma([if inside(x, y) { 32769_u16 } else { 0 }])
    });
    let clear = image::ImageBuffer::from_fn(SIDE, SIDE, |x, y| {
        Rgba([9, 9, 9, if inside(x, y) { 255_u8 } else { 0 }])
    });
    grey.save_with_format(base.join("a.jpg"), ImageFormat::Jpeg)
        .unwrap();
    wide.save_with_format(base.join("wide.tif"), ImageFormat::Tiff)
        .unwrap();
    let mut file = fs::File::create(base.join("matte.tif")).unwrap();
    let matte: Vec<f32> = wide.iter().map(|level| f32::from(*level) / 65535.0).collect();
    TiffEncoder::new(&mut file)
        .unwrap()
        .write_image::<Gray32Float>(SIDE, SIDE, &matte)
        .unwrap();
    clear
        .save_with_format(base.join("a.webp"), ImageFormat::WebP)
        .unwrap();
    // A name says nothing.
    clear
        .save_with_format(base.join("webp.png"), ImageFormat::WebP)
        .unwrap();
    exr::prelude::Image::from_channels(
        (SIDE as usize, SIDE as usize),
        exr::prelude::SpecificChannels::rgb(|place: exr::prelude::Vec2<usize>| {
            // Lighter than white is white.
            let light = if inside(place.x() as u32, place.y() as u32) {
                4.0_f32
            } else {
                0.0
            };
            (light, light, light)
        }),
    )
    .write()
    .to_file(base.join("a.exr"))
    .unwrap();
    let circle = "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 64 64\"><circle cx=\"20\" cy=\"25\" r=\"12\"/></svg>";
    fs::write(base.join("a.svg"), circle).unwrap();
    let mut packed = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::default());
    packed.write_all(circle.as_bytes()).unwrap();
    fs::write(base.join("a.svgz"), packed.finish().unwrap()).unwrap();
    vec![
        "a.jpg",
        "wide.tif",
        "matte.tif",
        "a.webp",
        "webp.png",
        "a.exr",
        "a.svg",
        "a.svgz",
    ]
}

#[test]
fn every_kind_of_picture_gives_the_disc() {
    let base = folder("picture_kinds");
    for name in write_all(&base) {
        let (cells, notes) = draw(&base, name);
        let full = if ["wide.tif", "matte.tif"].contains(&name) {
            32769.0 / 65535.0
        } else {
            1.0
        };
        for (index, cell) in cells.iter().enumerate() {
            let (x, y) = (index as u32 % SIDE, SIDE - 1 - index as u32 / SIDE);
            let away = ((f64::from(x) - 19.5).hypot(f64::from(y) - 24.5) - 12.0).abs();
            let wanted = if inside(x, y) { full } else { 0.0 };
            // JPEG rings beside edges; curves have soft ones.
            let error = match name {
                "a.jpg" => 0.15,
                "a.svg" | "a.svgz" if away < 1.5 => 1.0,
                "matte.tif" => 1e-7,
                _ => 1e-9,
            };
            assert!(
                (cell - wanted).abs() <= error,
                "{name}: {cell} at {x}, {y}, not {wanted}"
            );
        }
        let taken = if ["a.webp", "webp.png", "a.svg", "a.svgz"].contains(&name) {
            "alpha"
        } else {
            "luminance"
        };
        assert!(notes[0].text.contains(taken), "{name}: {notes:?}");
    }
}

/// A TIFF of these levels, with its tag of orientation.
fn write_turned<C: ColorType>(path: &Path, turn: u16, levels: &[C::Inner])
where
    [C::Inner]: TiffValue,
{
    let mut file = fs::File::create(path).unwrap();
    let mut encoder = TiffEncoder::new(&mut file).unwrap();
    let mut picture = encoder.new_image::<C>(4, 3).unwrap();
    picture.encoder().write_tag(Tag::Orientation, turn).unwrap();
    picture.write_data(levels).unwrap();
}

#[test]
fn mattes_are_turned_as_other_tiffs_are() {
    let base = folder("picture_turns");
    let levels: Vec<u16> = (0..12).map(|index| 5461 * index).collect();
    let matte: Vec<f32> = levels.iter().map(|&level| f32::from(level) / 65535.0).collect();
    let mut seen = Vec::new();
    // 9 is no orientation, and turns nothing.
    for turn in 1..=9 {
        write_turned::<Gray16>(&base.join("wide.tif"), turn, &levels);
        write_turned::<Gray32Float>(&base.join("matte.tif"), turn, &matte);
        let [wanted, found] = ["wide.tif", "matte.tif"].map(|name| draw(&base, name).0);
        let apart = wanted
            .iter()
            .zip(&found)
            .map(|(wanted, cell)| (wanted - cell).abs());
        assert!(apart.fold(0.0, f64::max) < 1e-6, "orientation {turn}");
        assert!(
            turn == 9 || !seen.contains(&wanted),
            "orientation {turn} is an earlier one"
        );
        seen.push(wanted);
    }
    assert_eq!(seen[0], seen[8]);
    // By six, what is stored at the left of the top is at the right of it, and what is at the left of the bottom at the left of the top.
    let cells = &seen[5];
    let top = &cells[63 * 64..];
    let drawn: Vec<f64> = top.iter().copied().filter(|&cell| cell > 1e-3).collect();
    assert!((drawn[0] - 8.0 / 12.0).abs() < 0.01, "{drawn:?}");
}

/// Floats beyond black and white are cut there, and that is told; those between are not spoken of.
#[test]
fn levels_beyond_white_are_told_of() {
    let base = folder("picture_kinds_beyond");
    for (name, scale, shift) in [("plain.tif", 1.0, 0.0), ("beyond.tif", 5.0, -1.0)] {
        let levels: Vec<f32> = (0..SIDE * SIDE)
            .map(|at| f32::from(u8::from(inside(at % SIDE, at / SIDE))) * scale + shift)
            .collect();
        let file = fs::File::create(base.join(name)).unwrap();
        let mut encoder = TiffEncoder::new(file).unwrap();
        encoder.write_image::<Gray32Float>(SIDE, SIDE, &levels).unwrap();
    }
    let (plain, notes) = draw(&base, "plain.tif");
    assert!(notes.iter().all(|note| !note.warning), "{notes:?}");
    let (cut, notes) = draw(&base, "beyond.tif");
    assert_eq!(cut, plain);
    assert!(
        notes
            .iter()
            .any(|note| note.warning && note.text.contains("go from -1.000 to 4.000")),
        "{notes:?}"
    );
}

#[test]
fn what_is_not_drawn_is_said_or_refused() {
    let base = folder("picture_kinds_refused");
    let text = "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 9 9\"><rect width=\"4\" height=\"4\"/><text>F</text></svg>";
    fs::write(base.join("text.svg"), text).unwrap();
    let (_, notes) = draw(&base, "text.svg");
    assert!(
        notes
            .iter()
            .any(|note| note.warning && note.text.contains("turn text into paths")),
        "{notes:?}"
    );
    // Nothing else is in it: why it is empty is in the refusal.
    let only = text.replace("<rect width=\"4\" height=\"4\"/>", "");
    fs::write(base.join("only.svg"), only).unwrap();
    let spec: ShapeSpec = toml::from_str("image = \"only.svg\"").unwrap();
    let error = spec.rasterise(&box_of(8), &base).unwrap_err().to_string();
    assert!(error.contains("turn text into paths"), "{error}");
    // A million dashes are not made.
    for far in ["1e28", "11111111111111111111111111111", "9.5e+12"] {
        let dashed = text.replace(
            "<text>F</text>",
            &format!("<path d=\"M 0 0.123456789012 L {far} 4\" stroke=\"black\" stroke-dasharray=\"2 1\"/>"),
        );
        fs::write(base.join("dashed.svg"), &dashed).unwrap();
        let spec: ShapeSpec = toml::from_str("image = \"dashed.svg\"").unwrap();
        let error = spec.rasterise(&box_of(8), &base).unwrap_err().to_string();
        assert!(error.contains("has dashes, and a curve of more than"), "{error}");
        fs::write(base.join("dashed.svg"), dashed.replace(far, "8")).unwrap();
        draw(&base, "dashed.svg");
    }
    // A name says nothing, of curves neither.
    fs::write(base.join("curves.png"), text).unwrap();
    assert_eq!(draw(&base, "curves.png").0, draw(&base, "text.svg").0);
    fs::write(base.join("text.gif"), b"GIF89a").unwrap();
    let spec: ShapeSpec = toml::from_str("image = \"text.gif\"").unwrap();
    let error = spec.rasterise(&box_of(8), &base).unwrap_err().to_string();
    assert!(
        error.contains("pictures are PNG, JPEG, TIFF, WebP, EXR or SVG"),
        "{error}"
    );
}

#[test]
fn every_cut_and_every_flipped_byte_of_a_picture_ends_in_a_sentence_or_a_drawing() {
    let base = folder("picture_mutants");
    for name in write_all(&base) {
        let whole = fs::read(base.join(name)).unwrap();
        let spec: ShapeSpec = toml::from_str(&format!("image = \"mutant_{name}\"")).unwrap();
        let path = base.join(format!("mutant_{name}"));
        for place in (0..whole.len()).filter(|place| *place < 400 || place % 61 == 0) {
            fs::write(&path, &whole[..place]).unwrap();
            let _ = spec.rasterise(&box_of(4), &base);
            for flip in [1, 0x80] {
                let mut mutant = whole.clone();
                mutant[place] ^= flip;
                fs::write(&path, &mutant).unwrap();
                if let Ok(cells) = spec.rasterise(&box_of(4), &base) {
                    assert!(
                        cells.iter().all(|cell| (0.0..=1.0 + 1e-9).contains(cell)),
                        "{name} byte {place}"
                    );
                }
            }
        }
    }
}
