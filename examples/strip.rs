//! Puts frames of results side by side, a row for each result:
//! `cargo run --release --example strip -- PICTURE.png HEIGHT RESULT_FOLDER STEP ... [-- RESULT_FOLDER STEP ...]`.
//!
//! Frames are drawn HEIGHT pixels high, by means of the pixels that they have. docs/gallery.md has the commands of its pictures.

use std::fs::File;
use std::io::{BufReader, BufWriter};
use std::path::{Path, PathBuf};

type Failure = Box<dyn core::error::Error>;

/// Pixels of background between frames.
const GAP: usize = 4;

/// Colours, row by row, three bytes each.
struct Picture {
    width: usize,
    height: usize,
    colours: Vec<[u8; 3]>,
}

fn main() -> Result<(), Failure> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [picture, height, rows @ ..] = &arguments[..] else {
        return Err(
            "usage: strip PICTURE.png HEIGHT RESULT_FOLDER STEP ... [-- RESULT_FOLDER STEP ...]".into(),
        );
    };
    let height: usize = height.parse()?;
    let rows = rows.split(|argument| argument == "--");
    let rows = rows
        .map(|row| strip(row, height))
        .collect::<Result<Vec<_>, _>>()?;
    let width = rows.iter().map(|row| row.width).max().unwrap_or(0);
    let mut whole = Picture {
        width,
        height: rows.len() * (height + GAP) - GAP,
        colours: Vec::new(),
    };
    for (number, row) in rows.iter().enumerate() {
        let gap = if number > 0 { GAP * width } else { 0 };
        whole.colours.extend(core::iter::repeat_n([255; 3], gap));
        for line in row.colours.chunks_exact(row.width) {
            whole.colours.extend(line);
            whole
                .colours
                .extend(core::iter::repeat_n([255; 3], width - row.width));
        }
    }
    write(Path::new(picture), &whole)
}

/// The frames of one result beside each other.
fn strip(row: &[String], height: usize) -> Result<Picture, Failure> {
    let [folder, steps @ ..] = row else {
        return Err("name a result folder and its steps".into());
    };
    let frames = steps
        .iter()
        .map(|step| Ok(read(&frame(Path::new(folder), step)?)?.resized(height)))
        .collect::<Result<Vec<_>, Failure>>()?;
    let first = frames.first().ok_or("name at least one step")?;
    let mut strip = Picture {
        width: frames.len() * (first.width + GAP) - GAP,
        height,
        colours: Vec::new(),
    };
    for y in 0..height {
        for (number, frame) in frames.iter().enumerate() {
            strip
                .colours
                .extend(core::iter::repeat_n([255; 3], if number > 0 { GAP } else { 0 }));
            let line = frame.colours.chunks_exact(frame.width).nth(y);
            strip.colours.extend(line.ok_or("frames of different sizes")?);
        }
    }
    Ok(strip)
}

impl Picture {
    /// The same so many pixels high, each the mean of those that it covers.
    fn resized(&self, height: usize) -> Self {
        let width = (self.width * height / self.height).max(1);
        let span = |at: usize, count: usize, all: usize| {
            let begin = at * all / count;
            begin..((at + 1) * all / count).max(begin + 1)
        };
        let pixel = |at: usize| {
            let (mut sum, mut count) = ([0usize; 3], 0);
            for y in span(at / width, height, self.height) {
                for x in span(at % width, width, self.width) {
                    let colour = self.colours[y * self.width + x];
                    sum.iter_mut()
                        .zip(colour)
                        .for_each(|(sum, part)| *sum += usize::from(part));
                    count += 1;
                }
            }
            sum.map(|sum| (sum / count) as u8)
        };
        Self {
            width,
            height,
            colours: (0..width * height).map(pixel).collect(),
        }
    }
}

/// The frame of a step, however many digits its name has.
fn frame(folder: &Path, step: &str) -> Result<PathBuf, Failure> {
    let number: usize = step.parse()?;
    // The frames of a result, or of `thurible render`.
    let frames = folder.join("frames");
    let names = std::fs::read_dir(if frames.is_dir() { frames } else { folder.into() })?
        .map(|entry| entry.map(|entry| entry.path()))
        .collect::<Result<Vec<_>, _>>()?;
    let is_it = |path: &PathBuf| {
        let stem = path.file_stem().map(|stem| stem.to_string_lossy().into_owned());
        let digits: String = stem
            .unwrap_or_default()
            .chars()
            .filter(char::is_ascii_digit)
            .collect();
        digits.parse() == Ok(number)
    };
    let found = names.into_iter().find(is_it);
    found.ok_or_else(|| format!("there is no frame of step {step} in {}", folder.display()).into())
}

fn read(path: &Path) -> Result<Picture, Failure> {
    let mut decoder = png::Decoder::new(BufReader::new(File::open(path)?));
    decoder.set_transformations(png::Transformations::normalize_to_color8());
    let mut reader = decoder.read_info()?;
    let mut bytes = vec![0; reader.output_buffer_size().ok_or("the frame is too large")?];
    let info = reader.next_frame(&mut bytes)?;
    let samples = info.color_type.samples();
    let colour = |pixel: &[u8]| {
        if samples < 3 {
            [pixel[0]; 3]
        } else {
            [pixel[0], pixel[1], pixel[2]]
        }
    };
    Ok(Picture {
        width: info.width as usize,
        height: info.height as usize,
        colours: bytes[..info.buffer_size()]
            .chunks_exact(samples)
            .map(colour)
            .collect(),
    })
}

fn write(path: &Path, picture: &Picture) -> Result<(), Failure> {
    let mut encoder = png::Encoder::new(
        BufWriter::new(File::create(path)?),
        picture.width.try_into()?,
        picture.height.try_into()?,
    );
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_compression(png::Compression::High);
    encoder
        .write_header()?
        .write_image_data(picture.colours.as_flattened())?;
    Ok(())
}
