//! SVG, drawn by resvg as large as it is asked for. There are no fonts and no files: text must be paths, and other pictures are left out.

use std::io::Read;

use flate2::read::MultiGzDecoder;
use resvg::tiny_skia::{Pixmap, Transform};
use resvg::usvg::roxmltree::{Document, ParsingOptions};
use resvg::usvg::{Fill, Group, ImageHrefResolver, Node, Options, Paint, Stroke, Tree};

use super::pixels::{Pixels, Samples};
use super::room::{check, most};
use crate::bytes::grouped;
use crate::guard::guarded;
use crate::keyframes::error::Fault;

/// The drawing within a file of gzip, as `.svgz` are.
pub(super) fn unpacked(bytes: &[u8]) -> Result<Vec<u8>, Fault> {
    let remedy = "save it as plain SVG";
    let (mut drawing, most) = (Vec::new(), most(bytes.len()));
    let taken = MultiGzDecoder::new(bytes)
        .take(most as u64 + 1)
        .read_to_end(&mut drawing)
        .map_err(|error| Fault::content(format!("cannot be unpacked ({error})"), remedy))?;
    if taken > most {
        let found = format!("has more than {} bytes once it is unpacked", grouped(most));
        return Err(Fault::content(found, remedy));
    }
    Ok(drawing)
}

/// Pixels from the page beyond which nothing may reach, and the largest page: the library's numbers overflow there, and it ends the whole program.
const FARTHEST: f32 = 1e6;

/// Pixels of a pattern's tile that are drawn in any case; four pages are too. The library draws each tile as a whole, however little of it is seen.
const LARGEST: f32 = 4e6;

/// Units beyond which no curve is dashed: of one of 10^28 the library makes a million dashes before anybody can ask where it goes.
const LONGEST_DASHED: f64 = 1e7;

/// Attributes that say where a curve goes.
const OF_CURVES: [&str; 13] = [
    "d", "points", "x1", "y1", "x2", "y2", "x", "y", "width", "height", "r", "rx", "ry",
];

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
    let fails = || Fault::content("makes the library fail that draws it", remedy);
    if has_endless_dashes(bytes) {
        return Err(Fault::content(
            format!("has dashes, and a curve of more than {LONGEST_DASHED} units"),
            "take one of them away",
        ));
    }
    let tree = guarded(|| Tree::from_data(bytes, &options)).ok_or_else(fails)?;
    let tree = tree.map_err(|error| Fault::content(format!("cannot be read as SVG ({error})"), remedy))?;
    let (width, height) = (tree.size().width(), tree.size().height());
    if !(width.max(height) <= FARTHEST) {
        let found = format!("has a page of {width} x {height} units, of which {FARTHEST} are the most");
        return Err(Fault::content(found, "write a smaller width, height or viewBox"));
    }
    let scale = side as f32 / width.max(height);
    let pixels = |length: f32| ((length * scale).round() as usize).max(1);
    let (columns, rows) = (pixels(width), pixels(height));
    if reaches_beyond(tree.root(), FARTHEST / scale) {
        return Err(Fault::content(
            format!("has a curve that reaches more than {FARTHEST} pixels from its page"),
            "take it away, or bring it back onto the page",
        ));
    }
    let stretch = Transform::from_scale(columns as f32 / width, rows as f32 / height);
    let most = LARGEST.max(4.0 * (columns * rows) as f32);
    if has_tile_above(tree.root(), stretch, most) {
        return Err(Fault::content(
            format!("has a pattern whose tile is larger than {most} pixels"),
            "make its width and height smaller, or fill the shape with a colour",
        ));
    }
    // It is as large as the grid wants it, whatever the file.
    check(columns, rows, 4 * columns * rows, usize::MAX)?;
    let map = Pixmap::new(columns as u32, rows as u32);
    let mut map = map.ok_or_else(|| Fault::content("has no size", remedy))?;
    guarded(|| resvg::render(&tree, stretch, &mut map.as_mut())).ok_or_else(fails)?;
    Ok(Pixels {
        width: columns,
        height: rows,
        channels: 4,
        samples: Samples::Narrow(map.take_demultiplied()),
        note: left_out(bytes),
    })
}

