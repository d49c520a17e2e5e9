//! Puts frames of a result side by side: `cargo run --release --example strip -- RESULT_FOLDER STRIP.png STEP ...`.
//!
//! The picture of the README: `thurible solve examples/letter_f.toml -o out/letter_f`, then
//! `cargo run --release --example strip -- out/letter_f docs/images/letter_f.png 0 8 16 24 32 40`.

use std::fs::File;
use std::io::{BufReader, BufWriter};
use std::path::{Path, PathBuf};

/// Columns of background between frames.
const GAP: usize = 4;

/// Grey values, row by row.
struct Picture {
    width: usize,
    height: usize,
    grey: Vec<u8>,
}

fn main() -> Result<(), Box<dyn core::error::Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [folder, strip, steps @ ..] = &arguments[..] else {
        return Err("usage: strip RESULT_FOLDER STRIP.png STEP ...".into());
    };
    let frames = steps
        .iter()
        .map(|step| read(&frame(Path::new(folder), step)?))
        .collect::<Result<Vec<_>, _>>()?;
    let first = frames.first().ok_or("name at least one step")?;
    let (height, width) = (first.height, frames.len() * (first.width + GAP) - GAP);
    let mut grey = Vec::with_capacity(width * height);
    for y in 0..height {
        for (number, frame) in frames.iter().enumerate() {
            grey.extend(core::iter::repeat_n(255, if number > 0 { GAP } else { 0 }));
            grey.extend(
                frame
                    .grey
                    .chunks_exact(frame.width)
                    .nth(y)
                    .ok_or("frames of different sizes")?,
            );
        }
    }
    write(Path::new(strip), &Picture { width, height, grey })
}

/// The frame of a step, however many digits its name has.
fn frame(folder: &Path, step: &str) -> Result<PathBuf, Box<dyn core::error::Error>> {
    let number: usize = step.parse()?;
    let names = std::fs::read_dir(folder.join("frames"))?
        .map(|entry| entry.map(|entry| entry.path()))
        .collect::<Result<Vec<_>, _>>()?;
    let is_it = |path: &PathBuf| {
        let digits: String = path
            .file_stem()
            .map(|stem| {
                stem.to_string_lossy()
                    .chars()
                    .filter(char::is_ascii_digit)
                    .collect()
            })
            .unwrap_or_default();
        digits.parse() == Ok(number)
    };
    names
        .into_iter()
        .find(is_it)
        .ok_or_else(|| format!("there is no frame of step {step}").into())
}

fn read(path: &Path) -> Result<Picture, Box<dyn core::error::Error>> {
    let mut reader = png::Decoder::new(BufReader::new(File::open(path)?)).read_info()?;
    let mut bytes = vec![0; reader.output_buffer_size().ok_or("the frame is too large")?];
    let info = reader.next_frame(&mut bytes)?;
    let samples = info.color_type.samples();
    let grey = bytes[..info.buffer_size()]
        .chunks_exact(samples)
        .map(|pixel| pixel[0])
        .collect();
    Ok(Picture {
        width: info.width as usize,
        height: info.height as usize,
        grey,
    })
}

fn write(path: &Path, picture: &Picture) -> Result<(), Box<dyn core::error::Error>> {
    let mut encoder = png::Encoder::new(
        BufWriter::new(File::create(path)?),
        picture.width.try_into()?,
        picture.height.try_into()?,
    );
    encoder.set_color(png::ColorType::Grayscale);
    encoder.set_compression(png::Compression::High);
    encoder.write_header()?.write_image_data(&picture.grey)?;
    Ok(())
}
