//! What files of meshes have in common.

use std::collections::BTreeMap;

/// What was read, or how a sentence goes on that says why not.
pub(super) type Read<T> = Result<T, String>;

/// What a file holds.
#[derive(Debug)]
pub(super) struct Found {
    pub dims: usize,
    pub rest: Vec<f64>,
    pub elements: Vec<u32>,
}

/// Vertices by the number that elements name them by.
#[derive(Default)]
pub(super) struct Parsed {
    pub vertices: BTreeMap<u64, [f64; 3]>,
    pub triangles: Vec<[u64; 3]>,
    pub tetrahedra: Vec<[u64; 4]>,
}

impl Parsed {
    pub fn found(self) -> Read<Found> {
        let dims = if self.tetrahedra.is_empty() { 2 } else { 3 };
        let corners: Vec<u64> = if dims == 3 {
            self.tetrahedra.into_iter().flatten().collect()
        } else {
            self.triangles.into_iter().flatten().collect()
        };
        if corners.is_empty() {
            return Err("holds neither triangles nor tetrahedra; give a mesh of some".into());
        }
        let mut used: Vec<u64> = corners.clone();
        used.sort_unstable();
        used.dedup();
        let mut rest = Vec::with_capacity(used.len() * dims);
        let mut height = None;
        for number in &used {
            let place = self.vertices.get(number);
            let place = place
                .ok_or_else(|| format!("names vertex {number}, which it does not have; it is damaged"))?;
            if dims == 2 && *height.get_or_insert(place[2]) != place[2] {
                return Err("has triangles that do not lie in a plane of constant z; give a flat mesh, or one of tetrahedra".into());
            }
            rest.extend(place.iter().take(dims));
        }
        let number = |corner: &u64| used.binary_search(corner).unwrap_or_default() as u32;
        Ok(Found {
            dims,
            rest,
            elements: corners.iter().map(number).collect(),
        })
    }
}

/// The number that a word stands for.
pub(super) fn number<T: core::str::FromStr>(word: Option<&str>, line: usize, what: &str) -> Read<T> {
    let word = word.ok_or_else(|| format!("ends in line {line} before {what}; it is damaged"))?;
    word.parse()
        .map_err(|_| format!("has \"{word}\" in line {line} where {what} belongs; it is damaged"))
}

/// A finite number.
pub(super) fn coordinate(word: Option<&str>, line: usize) -> Read<f64> {
    let value: f64 = number(word, line, "a coordinate")?;
    if value.is_finite() {
        Ok(value)
    } else {
        Err(format!(
            "has a coordinate in line {line} that is not finite; it is damaged"
        ))
    }
}
