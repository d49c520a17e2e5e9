//! A line of text as light on pixels.

use std::path::Path;

use super::raster::fill;
use super::{Canvas, ShapeSpec, text};

/// Height of a capital letter, in heights of the line.
const CAPITAL: f64 = 0.5;

/// The `text` from the left of `width` pixels by `height`, 0 ..= 1, bottom row first; what does not fit is made smaller, what cannot be drawn is
/// left out.
pub(crate) fn caption(text: &str, width: usize, height: usize) -> Vec<f64> {
    let canvas = Canvas {
        cells: vec![width, height],
        periodic: vec![false; 2],
        length: width.max(height) as f64,
    };
    let spec = ShapeSpec {
        text: Some(text.to_owned()),
        height: Some(CAPITAL * height as f64),
        ..ShapeSpec::default()
    };
    let letters = text::solid(&spec, &canvas, Path::new(""));
    let Ok(letters) = letters.map(|letters| letters.at_the_left(width as f64)) else {
        return vec![0.0; width * height];
    };
    fill(&canvas, &letters)
}
