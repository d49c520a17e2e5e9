//! What is wrong with a surface, in a sentence: it is filled anyhow.

use std::collections::HashMap;

use super::surface::Surface;
use super::voxels::Filled;
use crate::bytes::grouped;

/// Edges that have a triangle on one side only. Points at the same place are one: files repeat them along seams, and STL for each triangle.
fn open_edges(surface: &Surface) -> usize {
    let mut known: HashMap<[u64; 3], u32> = HashMap::new();
    let numbers = surface.points.iter().enumerate().map(|(number, point)| {
        // 0 and -0 are one place.
        let place = point.map(|x| (x + 0.0).to_bits());
        *known.entry(place).or_insert(number as u32)
    });
    let numbers: Vec<u32> = numbers.collect();
    let number = |corner: u32| numbers.get(corner as usize).copied().unwrap_or(corner);
    let mut sides: HashMap<[u32; 2], u32> = HashMap::new();
    for triangle in &surface.triangles {
        let [a, b, c] = triangle.map(number);
        for [from, to] in [[a, b], [b, c], [c, a]] {
            if from != to {
                *sides.entry([from.min(to), from.max(to)]).or_default() += 1;
            }
        }
    }
    sides.into_values().filter(|&count| count == 1).count()
}

/// What is said of `surface` after it was filled.
pub(super) fn sentence(surface: &Surface, filled: &Filled) -> String {
    let triangles = grouped(surface.triangles.len());
    let share = |cells: usize| 100.0 * cells as f64 / filled.inside.max(1) as f64;
    let mut faults = Vec::new();
    let open = open_edges(surface);
    if open > 0 {
        faults.push(format!("{} open edges", grouped(open)));
    }
    if filled.flipped > 0 {
        faults.push(format!("{:.1} % of its cells inside out", share(filled.flipped)));
    }
    if filled.overlaps > 0 {
        faults.push(format!(
            "{:.1} % of its cells covered more than once",
            share(filled.overlaps)
        ));
    }
    if faults.is_empty() {
        return format!("has {triangles} triangles and is closed");
    }
    format!(
        "has {triangles} triangles, {}; it was filled all the same",
        faults.join(", ")
    )
}