/// Whether there are dashes in a drawing, and a curve with a number above [`LONGEST_DASHED`]. What is no XML has neither.
fn has_endless_dashes(bytes: &[u8]) -> bool {
    let text = core::str::from_utf8(bytes).unwrap_or("");
    if !text.contains("dasharray") {
        return false;
    }
    let allowing = ParsingOptions {
        allow_dtd: true,
        ..ParsingOptions::default()
    };
    let document = guarded(|| Document::parse_with_options(text, allowing).ok()).flatten();
    document.is_some_and(|document| {
        let all = document.descendants().flat_map(|node| node.attributes());
        let mut of_curves = all.filter(|attribute| OF_CURVES.contains(&attribute.name()));
        of_curves.any(|attribute| has_number_above(LONGEST_DASHED, attribute.value()))
    })
}

/// Whether a text has a number above `most`, wherever it begins and ends.
fn has_number_above(most: f64, text: &str) -> bool {
    let digits = |text: &str| {
        text.len()
            - text
                .trim_start_matches(|letter: char| letter.is_ascii_digit())
                .len()
    };
    let mut rest = text;
    while let Some((_, from_digit)) = rest
        .find(|letter: char| letter.is_ascii_digit())
        .and_then(|begin| rest.split_at_checked(begin))
    {
        let (whole, behind) = from_digit.split_at(digits(from_digit));
        // What follows a point is a part of a unit, however many digits it has.
        let behind = behind
            .strip_prefix('.')
            .map_or(behind, |part| part.split_at(digits(part)).1);
        let power = behind.strip_prefix(['e', 'E']).unwrap_or("");
        let power = power.strip_prefix('+').unwrap_or(power);
        let power = power.split_at(digits(power)).0.parse().unwrap_or(0);
        if whole
            .parse()
            .is_ok_and(|whole: f64| whole * 10.0_f64.powi(power) > most)
        {
            return true;
        }
        rest = behind;
    }
    false
}

/// Whether a curve of a group, or of what clips, masks or fills it, has a place farther than this.
fn reaches_beyond(group: &Group, farthest: f32) -> bool {
    group.children().iter().any(|node| {
        let mut beyond = match node {
            Node::Group(group) => reaches_beyond(group, farthest),
            Node::Path(path) => {
                // Bounds are left out of account where they cannot be found, points are there.
                let mut points = path.data().points().to_vec();
                path.abs_transform().map_points(&mut points);
                let bounds = path.abs_stroke_bounding_box();
                let sides = [bounds.left(), bounds.top(), bounds.right(), bounds.bottom()];
                let places = points.iter().flat_map(|point| [point.x, point.y]);
                // Neither what is no number.
                !places.chain(sides).all(|place| place.abs() <= farthest)
            }
            Node::Image(_) | Node::Text(_) => false,
        };
        node.subroots(|group| beyond |= reaches_beyond(group, farthest));
        beyond
    })
}

