//! A picture, and how it becomes a PNG file.

use png::{BitDepth, ColorType, Compression, Encoder, EncodingError, Filter};

use super::render::palette::Palette;

/// Pixels, row by row from the top.
#[derive(Clone)]
pub(crate) struct Picture {
    pub width: usize,
    pub height: usize,
    pub bytes: Vec<u8>,
    pub colours: Colours,
}

/// What the bytes of a picture are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Colours {
    /// A level for each pixel; the palette says what colour it has.
    Of(Palette),
    /// Red, green and blue for each pixel.
    Each,
}

impl Picture {
    /// Red, green and blue of every pixel.
    pub fn rgb(&self) -> Vec<[u8; 3]> {
        match self.colours {
            Colours::Of(palette) => {
                let colours = palette.colours();
                let levels = self.bytes.iter();
                levels.map(|&level| colours[usize::from(level)]).collect()
            }
            Colours::Each => self.bytes.as_chunks().0.to_vec(),
        }
    }

    /// The bytes of a PNG file.
    pub fn to_png(&self) -> Result<Vec<u8>, EncodingError> {
        let mut bytes = Vec::new();
        let mut writer = self.encoder(&mut bytes).write_header()?;
        writer.write_image_data(&self.bytes)?;
        writer.finish()?;
        Ok(bytes)
    }

    /// An encoder for pictures of this size and these colours.
    pub fn encoder<W: std::io::Write>(&self, sink: W) -> Encoder<'static, W> {
        let mut encoder = Encoder::new(sink, self.width as u32, self.height as u32);
        match self.colours {
            Colours::Of(palette) => {
                encoder.set_color(ColorType::Indexed);
                encoder.set_palette(palette.colours().as_flattened().to_vec());
            }
            Colours::Each => encoder.set_color(ColorType::Rgb),
        }
        encoder.set_depth(BitDepth::Eight);
        encoder.set_compression(Compression::Balanced);
        // Neighbouring levels are neighbouring colours, so differences compress well.
        encoder.set_filter(Filter::Adaptive);
        encoder
    }
}
