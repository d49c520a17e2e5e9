//! glTF 2.0, as `.gltf` with its buffers beside it or within, and as `.glb`: positions and triangles of all meshes of the scene, each where
//! its nodes put it. Skins, morphs and animations are left at rest.

use core::ops::Range;
use std::borrow::Cow;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use serde::Deserialize;
use serde_json::Value;

use super::glb::{AGAIN, broken, buffer, named, parts};
use super::scene_graph::{Node, placed};
use super::surface::{MOST_TRIANGLES, Point, REDUCE, Surface, bytes_of};
use crate::keyframes::error::Fault;

#[derive(Default, Deserialize)]
#[serde(default, rename_all = "camelCase")]
struct Root {
    extensions_required: Vec<String>,
    scene: Option<usize>,
    scenes: Vec<Scene>,
    nodes: Vec<Node>,
    meshes: Vec<Mesh>,
    accessors: Vec<Accessor>,
    buffer_views: Vec<View>,
    buffers: Vec<Buffer>,
}

#[derive(Default, Deserialize)]
#[serde(default)]
struct Scene {
    nodes: Vec<usize>,
}

#[derive(Deserialize)]
struct Mesh {
    primitives: Vec<Primitive>,
}

#[derive(Deserialize)]
struct Primitive {
    attributes: BTreeMap<String, usize>,
    indices: Option<usize>,
    #[serde(default = "triangles")]
    mode: u32,
}

