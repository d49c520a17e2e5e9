//! Reads and writes NumPy's arrays: just enough of the format for the files that the program writes and reads.

use std::collections::BTreeMap;
use std::fs;
use std::io::{Read, Write};
use std::path::Path;

/// One array, in C order.
#[derive(Clone, Debug, PartialEq)]
pub struct Array {
    pub kind: String,
    pub shape: Vec<usize>,
    pub data: Vec<f64>,
}

/// A `.npy` file of doubles.
pub fn npy(shape: &[usize], values: &[f64]) -> Vec<u8> {
    let header = format!("{{'descr': '<f8', 'fortran_order': False, 'shape': {shape:?}, }}\n")
        .replace(['[', ']'], "|");
    let header = header.replacen('|', "(", 1).replacen('|', ",)", 1);
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend(u16::try_from(header.len()).unwrap().to_le_bytes());
    bytes.extend(header.as_bytes());
    bytes.extend(values.iter().flat_map(|value| value.to_le_bytes()));
    bytes
}

/// Writes an archive of such files, by name.
pub fn write(path: &Path, arrays: &[(&str, Vec<u8>)]) {
    let mut archive = zip::ZipWriter::new(fs::File::create(path).unwrap());
    let stored = zip::write::SimpleFileOptions::default().compression_method(zip::CompressionMethod::Stored);
    for (name, bytes) in arrays {
        archive.start_file(format!("{name}.npy"), stored).unwrap();
        archive.write_all(bytes).unwrap();
    }
    archive.finish().unwrap();
}

/// All arrays of a file by name.
pub fn read(path: &Path) -> BTreeMap<String, Array> {
    read_without(path, &[])
}

/// The same without some, which are not made of numbers.
pub fn read_without(path: &Path, left_out: &[&str]) -> BTreeMap<String, Array> {
    let mut archive = zip::ZipArchive::new(fs::File::open(path).unwrap()).unwrap();
    (0..archive.len())
        .map(|index| {
            let mut entry = archive.by_index(index).unwrap();
            let name = entry.name().unwrap().trim_end_matches(".npy").to_string();
            let mut bytes = Vec::new();
            entry.read_to_end(&mut bytes).unwrap();
            (name, bytes)
        })
        .filter(|(name, _)| !left_out.contains(&&name[..]))
        .map(|(name, bytes)| (name, parse(&bytes)))
        .collect()
}

fn parse(bytes: &[u8]) -> Array {
    assert_eq!(&bytes[..6], b"\x93NUMPY");
    let (start, length) = match bytes[6] {
        1 => (10, usize::from(u16::from_le_bytes([bytes[8], bytes[9]]))),
        _ => (
            12,
            u32::from_le_bytes([bytes[8], bytes[9], bytes[10], bytes[11]]) as usize,
        ),
    };
    let header = core::str::from_utf8(&bytes[start..start + length]).unwrap();
    let by_columns = header.contains("'fortran_order': True");
    let kind = between(header, "'descr': '", "'").to_string();
    let shape = between(header, "'shape': (", ")")
        .split(',')
        .map(str::trim)
        .filter(|size| !size.is_empty());
    let shape: Vec<usize> = shape.map(|size| size.parse().unwrap()).collect();
    let body = &bytes[start + length..];
    let data: Vec<f64> = match kind.as_str() {
        "<f4" => body
            .as_chunks()
            .0
            .iter()
            .map(|&chunk| f32::from_le_bytes(chunk).into())
            .collect(),
        "<f8" => body
            .as_chunks()
            .0
            .iter()
            .map(|&chunk| f64::from_le_bytes(chunk))
            .collect(),
        "|b1" => body.iter().map(|&byte| byte.into()).collect(),
        "<i8" => body
            .as_chunks()
            .0
            .iter()
            .map(|&chunk| i64::from_le_bytes(chunk) as f64)
            .collect(),
        "<i4" => body
            .as_chunks()
            .0
            .iter()
            .map(|&chunk| i32::from_le_bytes(chunk).into())
            .collect(),
        other => panic!("array of kind {other}"),
    };
    assert_eq!(data.len(), shape.iter().product::<usize>());
    let data = if by_columns { by_rows(&shape, &data) } else { data };
    Array { kind, shape, data }
}

/// The numbers of an array whose first index runs fastest, with the last one fastest.
fn by_rows(shape: &[usize], data: &[f64]) -> Vec<f64> {
    let place = |mut index: usize| {
        let mut at = vec![0; shape.len()];
        for (at, size) in at.iter_mut().zip(shape).rev() {
            (*at, index) = (index % size, index / size);
        }
        at.iter()
            .zip(shape)
            .rev()
            .fold(0, |place, (at, size)| place * size + at)
    };
    (0..data.len()).map(|index| data[place(index)]).collect()
}

fn between<'a>(text: &'a str, before: &str, after: &str) -> &'a str {
    let rest = &text[text.find(before).unwrap() + before.len()..];
    &rest[..rest.find(after).unwrap()]
}
