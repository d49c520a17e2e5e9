//! Animated WebP: the container is written here, around pictures that are encoded without loss.
//!
//! The layout is that of the "WebP Container Specification" (Google): a RIFF file with the size of the canvas (`VP8X`), what holds for the
//! whole film (`ANIM`), and for every picture how long it is shown (`ANMF`) around the chunk of a still one (`VP8L`). Encoders in Rust
//! write stills alone, or wrap the C library.

use std::fs::File;
use std::io::{self, BufWriter, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use image_webp::{ColorType, EncodingError, WebPEncoder};

use super::OutputError;
use super::picture::Picture;

/// Bytes of a file before the size that it says, those included.
const BEFORE: u64 = 8;
/// Bytes before the chunk of a still picture: `RIFF`, a size, `WEBP`.
const STILL: usize = 12;
/// Pixels along a side, at most.
pub(crate) const WEBP_MOST: usize = 16383;
/// There is an animation.
const ANIMATION: u8 = 1 << 1;
/// A picture is put in the place of the one before, not over it.
const IN_PLACE: u8 = 1 << 1;

/// A film that is being written, a picture at a time.
pub(crate) struct Animated {
    file: BufWriter<File>,
    path: PathBuf,
    pictures: u64,
    /// Pictures a second.
    pace: f64,
}

impl Animated {
    /// A film of pictures of `width` by `height`, `pace` a second, which is shown again and again.
    pub fn begin(path: &Path, [width, height]: [usize; 2], pace: f64) -> Result<Self, OutputError> {
        let file = File::create(path).map_err(OutputError::of(path))?;
        let mut film = Self {
            file: BufWriter::new(file),
            path: path.to_owned(),
            pictures: 0,
            pace,
        };
        film.head(width, height).map_err(OutputError::of(path))?;
        Ok(film)
    }

    fn head(&mut self, width: usize, height: usize) -> io::Result<()> {
        // The size follows at the end.
        self.file.write_all(b"RIFF\0\0\0\0WEBP")?;
        self.chunk(
            b"VP8X",
            &[&[ANIMATION, 0, 0, 0], &less_one(width), &less_one(height)],
        )?;
        // A transparent ground, shown for ever.
        self.chunk(b"ANIM", &[&[0; 4], &[0; 2]])
    }

    /// A chunk of some parts, each of an even length but for the last.
    fn chunk(&mut self, name: &[u8; 4], parts: &[&[u8]]) -> io::Result<()> {
        let size: usize = parts.iter().map(|part| part.len()).sum();
        self.file.write_all(name)?;
        self.file.write_all(&word(size as u64)?)?;
        parts.iter().try_for_each(|part| self.file.write_all(part))?;
        self.file.write_all(&[0][..size % 2])
    }

    /// Appends a picture in colours.
    pub fn push(&mut self, picture: &Picture) -> Result<(), OutputError> {
        self.add(picture).map_err(OutputError::of(&self.path))
    }

    fn add(&mut self, picture: &Picture) -> io::Result<()> {
        let (width, height) = (picture.width, picture.height);
        let mut still = Vec::new();
        let encoder = WebPEncoder::new(&mut still);
        let encoded = encoder.encode(&picture.bytes, width as u32, height as u32, ColorType::Rgb8);
        encoded.map_err(|error| match error {
            EncodingError::IoError(error) => error,
            other => io::Error::other(other),
        })?;
        // Times are whole milliseconds: together they keep the pace.
        let shown = |picture: u64| (1000.0 * picture as f64 / self.pace).round() as u64;
        let duration = shown(self.pictures + 1) - shown(self.pictures);
        let place = [0; 6];
        let [low, middle, high, ..] = duration.to_le_bytes();
        let parts: [&[u8]; 5] = [
            &place,
            &less_one(width),
            &less_one(height),
            &[low, middle, high, IN_PLACE],
            still.get(STILL..).unwrap_or_default(),
        ];
        self.chunk(b"ANMF", &parts)?;
        self.pictures += 1;
        Ok(())
    }

    /// Ends the film.
    pub fn finish(mut self) -> Result<(), OutputError> {
        let ended = self.file.stream_position().and_then(|end| {
            self.file.seek(SeekFrom::Start(BEFORE - 4))?;
            self.file.write_all(&word(end - BEFORE)?)?;
            self.file.flush()
        });
        ended.map_err(OutputError::of(&self.path))
    }
}

/// A side of a picture, less one, in three bytes.
fn less_one(side: usize) -> [u8; 3] {
    let [low, middle, high, _] = (side as u32 - 1).to_le_bytes();
    [low, middle, high]
}

/// A size in four bytes.
fn word(size: u64) -> io::Result<[u8; 4]> {
    let size = u32::try_from(size);
    let size = size.map_err(|_| io::Error::other("a WebP film has at most 4 GiB; draw fewer steps"))?;
    Ok(size.to_le_bytes())
}
