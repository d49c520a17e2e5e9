//! `thurible photograph DIR`: what cameras see of a result's smoke, as `tomography` takes it.

use crate::console;
use crate::exit::{DONE, FILE, Failure};
use crate::threads;
use crate::tomography::{Rig, photograph};
use clap::Args;
use core::ops::RangeInclusive;
use std::path::PathBuf;

/// Cameras, at most.
const MOST: usize = 1024;

/// Arguments of `photograph`.
#[derive(Args, Debug)]
pub struct PhotographArguments {
    /// A result folder, or a .npz or .npy file of densities whose first axis is time.
    #[arg(value_name = "DIR")]
    pub result: PathBuf,
    /// How many cameras stand around the smoke, over half a circle.
    #[arg(long, value_name = "N", default_value_t = 8, value_parser = count)]
    pub views: usize,
    /// The folder of views.
    #[arg(short, long, value_name = "DIR", default_value = "out/views")]
    pub output: PathBuf,
    /// The array of a .npz file.
    #[arg(long, value_name = "NAME", default_value = "density")]
    pub array: String,
    /// Cameras with perspective, a diagonal and a half away, and not ones that see from infinitely far.
    #[arg(long)]
    pub pinhole: bool,
    /// In 3D, how much the cameras are raised, in degrees [default: 15].
    #[arg(long, value_name = "DEGREES", value_parser = degrees, allow_hyphen_values = true)]
    pub elevation: Option<f64>,
    /// Pixels of a picture [default: those of the cells]; of a plane Wx1.
    #[arg(long, value_name = "WxH", value_parser = size)]
    pub size: Option<(usize, usize)>,
    /// Frames from the first to the last, or one [default: all].
    #[arg(long, value_name = "FROM..TO", value_parser = frames)]
    pub frames: Option<RangeInclusive<usize>>,
    /// Standard deviation of noise, in parts of the brightest pixel of a picture.
    #[arg(long, value_name = "PART", default_value_t = 0.0, value_parser = part)]
    pub noise: f64,
    /// Which noise.
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub seed: u64,
    /// Write over a file of views that was changed since it was written.
    #[arg(long)]
    pub force: bool,
    /// Threads [default: as many as the machine offers].
    #[arg(long, value_name = "N", value_parser = threads::parse)]
    pub threads: Option<usize>,
    /// Print nothing but errors.
    #[arg(long)]
    pub quiet: bool,
}

/// Takes the photographs; the answer is the exit code.
pub fn run(arguments: &PhotographArguments) -> Result<u8, Failure> {
    let rig = Rig {
        result: arguments.result.clone(),
        array: arguments.array.clone(),
        views: arguments.views,
        folder: arguments.output.clone(),
        pinhole: arguments.pinhole,
        elevation: arguments.elevation,
        size: arguments.size,
        frames: arguments.frames.clone(),
        noise: arguments.noise,
        seed: arguments.seed,
        force: arguments.force,
    };
    let threads = arguments.threads.unwrap_or_else(threads::available);
    let written = threads::with(threads, || {
        threads::together(threads, |exec| photograph(&rig, exec))
    })??;
    if !arguments.quiet {
        let folder = written.shown().display();
        console::print(&format!(
            "views in {folder}; thurible tomography {folder} reconstructs them"
        ));
    }
    if let Some(why) = written.diverted() {
        console::error(&format!("thurible: {why}"));
        return Ok(FILE);
    }
    Ok(DONE)
}

fn count(text: &str) -> Result<usize, String> {
    match text.parse() {
        Ok(count) if (1..=MOST).contains(&count) => Ok(count),
        _ => Err(format!(
            "found \"{text}\", allowed is a whole number from 1 to {MOST}"
        )),
    }
}

fn degrees(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(angle) if (-90.0..=90.0).contains(&angle) => Ok(angle),
        _ => Err(format!("found \"{text}\", allowed is an angle from -90 to 90")),
    }
}

fn part(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(part) if (0.0..=1.0).contains(&part) => Ok(part),
        _ => Err(format!("found \"{text}\", allowed is a number from 0 to 1")),
    }
}

fn size(text: &str) -> Result<(usize, usize), String> {
    let sides = text
        .split_once('x')
        .map(|(width, height)| (width.parse(), height.parse()));
    match sides {
        Some((Ok(width), Ok(height))) if (1..=16384).contains(&width) && (1..=16384).contains(&height) => {
            Ok((width, height))
        }
        _ => Err(format!(
            "found \"{text}\", allowed is width x height in pixels, as in 128x96"
        )),
    }
}

fn frames(text: &str) -> Result<RangeInclusive<usize>, String> {
    let wrong = || format!("found \"{text}\", allowed is a frame, or the first and the last, as in 20..60");
    let number = |text: &str| text.parse::<usize>().map_err(|_| wrong());
    let (first, last) = match text.split_once("..") {
        Some((first, last)) => (number(first)?, number(last.trim_start_matches('='))?),
        None => (number(text)?, number(text)?),
    };
    if first > last {
        return Err(wrong());
    }
    Ok(first..=last)
}
