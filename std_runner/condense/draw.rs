//! The deformed mesh as a picture: each triangle coloured by how much its edges have changed, a box seen from its front.

use super::body::OwnedMesh;
use super::canvas::{Canvas, Colour};
use crate::output::Picture;
use crate::tomography::{cross, dot, minus};
use std::collections::BTreeMap;

/// The longer side of a picture, and its margin, in pixels.
const LONGEST: f64 = 420.0;
const MARGIN: f64 = 12.0;
/// Of an edge that has not changed, and of the one that has changed most.
const CALM: Colour = [226.0, 232.0, 240.0];
const STRAINED: Colour = [200.0, 60.0, 40.0];
const EDGE: Colour = [50.0, 60.0, 75.0];
const REST: Colour = [190.0, 190.0, 190.0];
const HELD: Colour = [20.0, 20.0, 20.0];
const SPRING: Colour = [40.0, 120.0, 60.0];
/// Where a box is seen from: across and down of a unit of x, y and z.
const VIEW: [[f64; 3]; 2] = [[0.86, 0.50, 0.0], [0.20, -0.34, -0.92]];
/// Towards the eye.
const EYE: [f64; 3] = [-0.46, 0.79, -0.39];

/// A face of the mesh that is seen.
struct Face {
    corners: [u32; 3],
    /// The largest relative change of an edge.
    change: f64,
}

/// Draws `position`, within a frame that holds all of `frames`; nothing of a rod.
pub(super) fn draw(mesh: &OwnedMesh, frames: &[&[f64]], position: &[f64]) -> Option<Picture> {
    if mesh.dims < 2 {
        return None;
    }
    let view = View::of(mesh, frames)?;
    let mut canvas = Canvas::new(view.size[0], view.size[1]);
    let faces = faces(mesh, position);
    let edges = |canvas: &mut Canvas, places: &[f64], corners: [u32; 3], colour| {
        let [a, b, c] = corners.map(|corner| view.place(mesh.dims, places, corner));
        for line in [[a, b], [b, c], [c, a]] {
            canvas.line(line, 1.0, colour);
        }
    };
    if mesh.dims == 2 {
        faces
            .iter()
            .for_each(|face| edges(&mut canvas, &mesh.rest, face.corners, REST));
    }
    let most = faces.iter().fold(1e-12f64, |most, face| most.max(face.change));
    for face in view.in_order(mesh, position, faces) {
        let part = face.change / most;
        let shade = if mesh.dims == 3 {
            shade(position, face.corners)
        } else {
            1.0
        };
        let colour = core::array::from_fn(|k| shade * (CALM[k] + part * (STRAINED[k] - CALM[k])));
        canvas.triangle(
            face.corners.map(|corner| view.place(mesh.dims, position, corner)),
            colour,
        );
        edges(&mut canvas, position, face.corners, EDGE);
    }
    for spring in &mesh.springs {
        let ends = spring.ends.map(|end| view.place(mesh.dims, position, end));
        canvas.line(ends, 2.0, SPRING);
    }
    for (vertex, _) in mesh.held.iter().enumerate().filter(|(_, held)| **held) {
        canvas.dot(view.place(mesh.dims, position, vertex as u32), 2.2, HELD);
    }
    Some(canvas.picture())
}

