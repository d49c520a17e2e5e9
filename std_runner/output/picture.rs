//! A picture of 256 levels, and how it becomes a PNG file.

use png::{BitDepth, ColorType, Compression, Encoder, EncodingError, Filter};

use super::render::palette::Palette;

/// Levels of light, row by row from the top; a palette says what colour a level has.
#[derive(Clone)]
pub(crate) struct Picture {
    pub width: usize,
    pub height: usize,
    pub levels: Vec<u8>,
    pub palette: Palette,
}

impl Picture {
    /// The bytes of a PNG file.
    pub fn to_png(&self) -> Result<Vec<u8>, EncodingError> {
        let mut bytes = Vec::new();
        let mut writer = self.encoder(&mut bytes).write_header()?;
        writer.write_image_data(&self.levels)?;
        writer.finish()?;
        Ok(bytes)
    }

    /// An encoder for pictures of this size and palette.
    pub fn encoder<W: std::io::Write>(&self, sink: W) -> Encoder<'static, W> {
        let mut encoder = Encoder::new(sink, self.width as u32, self.height as u32);
        encoder.set_color(ColorType::Indexed);
        encoder.set_depth(BitDepth::Eight);
        encoder.set_palette(self.palette.colours().as_flattened().to_vec());
        encoder.set_compression(Compression::Balanced);
        // Neighbouring levels are neighbouring colours, so differences compress well.
        encoder.set_filter(Filter::Adaptive);
        encoder
    }
}