/// The mode of triangles one by one, which is usual.
fn triangles() -> u32 {
    4
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct Accessor {
    buffer_view: Option<usize>,
    #[serde(default)]
    byte_offset: usize,
    component_type: u32,
    #[serde(default)]
    normalized: bool,
    count: usize,
    r#type: String,
    sparse: Option<Value>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct View {
    buffer: usize,
    #[serde(default)]
    byte_offset: usize,
    byte_length: usize,
    byte_stride: Option<usize>,
}

#[derive(Deserialize)]
struct Buffer {
    uri: Option<String>,
}

/// Reads all bodies of the scene in `bytes`, which are those of the file at `path`.
pub(super) fn read(bytes: &[u8], path: &Path) -> Result<Surface, Fault> {
    let (text, inside) = parts(bytes)?;
    let root: Root = serde_json::from_slice(text).map_err(|error| broken(&error.to_string()))?;
    let packed = root.extensions_required.iter().find(|name| {
        matches!(
            name.as_str(),
            "KHR_draco_mesh_compression" | "EXT_meshopt_compression" | "KHR_meshopt_compression"
        )
    });
    if let Some(name) = packed {
        return Err(Fault::content(format!("is packed by {name}"), AGAIN));
    }
    let uris = root.buffers.iter().map(|buffer| buffer.uri.as_deref());
    let buffers = uris
        .map(|uri| buffer(uri, inside, path))
        .collect::<Result<Vec<_>, _>>()?;
    let file = File { root, buffers };
    file.check_size()?;
    let meshes = file.root.meshes.iter().map(|mesh| file.mesh(mesh));
    let meshes = meshes.collect::<Result<Vec<_>, _>>()?;
    let all: Vec<usize> = (0..file.root.nodes.len()).collect();
    let roots = file
        .root
        .scenes
        .get(file.root.scene.unwrap_or(0))
        .map_or(&all, |scene| &scene.nodes);
    placed(&file.root.nodes, roots, &meshes)
}

/// The files beside the one at `path` that its buffers name. Of one that cannot be read there are none: whoever draws it says so.
pub(super) fn beside(path: &Path) -> Vec<PathBuf> {
    let bytes = bytes_of(path).unwrap_or_default();
    let text = parts(&bytes).map_or(&[][..], |(text, _)| text);
    let root: Root = serde_json::from_slice(text).unwrap_or_default();
    let uris = root.buffers.iter().filter_map(|buffer| buffer.uri.as_deref());
    uris.filter_map(|uri| named(uri, path)).collect()
}

impl Primitive {
    /// The accessor of its points, if it bounds something: points and lines do not.
    fn positions(&self) -> Option<usize> {
        let bounds = matches!(self.mode, 4..=6);
        self.attributes.get("POSITION").copied().filter(|_| bounds)
    }
}

struct File<'a> {
    root: Root,
    buffers: Vec<Cow<'a, [u8]>>,
}

impl File<'_> {
    /// Refuses more than there is room for before any of it is read: primitives can take the same bytes again and again.
    fn check_size(&self) -> Result<(), Fault> {
        let count = |accessor: usize| self.root.accessors.get(accessor).map_or(0, |found| found.count);
        let (mut points, mut triangles) = (0_usize, 0_usize);
        for mesh in &self.root.meshes {
            let mut known = BTreeSet::new();
            for primitive in &mesh.primitives {
                let Some(positions) = primitive.positions() else {
                    continue;
                };
                let own = count(positions);
                points = points.saturating_add(if known.insert(positions) { own } else { 0 });
                let corners = primitive.indices.map_or(own, count);
                let faces = if primitive.mode == 4 {
                    corners / 3
                } else {
                    corners.saturating_sub(2)
                };
                triangles = triangles.saturating_add(faces);
            }
        }
        for (count, what) in [(points, "points"), (triangles, "triangles")] {
            if count > MOST_TRIANGLES {
                let found = format!("has more than {MOST_TRIANGLES} {what}");
                return Err(Fault::content(found, REDUCE));
            }
        }
        Ok(())
    }

    fn mesh(&self, mesh: &Mesh) -> Result<Surface, Fault> {
        let mut surface = Surface::default();
        // Primitives of one mesh often share their points.
        let mut known = BTreeMap::new();
        for primitive in &mesh.primitives {
            let Some(positions) = primitive.positions() else {
                continue;
            };
            let points = match known.get(&positions) {
                Some(points) => Range::clone(points),
                None => {
                    let first = surface.points.len() as u32;
                    let numbers = self.numbers(positions, "VEC3")?;
                    let new = numbers.chunks_exact(3);
                    surface
                        .points
                        .extend(new.map(|point| -> Point { [point[0], point[1], point[2]] }));
                    let points = first..surface.points.len() as u32;
                    known.insert(positions, points.clone());
                    points
                }
            };
            let first = points.start;
            let corners: Vec<u32> = match primitive.indices {
                Some(indices) => {
                    let indices = self.numbers(indices, "SCALAR")?;
                    indices
                        .into_iter()
                        .map(|index| first.saturating_add(index as u32))
                        .collect()
                }
                None => points.collect(),
            };
            match primitive.mode {
                4 => corners
                    .chunks_exact(3)
                    .try_for_each(|three| surface.polygon(three))?,
                5 => {
                    for (index, three) in corners.windows(3).enumerate() {
                        let [a, b, c] = [three[0], three[1], three[2]];
                        surface.polygon(&if index % 2 == 0 { [a, b, c] } else { [b, a, c] })?;
                    }
                }
                _ => surface.polygon(&corners)?,
            }
        }
        Ok(surface)
    }

    /// All numbers of an accessor of this type.
    fn numbers(&self, accessor: usize, wanted: &str) -> Result<Vec<f64>, Fault> {
        let accessor = self
            .root
            .accessors
            .get(accessor)
            .ok_or_else(|| broken("an accessor is missing"))?;
        if accessor.r#type != wanted || accessor.sparse.is_some() {
            return Err(broken("points or faces are stored in an unusual way"));
        }
        let of_view = accessor
            .buffer_view
            .and_then(|view| self.root.buffer_views.get(view));
        let view = of_view.ok_or_else(|| broken("a view is missing"))?;
        let buffer = self
            .buffers
            .get(view.buffer)
            .ok_or_else(|| broken("a buffer is missing"))?;
        let end = view.byte_offset.saturating_add(view.byte_length);
        let bytes = buffer
            .get(view.byte_offset..end)
            .ok_or_else(|| broken("a buffer is too short"))?;
        let (size, parts) = (accessor.size()?, if wanted == "VEC3" { 3 } else { 1 });
        let stride = view.byte_stride.unwrap_or(size * parts).max(size * parts);
        let needed = accessor
            .count
            .checked_sub(1)
            .and_then(|before| before.checked_mul(stride));
        let needed =
            needed.and_then(|before| before.checked_add(accessor.byte_offset.saturating_add(size * parts)));
        if accessor.byte_offset > bytes.len() || needed.is_none_or(|needed| needed > bytes.len()) {
            return Err(broken("an accessor reaches beyond its bytes"));
        }
        let rows = (0..accessor.count).map(|row| accessor.byte_offset + row * stride);
        let words = rows.flat_map(|at| (0..parts).map(move |part| at + part * size));
        Ok(words
            .map(|at| accessor.value(bytes.get(at..at + size).unwrap_or_default()))
            .collect())
    }
}

impl Accessor {
    /// Bytes of a number.
    fn size(&self) -> Result<usize, Fault> {
        match self.component_type {
            5120 | 5121 => Ok(1),
            5122 | 5123 => Ok(2),
            5125 | 5126 => Ok(4),
            other => Err(broken(&format!("numbers are of type {other}"))),
        }
    }

    fn value(&self, bytes: &[u8]) -> f64 {
        let mut raw = [0; 4];
        raw.iter_mut().zip(bytes).for_each(|(slot, &byte)| *slot = byte);
        let word = u32::from_le_bytes(raw);
        let (value, top) = match self.component_type {
            5120 => (f64::from(word as u8 as i8), 127.0),
            5121 => (f64::from(word), 255.0),
            5122 => (f64::from(word as u16 as i16), 32767.0),
            5123 => (f64::from(word), 65535.0),
            5125 => (f64::from(word), 1.0),
            _ => (f64::from(f32::from_bits(word)), 1.0),
        };
        if self.normalized {
            (value / top).max(-1.0)
        } else {
            value
        }
    }
}