/// Whether what fills or strokes a curve of a group drawn by this transform, or of what clips or masks it, is a pattern with a tile of more pixels.
fn has_tile_above(group: &Group, transform: Transform, most: f32) -> bool {
    group.children().iter().any(|node| {
        let drawn = transform.pre_concat(node.abs_transform());
        match node {
            Node::Group(group) => {
                let mut above = has_tile_above(group, transform, most);
                node.subroots(|group| above |= has_tile_above(group, drawn, most));
                above
            }
            Node::Path(path) => {
                let fill = path.fill().map(Fill::paint);
                let paints = fill.into_iter().chain(path.stroke().map(Stroke::paint));
                paints.into_iter().any(|paint| {
                    let Paint::Pattern(pattern) = paint else {
                        return false;
                    };
                    let (across, down) = drawn.pre_concat(pattern.transform()).get_scale();
                    let tile = (pattern.rect().width() * across) * (pattern.rect().height() * down);
                    // Nor may it be no number.
                    !(tile <= most)
                        || has_tile_above(pattern.root(), Transform::from_scale(across, down), most)
                })
            }
            Node::Image(_) | Node::Text(_) => false,
        }
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

#[cfg(test)]
mod tests {
    use super::*;

    fn drawn(path: &str) -> Result<Pixels, Fault> {
        let head = "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"40\" height=\"30\"><defs><pattern id=\"h\" width=\"4\" height=\"4\" patternUnits=\"userSpaceOnUse\">";
        let text = format!(
            "{head}{}</pattern></defs>{}<rect width=\"9\" height=\"9\" fill=\"url(#h)\"/></svg>",
            path, path
        );
        read(text.as_bytes(), 64)
    }

    #[test]
    fn a_curve_that_reaches_beyond_all_numbers_is_refused() {
        assert!(drawn("<path d=\"M 1 1 C 5 5 9 9000 12 12 Z\"/>").is_ok());
        let far = "<path d=\"M 1 1 C 5 5 9 18446744073709551615 12 12 S 3 3 20 20 Z\"/>";
        for drawing in [
            far.to_owned(),
            format!(
                "<g clip-path=\"url(#c)\"><clipPath id=\"c\">{far}</clipPath><rect width=\"9\" height=\"9\"/></g>"
            ),
        ] {
            let Err(Fault::Content { found, .. }) = drawn(&drawing) else {
                unreachable!("it was drawn");
            };
            assert!(found.contains("reaches more than"), "{found}");
        }
    }

    #[test]
    fn a_tile_that_no_memory_holds_is_refused() {
        let tiled = |height: &str, inner: &str| {
            let tile = "<pattern id=\"h\" width=\"4\" patternUnits=\"userSpaceOnUse\"";
            let text = format!(
                "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 20 20\"><defs>{inner}{tile} height=\"{height}\"><rect width=\"3\" height=\"3\" fill=\"{}\"/></pattern></defs><path d=\"M0 0H15V15H0Z\" fill=\"url(#h)\" stroke=\"url(#h)\"/></svg>",
                if inner.is_empty() { "red" } else { "url(#k)" }
            );
            read(text.as_bytes(), 64)
        };
        assert!(tiled("400", "").is_ok());
        let huge = "<pattern id=\"k\" width=\"1e9\" height=\"4\" patternUnits=\"userSpaceOnUse\"><rect width=\"1\" height=\"1\"/></pattern>";
        for drawing in [tiled("18446744073709551615", ""), tiled("4", huge)] {
            let Err(Fault::Content { found, .. }) = drawing else {
                unreachable!("it was drawn");
            };
            assert!(found.contains("tile is larger"), "{found}");
        }
    }

    /// A page that is as large as what is drawn on it, where it says no size; and a filter that the library panics at.
    #[test]
    fn what_the_library_fails_at_is_refused() {
        let polygon = |more: &str| format!("<polygon points=\"0,0 9,3 4,9\" {more}/>");
        for (drawing, said) in [
            (
                "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"1e19\" height=\"30\"><path d=\"M1 1L3 3Z\"/></svg>".to_owned(),
                "has a page of",
            ),
            // A width that is none: the page is as large as what is drawn.
            (
                format!(
                    "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"\u{feff}mm\" height=\"30\"><filter id=\"f\"><feGaussianBlur stdDeviation=\"2\"/></filter><g transform=\"translate(2,3) rotate(15)\" clip-path=\"url(#c)\"><path d=\"M 1 1 C 5 5 9 0 12 12 S 3 3 20 20 q 1 -9223372036854775808 3 4 A 5 5 0 0 1 9 9 Z\" stroke=\"black\"/></g>{}</svg>",
                    polygon("filter=\"url(#f)\"")
                ),
                "has a page of",
            ),
            (
                format!(
                    "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"40\" height=\"30\"><filter id=\"f\"><feOffset dx=\"1\" dy=\"18446744073709551615\"/></filter>{}</svg>",
                    polygon("filter=\"url(#f)\"")
                ),
                "makes the library fail",
            ),
        ] {
            let Err(Fault::Content { found, .. }) = read(drawing.as_bytes(), 64) else {
                unreachable!("it was drawn");
            };
            assert!(found.contains(said), "{found}");
        }
    }
}
