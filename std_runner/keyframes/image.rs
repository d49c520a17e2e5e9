//! `image = "x.png"`: a silhouette from a picture, y up.

use std::fs::File;
use std::io::BufReader;
use std::path::Path;

use png::{BitDepth, Decoder, Limits, Transformations};

use super::error::Fault;
use super::ink::{Ink, Pixels};
use super::note::Note;
use super::resample::{Edge, resample, windows};
use super::{Canvas, ShapeError};
use crate::bytes::{are_free, grouped};

/// Decoding may take this much memory, in bytes.
const MEMORY: usize = 1 << 30;
/// Sides beyond this are refused before anything is decoded.
const LONGEST_SIDE: u32 = 16384;

/// More than this part of a picture is rarely meant to be smoke.
const NEARLY_ALL: f64 = 0.5;

/// The picture, in its own proportions, as large as the box allows and centred in it; `ink` says which of its pixels are smoke.
pub(super) fn draw(
    path: &Path,
    ink: Option<&str>,
    canvas: &Canvas,
    notes: &mut Vec<Note>,
) -> Result<Vec<f64>, ShapeError> {
    if canvas.dimensions() != 2 {
        let remedy = "use `text`, `file` or the solid shapes in 3D";
        return Err(ShapeError::key("image", "is flat, and the grid is 3D", remedy));
    }
    let ink = ink.map(Ink::parse).transpose()?;
    let (picture, ink) = read(path, ink).map_err(|fault| fault.of("image", path))?;
    let smoke = picture.values.iter().sum::<f64>() / picture.values.len().max(1) as f64;
    let shown = path.display();
    let percent = 100.0 * smoke;
    notes.push(Note::remark(format!(
        "smoke is the {} of `{shown}`, {percent:.1} % of the picture",
        ink.name()
    )));
    if smoke > NEARLY_ALL {
        let other = ink.other();
        notes.push(Note::warning(format!(
            "{percent:.0} % of the picture `{shown}` becomes smoke; {other}"
        )));
    }
    Ok(fit(picture, canvas))
}

/// Values 0 ..= 1, row by row from the bottom.
pub(super) struct Picture {
    pub width: usize,
    pub height: usize,
    pub values: Vec<f64>,
}

fn fit(picture: Picture, canvas: &Canvas) -> Vec<f64> {
    let shape = [picture.width, picture.height];
    let pixels_a_cell = shape
        .iter()
        .zip(&canvas.cells)
        .map(|(&pixels, &cells)| pixels as f64 / cells as f64);
    let step = pixels_a_cell.fold(0.0, f64::max);
    let taps: Vec<_> = shape
        .iter()
        .zip(&canvas.cells)
        .map(|(&pixels, &cells)| {
            let start = 0.5 * (pixels as f64 - cells as f64 * step);
            windows(cells, pixels, start, step, Edge::Empty)
        })
        .collect();
    resample(picture.values, &shape, &taps)
}

/// The bytes of a PNG file.
pub(super) struct Decoded {
    pub width: usize,
    pub height: usize,
    bytes: Vec<u8>,
    color: png::ColorType,
    wide: bool,
}

impl Decoded {
    /// Its pixels, row by row from the top.
    pub fn pixels(&self) -> Pixels<'_> {
        Pixels {
            bytes: &self.bytes,
            color: self.color,
            wide: self.wide,
        }
    }
}

/// The picture, and which of its pixels are smoke: those that are `asked` for, or what they say themselves.
pub(super) fn read(path: &Path, asked: Option<Ink>) -> Result<(Picture, Ink), Fault> {
    let decoded = decoded(path)?;
    let pixels = decoded.pixels();
    if asked == Some(Ink::Alpha) && !pixels.are_transparent() {
        return Err(Fault::content(
            "is opaque everywhere, and `ink` is \"alpha\"",
            "write ink = \"dark\" or \"light\"",
        ));
    }
    let ink = asked.unwrap_or_else(|| Ink::of(&pixels));
    let picture = Picture {
        width: decoded.width,
        height: decoded.height,
        values: pixels.densities(ink, decoded.width),
    };
    Ok((picture, ink))
}

/// Reads a PNG file.
pub(super) fn decoded(path: &Path) -> Result<Decoded, Fault> {
    let file = BufReader::new(File::open(path)?);
    let broken = |error: png::DecodingError| match error {
        png::DecodingError::IoError(error) if error.kind() == std::io::ErrorKind::IsADirectory => {
            Fault::Read(error)
        }
        other => Fault::content(
            format!("cannot be read as PNG ({other})"),
            "pictures are PNG: save it as one",
        ),
    };
    let mut decoder = Decoder::new_with_limits(file, Limits { bytes: MEMORY });
    decoder.set_transformations(Transformations::EXPAND);
    let header = decoder.read_header_info().map_err(broken)?;
    let (width, height) = (header.width, header.height);
    if width > LONGEST_SIDE || height > LONGEST_SIDE {
        let remedy =
            format!("make it at most {LONGEST_SIDE} pixels wide and high; the size of the grid is enough");
        return Err(Fault::content(format!("is {width} x {height} pixels"), remedy));
    }
    let mut reader = decoder.read_info().map_err(broken)?;
    let size = reader
        .output_buffer_size()
        .ok_or_else(|| Fault::content("is too large", "make it smaller"))?;
    let needed = size + size_of::<f64>() * width as usize * height as usize;
    if !are_free(needed) {
        let remedy = "make it smaller: the size of the grid is enough";
        return Err(Fault::content(
            format!(
                "takes {} bytes to read, and the system has not so many",
                grouped(needed)
            ),
            remedy,
        ));
    }
    let mut bytes = vec![0; size];
    let frame = reader.next_frame(&mut bytes).map_err(broken)?;
    if !matches!(frame.bit_depth, BitDepth::Eight | BitDepth::Sixteen) {
        return Err(Fault::content(
            "has an unusual depth",
            "save it with 8 or 16 bits a channel",
        ));
    }
    bytes.truncate(frame.buffer_size());
    Ok(Decoded {
        width: frame.width as usize,
        height: frame.height as usize,
        bytes,
        color: frame.color_type,
        wide: frame.bit_depth == BitDepth::Sixteen,
    })
}
