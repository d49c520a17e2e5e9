//! A mesh file by its extension.

use std::path::{Path, PathBuf};

use super::surface::{Surface, bytes_of};
use super::{gltf, obj, ply, stl};
use crate::keyframes::error::Fault;

/// Reads the surface in the file at `path`.
pub(super) fn read(path: &Path) -> Result<Surface, Fault> {
    let surface = match extension(path).as_str() {
        "obj" => obj::read(&bytes_of(path)?),
        "stl" => stl::read(&bytes_of(path)?),
        "ply" => ply::read(&bytes_of(path)?),
        "gltf" | "glb" => gltf::read(&bytes_of(path)?, path),
        _ => Err(Fault::content(
            "has an unknown extension",
            "meshes are .obj, .stl, .ply, .gltf or .glb",
        )),
    }?;
    surface.checked()
}

/// The files beside the one at `path` that hold a part of its surface.
pub(crate) fn files_beside(path: &Path) -> Vec<PathBuf> {
    match extension(path).as_str() {
        "gltf" | "glb" => gltf::beside(path),
        _ => Vec::new(),
    }
}

/// Whether y points up in files of this kind where nothing is said: so it does in OBJ and glTF as programs write them, not in STL and PLY.
pub(super) fn has_y_up(path: &Path) -> bool {
    matches!(extension(path).as_str(), "obj" | "gltf" | "glb")
}

fn extension(path: &Path) -> String {
    path.extension().map_or(String::new(), |extension| {
        extension.to_string_lossy().to_ascii_lowercase()
    })
}
