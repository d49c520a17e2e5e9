//! `image = "x.png"`: a silhouette from a picture, y up.

use std::fs::File;
use std::io::BufReader;
use std::path::Path;

use png::{BitDepth, ColorType, Decoder, Limits, Transformations};

use super::error::Fault;
use super::resample::{Edge, resample, windows};
use super::{Canvas, ShapeError};
use crate::bytes::{are_free, grouped};

/// Decoding may take this much memory, in bytes.
const MEMORY: usize = 1 << 30;
/// Sides beyond this are refused before anything is decoded.
const LONGEST_SIDE: u32 = 16384;

/// The picture, in its own proportions, as large as the box allows and centred in it.
pub(super) fn draw(path: &Path, canvas: &Canvas) -> Result<Vec<f64>, ShapeError> {
    if canvas.dimensions() != 2 {
        let remedy = "use `text`, `file` or the solid shapes in 3D";
        return Err(ShapeError::key("image", "is flat, and the grid is 3D", remedy));
    }
    let picture = read(path).map_err(|fault| fault.of("image", path))?;
    Ok(fit(picture, canvas))
}

/// Values 0 ..= 1, row by row from the bottom.
struct Picture {
    width: usize,
    height: usize,
    values: Vec<f64>,
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

fn read(path: &Path) -> Result<Picture, Fault> {
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
    decoder.set_transformations(Transformations::normalize_to_color8());
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
    if frame.bit_depth != BitDepth::Eight {
        return Err(Fault::content(
            "has an unusual depth",
            "save it with 8 bits a channel",
        ));
    }
    let values = densities(
        &bytes[..frame.buffer_size()],
        frame.color_type,
        frame.width as usize,
    );
    Ok(Picture {
        width: frame.width as usize,
        height: frame.height as usize,
        values,
    })
}

/// The alpha of a picture that is transparent somewhere, the luminance of any other, bottom row first.
fn densities(bytes: &[u8], color: ColorType, width: usize) -> Vec<f64> {
    let channels = color.samples();
    let has_alpha = matches!(color, ColorType::GrayscaleAlpha | ColorType::Rgba);
    let alpha = |pixel: &[u8]| f64::from(pixel[channels - 1]) / 255.0;
    let transparent = has_alpha
        && bytes
            .chunks_exact(channels)
            .any(|pixel| pixel[channels - 1] < 255);
    let value = |pixel: &[u8]| match pixel {
        pixel if transparent => alpha(pixel),
        [red, green, blue, ..] => {
            (0.2126 * f64::from(*red) + 0.7152 * f64::from(*green) + 0.0722 * f64::from(*blue)) / 255.0
        }
        [gray, ..] => f64::from(*gray) / 255.0,
        [] => 0.0,
    };
    let rows = bytes.chunks_exact(channels * width).rev();
    rows.flat_map(|row| row.chunks_exact(channels).map(value))
        .collect()
}
