//! Meshes from files: triangles of Wavefront's .obj, triangles or tetrahedra of Gmsh's .msh (ASCII, 2.2 and 4.1).
//!
//! Only vertices that an element names are kept, in their order. A mesh without tetrahedra must be flat: its z is the same everywhere.

use super::msh::msh;
use super::parsed::{Found, Parsed, Read, coordinate, number};
use std::path::Path;

/// Most bytes of a file.
const MOST_BYTES: u64 = 2_000_000_000;

/// Why it holds nothing.
#[derive(Debug)]
pub(super) enum Unread {
    /// It cannot be opened.
    Missing(String),
    /// It is no mesh; the sentence goes on after its name.
    Damaged(String),
}

/// Reads a mesh, by the end of its name.
pub(super) fn read(path: &Path) -> Result<Found, Unread> {
    let missing = |error: std::io::Error| Unread::Missing(error.to_string());
    let kind = path.extension().map(|end| end.to_string_lossy().to_lowercase());
    if std::fs::metadata(path).map_err(missing)?.len() > MOST_BYTES {
        return Err(Unread::Damaged("is larger than 2 GB; give a coarser mesh".into()));
    }
    let bytes = std::fs::read(path).map_err(missing)?;
    let text = String::from_utf8(bytes);
    let text = text.map_err(|_| Unread::Damaged("is not text; save it in ASCII".into()))?;
    let parsed = match kind.as_deref() {
        Some("obj") => obj(&text),
        Some("msh") => msh(&text),
        _ => Err("is neither .obj nor .msh; convert it to one of them".into()),
    };
    parsed.and_then(Parsed::found).map_err(Unread::Damaged)
}

fn obj(text: &str) -> Read<Parsed> {
    let mut parsed = Parsed::default();
    for (index, line) in text.lines().enumerate() {
        let (line, mut words) = (index + 1, line.split_whitespace());
        match words.next() {
            Some("v") => {
                let place = [0; 3].map(|_| words.next());
                let place = [
                    coordinate(place[0], line)?,
                    coordinate(place[1], line)?,
                    coordinate(place[2].or(Some("0")), line)?,
                ];
                let count = parsed.vertices.len() as u64;
                parsed.vertices.insert(count + 1, place);
            }
            Some("f") => {
                let corners: Vec<&str> = words.collect();
                let [a, b, c] = corners.as_slice() else {
                    let why = format!(
                        "has a face of {} corners in line {line}; triangulate it",
                        corners.len()
                    );
                    return Err(why);
                };
                let count = parsed.vertices.len() as i64;
                let corner = |word: &str| -> Read<u64> {
                    let place: i64 = number(word.split('/').next(), line, "the number of a vertex")?;
                    let place = if place < 0 { count + 1 + place } else { place };
                    let inside = (1..=count).contains(&place);
                    inside.then_some(place as u64).ok_or_else(|| {
                        format!("names vertex {word} in line {line}, before which there are {count}; it is damaged")
                    })
                };
                parsed.triangles.push([corner(a)?, corner(b)?, corner(c)?]);
            }
            _ => {}
        }
    }
    Ok(parsed)
}
