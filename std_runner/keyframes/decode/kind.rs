//! What kind of picture a file is.

use std::path::Path;

use image::ImageFormat;

use super::pixels::Pixels;
use super::{exr, matte, photo, png, svg, tiff, webp};
use crate::keyframes::ending::ends_with;
use crate::keyframes::error::Fault;
use crate::keyframes::whole::whole;

/// What the names of pictures end in.
const ENDINGS: [&str; 9] = ["png", "jpg", "jpeg", "tif", "tiff", "webp", "exr", "svg", "svgz"];

/// Whether a file is a picture by its name.
pub(crate) fn is_picture(path: &Path) -> bool {
    ENDINGS.iter().any(|ending| ends_with(path, ending))
}

/// Decodes the picture at `path`; one of curves gets `side` pixels along its longer side.
pub(in crate::keyframes) fn read(path: &Path, side: usize) -> Result<Pixels, Fault> {
    let bytes = whole(path, 1, "make it smaller: the size of the grid is enough")?;
    let starts = |magic: &[u8]| bytes.starts_with(magic);
    let is_png = ends_with(path, "png");
    if starts(b"\xff\xd8\xff") {
        photo::read(&bytes, ImageFormat::Jpeg)
    } else if starts(b"II*\0") || starts(b"MM\0*") || starts(b"II+\0") || starts(b"MM\0+") {
        tiff::check(&bytes)?;
        match matte::read(&bytes)? {
            Some(pixels) => Ok(pixels),
            None => photo::read(&bytes, ImageFormat::Tiff),
        }
    } else if starts(b"RIFF") && bytes.get(8..12) == Some(b"WEBP") {
        webp::check(&bytes)?;
        photo::read(&bytes, ImageFormat::WebP)
    } else if starts(b"\x76\x2f\x31\x01") {
        exr::decoded(&bytes)
    } else if is_svg(&bytes) {
        svg::read(&bytes, side)
    } else if starts(b"\x1f\x8b") {
        svg::read(&svg::unpacked(&bytes)?, side)
    } else if starts(b"\x89PNG") || is_png {
        png::read(&bytes)
    } else {
        Err(Fault::content(
            "is no picture of a known kind",
            "pictures are PNG, JPEG, TIFF, WebP, EXR or SVG: save it as one of them; arrays are .npy and .npz, volumes .vdb, meshes .obj, .stl, .ply, .gltf and .glb",
        ))
    }
}

fn is_svg(bytes: &[u8]) -> bool {
    let text = bytes
        .strip_prefix(b"\xef\xbb\xbf")
        .unwrap_or(bytes)
        .trim_ascii_start();
    let head = text.get(..text.len().min(4096)).unwrap_or_default();
    text.starts_with(b"<") && head.windows(4).any(|part| part == b"<svg")
}
