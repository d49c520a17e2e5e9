//! Good arrays, small ones.

use std::io::{Cursor, Write};
use std::path::Path;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipWriter};

pub fn npy(kind: &str, shape: &str, values: &[u8]) -> Vec<u8> {
    let mut header = format!("{{'descr': '{kind}', 'fortran_order': False, 'shape': {shape}, }}");
    while (10 + header.len() + 1) % 64 != 0 {
        header.push(' ');
    }
    header.push('\n');
    let length = u16::try_from(header.len()).unwrap().to_le_bytes();
    [b"\x93NUMPY\x01\x00", &length[..], header.as_bytes(), values].concat()
}

pub fn numbers(count: usize) -> Vec<u8> {
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
