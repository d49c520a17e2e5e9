//! SVG, drawn by resvg as large as it is asked for. There are no fonts and no files: text must be paths, and other pictures are left out.

use std::io::Read;

use flate2::read::MultiGzDecoder;
use resvg::tiny_skia::{Pixmap, Transform};
use resvg::usvg::{ImageHrefResolver, Options, Tree};

use super::pixels::{Pixels, Samples};
use super::room::check;
use crate::keyframes::error::Fault;

/// A drawing is no longer than this once it is unpacked.
const LONGEST: u64 = 64 << 20;

/// The drawing within a file of gzip, as `.svgz` are.
pub(super) fn unpacked(bytes: &[u8]) -> Result<Vec<u8>, Fault> {
    let remedy = "save it as plain SVG";
    let mut drawing = Vec::new();
    let taken = MultiGzDecoder::new(bytes)
        .take(LONGEST + 1)
        .read_to_end(&mut drawing)
        .map_err(|error| Fault::content(format!("cannot be unpacked ({error})"), remedy))?;
    if taken as u64 > LONGEST {
        let found = format!("is longer than {} MiB once it is unpacked", LONGEST >> 20);
        return Err(Fault::content(found, remedy));
    }
    Ok(drawing)
}

/// Draws an SVG file with `side` pixels along its longer side.
pub(super) fn read(bytes: &[u8], side: usize) -> Result<Pixels, Fault> {
    let options = Options {
        image_href_resolver: ImageHrefResolver {
            resolve_data: Box::new(|_, _, _| None),
            resolve_string: Box::new(|_, _| None),
        },
        ..Options::default()
    };
    let remedy = "save it as plain SVG";
    let tree = Tree::from_data(bytes, &options)
        .map_err(|error| Fault::content(format!("cannot be read as SVG ({error})"), remedy))?;
    let (width, height) = (tree.size().width(), tree.size().height());
    let scale = side as f32 / width.max(height);
    let pixels = |length: f32| ((length * scale).round() as usize).max(1);
    let (columns, rows) = (pixels(width), pixels(height));
    check(columns, rows, 8)?;
    let map = Pixmap::new(columns as u32, rows as u32);
    let mut map = map.ok_or_else(|| Fault::content("has no size", remedy))?;
    let stretch = Transform::from_scale(columns as f32 / width, rows as f32 / height);
    resvg::render(&tree, stretch, &mut map.as_mut());
    let mut levels = Vec::with_capacity(4 * columns * rows);
    for pixel in map.pixels() {
        let plain = pixel.demultiply();
        levels.extend([plain.red(), plain.green(), plain.blue(), plain.alpha()]);
    }
    Ok(Pixels {
        width: columns,
        height: rows,
        channels: 4,
        samples: Samples::Narrow(levels),
        note: left_out(bytes),
    })
}

/// What of the drawing is not drawn.
fn left_out(bytes: &[u8]) -> Option<String> {
    let holds = |tag: &[u8]| bytes.windows(tag.len()).any(|part| part == tag);
    let mut missing = Vec::new();
    if holds(b"<text") {
        missing.push("its text (turn text into paths before saving)");
    }
    if holds(b"<image") {
        missing.push("pictures within it");
    }
    (!missing.is_empty()).then(|| format!("was drawn without {}", missing.join(" and ")))
}
