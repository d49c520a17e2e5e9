//! Good inputs, small ones.

use std::io::{Cursor, Write};
use std::path::Path;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipWriter};

const ROOT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../..");

/// Scenes of the examples, with few cells where they have many.
pub fn scenes(_: &Path) -> Vec<Vec<u8>> {
    let names = [
        "small_letter",
        "small_3d",
        "small_mixed",
        "small_two_keyframes",
        "effects/gate",
        "effects/parade",
        "effects/whirl",
    ];
    let read = |name: &str| std::fs::read(format!("{ROOT}/examples/{name}.toml")).unwrap();
    names.map(read).to_vec()
}

/// What `--set` is given.
pub fn assignments(_: &Path) -> Vec<Vec<u8>> {
    [
        "time.steps=20",
        "keyframe[0].text=\"G\"",
        "grid.boundary=[\"wall\", [\"open\", \"wall\"]]",
        "source={ circle = { center = [0.5, 0.5], radius = 0.2 } }",
        "method.direct.history=3",
        "emitter[0]={ from = 0, to = 9, rate = 0.1, box = { min = [0, 0], max = [0.2, 0.2] } }",
        "control.schedule=[[0, 1.0], [9, 100.0]]",
    ]
    .map(|text| text.as_bytes().to_vec())
    .to_vec()
}

fn npy(kind: &str, shape: &str, values: &[u8]) -> Vec<u8> {
    let mut header = format!("{{'descr': '{kind}', 'fortran_order': False, 'shape': {shape}, }}");
    while (10 + header.len() + 1) % 64 != 0 {
        header.push(' ');
    }
    header.push('\n');
    let length = u16::try_from(header.len()).unwrap().to_le_bytes();
    [b"\x93NUMPY\x01\x00", &length[..], header.as_bytes(), values].concat()
}

fn numbers(count: usize) -> Vec<u8> {
    (0..count)
        .flat_map(|index| (index as f32 / count as f32).to_le_bytes())
        .collect()
}

/// Arrays of 8 x 8 cells.
pub fn arrays(_: &Path) -> Vec<Vec<u8>> {
    let doubles: Vec<u8> = (0..64)
        .flat_map(|index| f64::from(index % 7).to_be_bytes())
        .collect();
    vec![
        npy("<f4", "(8, 8)", &numbers(64)),
        npy(">f8", "(8, 8)", &doubles),
        npy("|u1", "(4, 4)", &[9; 16]),
        npy("<f4", "(3, 8, 8)", &numbers(192)),
    ]
}

fn archive(arrays: &[(&str, Vec<u8>)], method: CompressionMethod) -> Vec<u8> {
    let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
    for (name, bytes) in arrays {
        let options = SimpleFileOptions::default().compression_method(method);
        zip.start_file(format!("{name}.npy"), options).unwrap();
        zip.write_all(bytes).unwrap();
    }
    zip.finish().unwrap().into_inner()
}

/// Archives of a density, and of a velocity on the faces of 8 x 8 cells.
pub fn archives(_: &Path) -> Vec<Vec<u8>> {
    let all = [
        ("density", npy("<f4", "(8, 8)", &numbers(64))),
        ("velocity_x", npy("<f4", "(8, 9)", &numbers(72))),
        ("velocity_y", npy("<f4", "(9, 8)", &numbers(72))),
    ];
    vec![
        archive(&all, CompressionMethod::Stored),
        archive(&all, CompressionMethod::Deflated),
    ]
}

/// Pictures of each kind of pixel.
pub fn pictures(_: &Path) -> Vec<Vec<u8>> {
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

/// A font.
pub fn fonts(_: &Path) -> Vec<Vec<u8>> {
    vec![dejavu::sans::bold().to_vec()]
}
