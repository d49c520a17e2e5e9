//! A mesh file by its extension.

use std::path::Path;

use super::surface::Surface;
use super::{gltf, obj, ply, stl};
use crate::bytes::{are_free, grouped};
use crate::keyframes::error::Fault;

/// Bytes of memory that a byte of a file may become.
const GROWTH: usize = 8;

/// Reads the surface in the file at `path`.
pub(super) fn read(path: &Path) -> Result<Surface, Fault> {
    let surface = match extension(path).as_str() {
        "obj" => obj::read(&whole(path)?),
        "stl" => stl::read(&whole(path)?),
        "ply" => ply::read(&whole(path)?),
        "gltf" | "glb" => gltf::read(&whole(path)?, path),
        _ => Err(Fault::content(
            "has an unknown extension",
            "meshes are .obj, .stl, .ply, .gltf or .glb",
        )),
    }?;
    surface.checked()
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

/// All bytes of a file that fits into memory with what is made of it.
pub(super) fn whole(path: &Path) -> Result<Vec<u8>, Fault> {
    let about = std::fs::metadata(path)?;
    let size = usize::try_from(about.len()).unwrap_or(usize::MAX);
    if about.is_file() && !are_free(size.saturating_mul(GROWTH)) {
        return Err(Fault::content(
            format!(
                "has {} bytes, more than there is memory to read them",
                grouped(size)
            ),
            "reduce the mesh: the cells of the grid are coarser than its triangles by far",
        ));
    }
    Ok(std::fs::read(path)?)
}
