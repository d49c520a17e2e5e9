//! Numbers of a picture as a PNG file: a photograph, a row of them, a slice.

use super::OutputError;
use super::picture::{Colours, Picture};
use super::render::palette::{Palette, signed};
use std::path::Path;

/// Pictures are enlarged by a whole factor to about this many pixels.
const SIDE: usize = 320;

/// What numbers mean.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Tone {
    /// Light: 0 is dark, 1 is bright.
    Light,
    /// A difference: -1 is too little, 1 too much.
    Difference,
}

fn factor(width: usize, height: usize) -> usize {
    (SIDE / width.max(height).max(1)).max(1)
}

/// A PNG file of `width` numbers a row, row 0 at the top; a row of `rows` = 1 is drawn as high as it takes to see it.
pub(crate) fn plate(values: &[f32], width: usize, tone: Tone) -> Result<Vec<u8>, OutputError> {
    let height = values.len() / width.max(1);
    let factor = factor(width, height);
    let tall = factor * (SIDE / 8).div_ceil(factor * height.max(1)).max(1);
    let palette = match tone {
        Tone::Light => Palette::Smoke,
        Tone::Difference => Palette::Difference,
    };
    let level = |value: f32| match tone {
        Tone::Light => (255.0 * value).round().clamp(0.0, 255.0) as u8,
        Tone::Difference => signed(value),
    };
    let mut bytes = Vec::with_capacity(values.len() * factor * tall);
    for row in values.chunks_exact(width.max(1)) {
        let line: Vec<u8> = row
            .iter()
            .flat_map(|&value| core::iter::repeat_n(level(value), factor))
            .collect();
        (0..tall).for_each(|_| bytes.extend(&line));
    }
    packed(Picture {
        width: width * factor,
        height: height * tall,
        bytes,
        colours: Colours::Of(palette),
    })
}

/// A PNG file of `width` pixels a row with `channels` numbers each, 0 ..= 1, row 0 at the top, in grey or colour.
pub(crate) fn colour_plate(values: &[f32], width: usize, channels: usize) -> Result<Vec<u8>, OutputError> {
    let bytes = values.chunks_exact(channels.max(1)).flat_map(|pixel| {
        let level = |channel: usize| {
            let value = pixel.get(channel).or(pixel.first()).copied().unwrap_or(0.0);
            (255.0 * value).round().clamp(0.0, 255.0) as u8
        };
        [level(0), level(1), level(2)]
    });
    packed(Picture {
        width,
        height: values.len() / (width * channels).max(1),
        bytes: bytes.collect(),
        colours: Colours::Each,
    })
}

fn packed(picture: Picture) -> Result<Vec<u8>, OutputError> {
    picture
        .to_png()
        .map_err(OutputError::of(Path::new("report.html")))
}
