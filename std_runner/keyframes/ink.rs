//! Which of a picture's pixels are smoke: the opaque, the light or the dark ones.

use super::ShapeError;
use super::decode::Pixels;

/// What of a picture is smoke.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Ink {
    /// Light pixels: the luminance, over black where the picture is transparent.
    Light,
    /// Dark pixels: what the luminance lacks to white, over white where the picture is transparent.
    Dark,
    /// Opaque pixels, of whatever colour.
    Alpha,
}

impl Ink {
    /// The meaning of the key `ink`.
    pub(super) fn parse(word: &str) -> Result<Self, ShapeError> {
        match word {
            "light" => Ok(Self::Light),
            "dark" => Ok(Self::Dark),
            "alpha" => Ok(Self::Alpha),
            other => Err(ShapeError::key(
                "ink",
                format!("is {other:?}"),
                "write \"light\", \"dark\" or \"alpha\": which pixels are smoke",
            )),
        }
    }

    /// What is taken of pixels about which the scene says nothing: the luminance, or the alpha of a picture that is transparent
    /// somewhere and of one colour elsewhere.
    pub(super) fn of(pixels: &Pixels) -> Self {
        if pixels.are_transparent() && pixels.are_of_one_colour() {
            Self::Alpha
        } else {
            Self::Light
        }
    }

    /// Its name in a sentence.
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Light => "luminance",
            Self::Dark => "dark ink",
            Self::Alpha => "alpha",
        }
    }

    /// What to write where this was the wrong one.
    pub(super) fn other(self) -> &'static str {
        match self {
            Self::Light => "if the drawing is dark on light, write ink = \"dark\" beside `image`",
            Self::Dark => "if the drawing is light on dark, write ink = \"light\" beside `image`",
            Self::Alpha => "if its colours are the drawing, write ink = \"light\" or \"dark\" beside `image`",
        }
    }

    /// Densities 0 ..= 1 of `pixels`, bottom row first. What is lighter than white, as EXR has it, is white.
    pub(super) fn densities(self, pixels: &Pixels) -> Vec<f64> {
        let rows = 0..pixels.height;
        rows.flat_map(|row| self.row(pixels, row)).collect()
    }

    /// The same of row `row` from the bottom.
    pub(super) fn row(self, pixels: &Pixels, row: usize) -> impl Iterator<Item = f64> {
        let top = pixels.top();
        let grey = pixels.is_grey();
        let value = move |index: usize| {
            let [red, green, blue, alpha] = pixels.levels(index);
            let luminance = if grey {
                red / top
            } else {
                (0.2126 * red + 0.7152 * green + 0.0722 * blue) / top
            };
            let luminance = luminance.clamp(0.0, 1.0);
            let alpha = (alpha / top).clamp(0.0, 1.0);
            match self {
                Self::Light => luminance * alpha,
                Self::Dark => (1.0 - luminance) * alpha,
                Self::Alpha => alpha,
            }
        };
        let first = (pixels.height - 1 - row) * pixels.width;
        (first..first + pixels.width).map(value)
    }
}
