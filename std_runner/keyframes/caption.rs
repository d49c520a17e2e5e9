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

#[cfg(test)]
mod tests {
    use super::*;

    /// The columns of a caption in which there is ink, from the first to the last.
    fn inked(text: &str, width: usize) -> Option<(usize, usize)> {
        let light = caption(text, width, 20);
        let mut columns =
            (0..width).filter(|x| light.iter().skip(*x).step_by(width).any(|light| *light > 0.5));
        let first = columns.next()?;
        Some((first, columns.next_back().unwrap_or(first)))
    }

    #[test]
    fn a_caption_begins_on_the_left_and_fits() {
        let (first, last) = inked("step 40", 200).unwrap_or_default();
        assert!(first < 3 && (40..100).contains(&last), "{first} {last}");
        let (first, last) = inked(&"step 40 ".repeat(9), 200).unwrap_or_default();
        assert!(first < 3 && (190..200).contains(&last), "{first} {last}");
        // A font has no letter for it.
        assert_eq!(inked("\u{10ffff}", 200), None);
    }
}
