//! Which of a picture's pixels are smoke: the opaque, the light or the dark ones.

use png::ColorType;

use super::ShapeError;

/// Colours that differ by no more than this part of the brightest level are one colour: rounding makes so much in a half
/// transparent edge.
const ONE_COLOUR: f64 = 2.5 / 255.0;

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
    pub(super) fn of(pixels: &Pixels<'_>) -> Self {
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
}

/// The pixels of a decoded picture, row by row from the top.
pub(super) struct Pixels<'a> {
    pub bytes: &'a [u8],
    pub color: ColorType,
    /// Whether a sample has 16 bits, and not 8.
    pub wide: bool,
}

impl Pixels<'_> {
    /// The level of white, and of an opaque pixel.
    fn top(&self) -> f64 {
        if self.wide { 65535.0 } else { 255.0 }
    }

    /// Bytes of a pixel.
    fn stride(&self) -> usize {
        self.color.samples() * if self.wide { 2 } else { 1 }
    }

    fn has_alpha(&self) -> bool {
        matches!(self.color, ColorType::GrayscaleAlpha | ColorType::Rgba)
    }

    /// The levels of red, green, blue and alpha in the bytes of one pixel.
    fn levels(&self, pixel: &[u8]) -> [f64; 4] {
        let level = |sample: usize| match (self.wide, pixel) {
            (true, bytes) => bytes.get(2 * sample..2 * sample + 2).map_or(0.0, |pair| {
                pair.iter()
                    .fold(0.0, |level, &byte| 256.0 * level + f64::from(byte))
            }),
            (false, bytes) => bytes.get(sample).map_or(0.0, |&byte| f64::from(byte)),
        };
        let gray = matches!(self.color, ColorType::Grayscale | ColorType::GrayscaleAlpha);
        let [red, green, blue] = if gray { [0; 3] } else { [0, 1, 2] };
        let alpha = if self.has_alpha() {
            level(self.color.samples() - 1)
        } else {
            self.top()
        };
        [level(red), level(green), level(blue), alpha]
    }

    fn all(&self) -> impl Iterator<Item = [f64; 4]> {
        self.bytes
            .chunks_exact(self.stride())
            .map(|pixel| self.levels(pixel))
    }

    /// Whether a pixel is less than opaque.
    pub(super) fn are_transparent(&self) -> bool {
        let top = self.top();
        self.has_alpha() && self.all().any(|[.., alpha]| alpha < top)
    }

    /// Whether all pixels that can be seen well have one colour.
    fn are_of_one_colour(&self) -> bool {
        let densest = self.all().map(|[.., alpha]| alpha).fold(0.0, f64::max);
        let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        for [red, green, blue, alpha] in self.all() {
            if alpha > 0.5 * densest {
                for (channel, level) in [red, green, blue].into_iter().enumerate() {
                    low[channel] = low[channel].min(level);
                    high[channel] = high[channel].max(level);
                }
            }
        }
        let most = ONE_COLOUR * self.top();
        low.iter().zip(high).all(|(&low, high)| !(high - low > most))
    }

    /// One number for a grey pixel, red, green and blue for one of colour: 0 ..= 1, from the top, as they are stored. Alpha is left out.
    pub(super) fn channels(&self) -> (usize, Vec<f64>) {
        let count = if self.color.samples() < 3 { 1 } else { 3 };
        let top = self.top();
        let values = self
            .all()
            .flat_map(|levels| levels.into_iter().take(count).map(move |level| level / top));
        (count, values.collect())
    }

    /// Densities 0 ..= 1 of rows of `width` pixels, bottom row first.
    pub(super) fn densities(&self, ink: Ink, width: usize) -> Vec<f64> {
        let top = self.top();
        let gray = self.color.samples() < 3;
        let value = |pixel: &[u8]| {
            let [red, green, blue, alpha] = self.levels(pixel);
            let luminance = if gray {
                red / top
            } else {
                (0.2126 * red + 0.7152 * green + 0.0722 * blue) / top
            };
            match ink {
                Ink::Light => luminance * (alpha / top),
                Ink::Dark => (1.0 - luminance) * (alpha / top),
                Ink::Alpha => alpha / top,
            }
        };
        let rows = self.bytes.chunks_exact(self.stride() * width.max(1)).rev();
        rows.flat_map(|row| row.chunks_exact(self.stride()).map(value))
            .collect()
    }
}
