//! STL, binary and in words: loose triangles.

use super::surface::Surface;
use crate::keyframes::error::Fault;

/// Bytes before the first triangle of a binary file, and those of a triangle.
const HEAD: usize = 84;
const TRIANGLE: usize = 50;

/// Reads the triangles. A binary file may begin with the word `solid` too: the count of its triangles tells.
pub(super) fn read(bytes: &[u8]) -> Result<Surface, Fault> {
    let count = bytes
        .get(80..HEAD)
        .and_then(|word| word.try_into().ok())
        .map(u32::from_le_bytes);
    let promised = count.map(|count| (count as usize).saturating_mul(TRIANGLE));
    let held = bytes.len().saturating_sub(HEAD);
    let in_words = bytes
        .trim_ascii_start()
        .get(..5)
        .is_some_and(|word| word.eq_ignore_ascii_case(b"solid"));
    match promised {
        Some(promised) if promised == held || (!in_words && promised <= held) => binary(bytes, promised),
        _ if in_words => words(bytes),
        Some(promised) => Err(Fault::content(
            format!("holds {held} bytes of triangles where its header promises {promised}"),
            "it was cut off, or is no STL: export it again",
        )),
        None => Err(Fault::content("is no STL", "export it again, as binary STL")),
    }
}

fn binary(bytes: &[u8], promised: usize) -> Result<Surface, Fault> {
    let mut surface = Surface::default();
    let triangles = bytes.get(HEAD..HEAD + promised).unwrap_or_default();
    for triangle in triangles.chunks_exact(TRIANGLE) {
        let numbers = triangle.get(12..48).unwrap_or_default().chunks_exact(4);
        let mut numbers =
            numbers.map(|word| f64::from(f32::from_le_bytes(word.try_into().unwrap_or_default())));
        let mut corner = || {
            let point = core::array::from_fn(|_| numbers.next().unwrap_or(f64::NAN));
            surface.points.push(point);
            surface.points.len() as u32 - 1
        };
        let corners = [corner(), corner(), corner()];
        surface.polygon(&corners)?;
    }
    Ok(surface)
}

fn words(bytes: &[u8]) -> Result<Surface, Fault> {
    let text = String::from_utf8_lossy(bytes);
    let mut surface = Surface::default();
    let mut corners = Vec::new();
    let mut words = text.split_ascii_whitespace();
    while let Some(word) = words.next() {
        if !word.eq_ignore_ascii_case("vertex") {
            continue;
        }
        let mut next = || words.next().and_then(|word| word.parse::<f64>().ok());
        let (Some(x), Some(y), Some(z)) = (next(), next(), next()) else {
            let found = format!(
                "has a corner of triangle {} that cannot be read",
                surface.triangles.len() + 1
            );
            return Err(Fault::content(found, "export it again, as binary STL"));
        };
        corners.push(surface.points.len() as u32);
        surface.points.push([x, y, z]);
        if corners.len() == 3 {
            surface.polygon(&corners)?;
            corners.clear();
        }
    }
    Ok(surface)
}