/// The triangles of a plane mesh; of a box those that belong to one tetrahedron alone.
fn faces(mesh: &OwnedMesh, position: &[f64]) -> Vec<Face> {
    let change = |corners: &[u32]| {
        let pairs = corners
            .iter()
            .enumerate()
            .flat_map(|(at, one)| corners.iter().skip(at + 1).map(move |other| (*one, *other)));
        let changes = pairs.map(|(one, other)| {
            let [rest, now] = [mesh.rest.as_slice(), position].map(|places| {
                let [one, other] = [one, other].map(|corner| row(places, mesh.dims, corner));
                one.iter()
                    .zip(other)
                    .map(|(x, y)| (x - y) * (x - y))
                    .sum::<f64>()
                    .sqrt()
            });
            (now / rest - 1.0).abs()
        });
        changes.fold(0.0, f64::max)
    };
    if mesh.dims == 2 {
        let face = |corners: &[u32; 3]| Face {
            corners: *corners,
            change: change(corners),
        };
        return mesh.elements.as_chunks::<3>().0.iter().map(face).collect();
    }
    let mut seen: BTreeMap<[u32; 3], (usize, Face)> = BTreeMap::new();
    for corners in mesh.elements.as_chunks::<4>().0 {
        let [a, b, c, d] = *corners;
        // Counterclockwise from outside of a tetrahedron of positive volume.
        for face in [[a, c, b], [a, b, d], [b, c, d], [a, d, c]] {
            let mut key = face;
            key.sort_unstable();
            let fresh = || {
                (
                    0,
                    Face {
                        corners: face,
                        change: change(&face),
                    },
                )
            };
            seen.entry(key).or_insert_with(fresh).0 += 1;
        }
    }
    seen.into_values()
        .filter(|(count, _)| *count == 1)
        .map(|(_, face)| face)
        .collect()
}

fn row(places: &[f64], dims: usize, vertex: u32) -> &[f64] {
    places
        .get(vertex as usize * dims..(vertex as usize + 1) * dims)
        .unwrap_or(&[])
}

/// The normal of a face of a box.
fn normal(position: &[f64], corners: [u32; 3]) -> [f64; 3] {
    let [a, b, c] = corners.map(|corner| <[f64; 3]>::try_from(row(position, 3, corner)).unwrap_or_default());
    let across = cross(minus(b, a), minus(c, a));
    // Also where the mesh is so small that `unit` would see no length.
    let length = dot(across, across).sqrt().max(f64::MIN_POSITIVE);
    across.map(|x| x / length)
}

/// Faces that look up are brighter.
fn shade(position: &[f64], corners: [u32; 3]) -> f64 {
    let normal = normal(position, corners);
    0.80 + 0.20 * normal[2] - 0.06 * normal[0]
}

/// Places on the picture.
struct View {
    low: [f64; 2],
    scale: f64,
    size: [usize; 2],
}

impl View {
    fn of(mesh: &OwnedMesh, frames: &[&[f64]]) -> Option<Self> {
        let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        for place in frames.iter().flat_map(|frame| frame.chunks_exact(mesh.dims)) {
            for ((low, high), x) in low.iter_mut().zip(&mut high).zip(flat(place)) {
                *low = low.min(x);
                *high = high.max(x);
            }
        }
        let sides = [high[0] - low[0], high[1] - low[1]];
        let longest = sides[0].max(sides[1]);
        if !(longest > 0.0 && longest.is_finite()) {
            return None;
        }
        let scale = LONGEST / longest;
        Some(Self {
            low,
            scale,
            size: sides.map(|side| (side * scale + 2.0 * MARGIN) as usize + 1),
        })
    }

    fn place(&self, dims: usize, places: &[f64], vertex: u32) -> [f64; 2] {
        let at = flat(row(places, dims, vertex));
        [0, 1].map(|k| MARGIN + self.scale * (at[k] - self.low[k]))
    }

    /// Faces of a box that are turned to the eye, the farthest first.
    fn in_order(&self, mesh: &OwnedMesh, position: &[f64], mut faces: Vec<Face>) -> Vec<Face> {
        if mesh.dims == 2 {
            return faces;
        }
        let along = |x: &[f64]| x.iter().zip(EYE).map(|(x, eye)| x * eye).sum::<f64>();
        faces.retain(|face| along(&normal(position, face.corners)) < 0.0);
        let depth = |face: &Face| -> f64 {
            face.corners
                .iter()
                .map(|&corner| along(row(position, 3, corner)))
                .sum()
        };
        faces.sort_by(|one, other| depth(other).total_cmp(&depth(one)));
        faces
    }
}

/// Across and down.
fn flat(place: &[f64]) -> [f64; 2] {
    match place {
        [x, y] => [*x, -y],
        _ => VIEW.map(|row| row.iter().zip(place).map(|(a, x)| a * x).sum()),
    }
}
