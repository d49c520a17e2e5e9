//! `thurible render DIR`: the steps of a result as large pictures, or as a film.

use super::studio::{Format, Set, Studio};
use crate::address_space;
use crate::bytes::{self, are_free, rounded};
use crate::exit::Failure;
use crate::export::TimeScale;
use crate::output::{Angles, Movie, Reel, Shot, Vectors, WEBP_MOST};
use crate::progress::{Display, Mode};
use crate::refine::{Finer, Plan};
use crate::region::Region;
use crate::threads;
use clap::Args;
use core::ops::RangeInclusive;
use std::path::{Path, PathBuf};

/// The size of a picture in 3D, and about that of one in 2D along its longer side.
const SIZE: (usize, usize) = (1280, 720);
const FLAT: usize = 1024;
/// Pixels along a side, at most.
const MOST: usize = 16384;
/// The exposure is at most so many stops more or less.
const STOPS: f32 = 16.0;
/// Pictures of WebP a second, at most.
const WEBP_FASTEST: f64 = 90.0;
/// Detail, where nothing is said.
const DETAIL: f32 = 0.5;

/// Why what is about a camera is refused in 2D.
const FACE_ON: &str = "a result in 2D is drawn face on as it is; leave it out";

/// Arguments of `render`.
#[derive(Args, Debug)]
pub struct RenderArguments {
    /// The result folder.
    #[arg(value_name = "DIR")]
    pub result: PathBuf,
    /// Where the pictures go [default: DIR/render].
    #[arg(short, long, value_name = "DIR")]
    pub output: Option<PathBuf>,
    /// Width and height in pixels [default: 1280x720; in 2D the cells by a whole factor, near 1024].
    #[arg(long, value_name = "WxH", value_parser = size)]
    pub size: Option<(usize, usize)>,
    /// Steps from the first to the last, or one [default: all].
    #[arg(long, value_name = "FROM..TO", value_parser = steps)]
    pub steps: Option<RangeInclusive<usize>>,
    /// Cells 2, 4 or 8 times as fine in every direction: the scene is drawn again, and the flow of the result carries its smoke anew.
    #[arg(long, value_name = "2|4|8", value_parser = scale)]
    pub scale: Option<usize>,
    /// With --scale, the scene file, beside which the files of its shapes are looked for [default: where it was].
    #[arg(long, value_name = "FILE", requires = "scale")]
    pub scene: Option<PathBuf>,
    /// With --scale, ceiling for the memory, as in 4GiB [default: the machine's memory].
    #[arg(long, value_name = "SIZE", requires = "scale", value_parser = bytes::parse)]
    pub memory_limit: Option<usize>,
    /// What is written: a PNG or OpenEXR (linear light) file for each step, or a film.
    #[arg(long, value_enum, default_value_t = Format::Png)]
    pub format: Format,
    /// Pictures of a film a second [default: 1 / dt where that is 10 to 240, of WebP to 90, else 24].
    #[arg(long, value_name = "N", value_parser = fps)]
    pub fps: Option<f64>,
    /// In 3D, from where: turned from the front to the right, and raised, in degrees [default: 24,14].
    #[arg(long, value_name = "AZIMUTH,ELEVATION", value_parser = angles, allow_hyphen_values = true)]
    pub camera: Option<Angles>,
    /// Stops of light more, or less.
    #[arg(long, value_name = "STOPS", value_parser = stops, default_value = "0", allow_hyphen_values = true)]
    pub exposure: f32,
    /// In 3D, detail finer than the cells, 0 to 1: noise that goes with the flow; 0 is the smoke of the result alone [default: 0.5].
    #[arg(long, value_name = "AMOUNT", value_parser = detail)]
    pub detail: Option<f32>,
    /// In 2D, arrows of the force or the velocity over the smoke.
    #[arg(long, value_enum)]
    pub arrows: Option<Vectors>,
    /// In 2D, streaklines over the smoke: where the flow carries what it meets at fixed places.
    #[arg(long)]
    pub streaklines: bool,
    /// Threads [default: as many as the machine offers].
    #[arg(long, value_name = "N", value_parser = threads::parse)]
    pub threads: Option<usize>,
    /// Print nothing but errors.
    #[arg(long, conflicts_with = "json")]
    pub quiet: bool,
    /// Print JSON lines.
    #[arg(long)]
    pub json: bool,
}

/// Draws the pictures; the answer is the exit code.
pub fn run(arguments: &RenderArguments) -> Result<u8, Failure> {
    if arguments.format == Format::Mp4 && !Movie::can_be_made() {
        return Err(Failure::Input("--format mp4: there is no ffmpeg on the PATH, which makes films; install it, or write pictures by --format png".into()));
    }
    let mut reel = open(&arguments.result)?;
    check_lines(arguments, &mut reel)?;
    check_detail(arguments, &reel)?;
    reel.draw_over(arguments.arrows, arguments.streaklines);
    let shot = shot(arguments, &reel)?;
    let steps = arguments.steps.clone().unwrap_or(0..=reel.steps());
    if *steps.end() > reel.steps() {
        return Err(Failure::Input(format!(
            "--steps {}..{}: the result has the steps 0 to {}; name some of those",
            steps.start(),
            steps.end(),
            reel.steps()
        )));
    }
    let count = arguments.threads.unwrap_or_else(threads::available);
    let plan = plan(arguments, (&reel, &shot), count)?;
    let bytes = reel.bytes(plan.as_ref().map(Plan::cells), &shot);
    if !are_free(bytes) {
        return Err(Failure::Memory(format!(
            "a picture of {} x {} takes some {}, which the system has not; ask for a smaller one with --size",
            shot.width,
            shot.height,
            rounded(bytes)
        )));
    }
    let folder = arguments.output.clone();
    let folder = folder.unwrap_or_else(|| arguments.result.join("render"));
    // On the way to a step of finer cells the smoke goes through all before it, after step 0.
    let first = if plan.is_some() {
        (*steps.start()).min(1)
    } else {
        *steps.start()
    };
    let display = Display::new(mode(arguments), steps.end() - first + 1);
    let pace = pace(arguments, reel.dt())?;
    let studio = Studio::new(&folder, (arguments.format, pace), shot, display)?;
    address_space::check(count)?;
    let Some(plan) = plan else {
        return threads::with(count, || studio.render(Set { reel, finer: None }, steps))?;
    };
    let taken = Region::new(plan.bytes);
    let mut region = taken.ok_or_else(|| plan.no_memory(plan.bytes))?;
    let block = region
        .carve(plan.block)
        .ok_or_else(|| plan.no_memory(plan.bytes))?;
    threads::with(count, || {
        let mut reel = reel;
        let finer = Some(Finer::begin(&plan, block, &mut reel)?);
        studio.render(Set { reel, finer }, steps)
    })?
}

/// Pictures a second, where steps are `dt` long.
fn pace(arguments: &RenderArguments, dt: f64) -> Result<f64, Failure> {
    let pace = TimeScale::of(dt, arguments.fps).fps;
    match (arguments.format, arguments.fps) {
        (Format::Png | Format::Exr, Some(asked)) => Err(Failure::Input(format!(
            "--fps {asked}: pictures have no rate; leave it out, or write a film by --format mp4 or webp"
        ))),
        (Format::Webp, Some(asked)) if asked > WEBP_FASTEST => Err(Failure::Input(format!(
            "--fps {asked}: pages show pictures of WebP of 10 ms and less ten times as long; ask for at most {WEBP_FASTEST}, or --format mp4"
        ))),
        (Format::Webp, None) if pace > WEBP_FASTEST => Ok(TimeScale::FILM),
        _ => Ok(pace),
    }
}

/// What `--scale` takes, if it is asked for.
fn plan(
    arguments: &RenderArguments,
    (reel, shot): (&Reel, &Shot),
    threads: usize,
) -> Result<Option<Plan>, Failure> {
    let Some(scale) = arguments.scale else {
        return Ok(None);
    };
    if !reel.has(Vectors::Velocity) {
        return Err(Failure::Input(format!(
            "--scale {scale}: {} has no velocity, which carries the smoke on finer cells; solve it again",
            reel.archive().display()
        )));
    }
    let drawing = |finer: &[usize]| reel.bytes(Some(finer), shot);
    let of = (arguments.result.as_path(), scale);
    let plan = Plan::new(of, arguments.scene.as_deref(), threads, &drawing)?;
    plan.check_memory(arguments.memory_limit)?;
    Ok(Some(plan))
}

/// Refuses arrows and streaklines in a box, or of vectors that the result has not.
fn check_lines(arguments: &RenderArguments, reel: &mut Reel) -> Result<(), Failure> {
    let arrows = arguments.arrows.map(|vectors| ("--arrows", vectors));
    let streaklines = arguments
        .streaklines
        .then_some(("--streaklines", Vectors::Velocity));
    for (option, vectors) in arrows.into_iter().chain(streaklines) {
        if reel.cells().len() != 2 {
            let why = "a result in 3D is drawn without lines; leave it out";
            return Err(Failure::Input(format!("{option}: {why}")));
        }
        if !reel.has(vectors) {
            return Err(Failure::Input(format!(
                "{option}: {} has no {}; solve it again, or leave it out",
                reel.archive().display(),
                vectors.name()
            )));
        }
    }
    if arguments.arrows == Some(Vectors::Force) && !reel.is_steered()? {
        return Err(Failure::Input(format!(
            "--arrows force: nothing steers the flow of {}, whose forces are what rounding leaves; draw --arrows velocity, or leave it out",
            reel.archive().display()
        )));
    }
    Ok(())
}

/// Refuses detail in a plane, or without a flow for it to go with.
fn check_detail(arguments: &RenderArguments, reel: &Reel) -> Result<(), Failure> {
    let Some(amount) = arguments.detail else {
        return Ok(());
    };
    if reel.cells().len() == 2 {
        return Err(Failure::Input(format!("--detail: {FACE_ON}")));
    }
    if amount > 0.0 && !reel.has(Vectors::Velocity) {
        return Err(Failure::Input(format!(
            "--detail {amount}: {} has no velocity, which detail goes with; leave it out",
            reel.archive().display()
        )));
    }
    Ok(())
}

fn mode(arguments: &RenderArguments) -> Mode {
    match (arguments.quiet, arguments.json) {
        (true, _) => Mode::Quiet,
        (_, true) => Mode::Json,
        _ => Mode::Human,
    }
}

fn open(folder: &Path) -> Result<Reel, Failure> {
    if !folder.is_dir() {
        let folder = folder.display();
        return Err(Failure::File(format!(
            "there is no folder {folder}; name a result folder"
        )));
    }
    Reel::open(folder)?.ok_or_else(|| {
        Failure::Input(format!(
            "{} is no result folder: it has not both report.json and result.npz as thurible writes them; name a folder that `thurible solve` or `simulate` wrote",
            folder.display()
        ))
    })
}

/// How pictures of a result are taken.
fn shot(arguments: &RenderArguments, reel: &Reel) -> Result<Shot, Failure> {
    let finer = |count: &usize| count * arguments.scale.unwrap_or(1);
    let cells: Vec<usize> = reel.cells().iter().map(finer).collect();
    let (width, height) = match (cells.as_slice(), arguments.size) {
        (&[nx, ny], Some((width, height))) if width < nx || height < ny => {
            return Err(Failure::Input(format!(
                "--size {width}x{height}: there are {nx} x {ny} cells, each of which takes a pixel at least; ask for a larger size"
            )));
        }
        (_, Some(size)) => size,
        (&[nx, ny], None) => {
            let factor = ((FLAT + nx.max(ny) / 2) / nx.max(ny)).max(1);
            (nx * factor, ny * factor)
        }
        (_, None) => SIZE,
    };
    if arguments.camera.is_some() && reel.cells().len() == 2 {
        return Err(Failure::Input(format!("--camera: {FACE_ON}")));
    }
    if arguments.format == Format::Webp && width.max(height) > WEBP_MOST {
        return Err(Failure::Input(format!(
            "--size {width}x{height}: a side of a WebP file has at most {WEBP_MOST} pixels; ask for a smaller size, or another format"
        )));
    }
    Ok(Shot {
        width,
        height,
        angles: arguments.camera.unwrap_or_default(),
        gain: arguments.exposure.exp2(),
        detail: arguments.detail.unwrap_or(DETAIL),
    })
}

/// Reads steps a second; the error says what is allowed.
pub(super) fn fps(text: &str) -> Result<f64, String> {
    let number = |text: &str| text.trim().parse::<f64>().ok();
    let rate = match text.split_once('/') {
        Some((frames, seconds)) => {
            number(frames).and_then(|frames| Some(frames / number(seconds).filter(|&count| count > 0.0)?))
        }
        None => number(text),
    };
    rate.filter(|rate| (0.01..=10_000.0).contains(rate))
        .ok_or_else(|| {
            format!("found \"{text}\", allowed is a number from 0.01 to 10000, or two as in 24000/1001")
        })
}

/// Reads `1280x720`; the error says what is allowed.
fn size(text: &str) -> Result<(usize, usize), String> {
    let side = |text: &str| text.trim().parse().ok().filter(|side| (1..=MOST).contains(side));
    text.split_once(['x', 'X'])
        .and_then(|(width, height)| Some((side(width)?, side(height)?)))
        .ok_or_else(|| {
            format!(
                "found \"{text}\", allowed are width and height in pixels, 1 to {MOST} each, as in 1280x720"
            )
        })
}

/// Reads how many times as fine cells are to be; the error says what is allowed.
fn scale(text: &str) -> Result<usize, String> {
    let scale = text.trim().parse().ok();
    scale.filter(|scale| [2, 4, 8].contains(scale)).ok_or_else(|| {
        format!("found \"{text}\", allowed are 2, 4 and 8: how many times as fine cells are to be")
    })
}

/// Reads `10..40` or `10`; the error says what is allowed.
pub(super) fn steps(text: &str) -> Result<RangeInclusive<usize>, String> {
    let step = |text: &str| text.trim().parse::<usize>().ok();
    let (first, last) = text.split_once("..").unwrap_or((text, text));
    match (step(first), step(last)) {
        (Some(first), Some(last)) if first <= last => Ok(first..=last),
        _ => Err(format!(
            "found \"{text}\", allowed are the first and the last step, as in 10..40, or one step"
        )),
    }
}

/// Reads `24,14`; the error says what is allowed.
fn angles(text: &str) -> Result<Angles, String> {
    let number = |text: &str, low: f32, high: f32| {
        let number = text.trim().parse::<f32>().ok();
        number.filter(|number| (low..=high).contains(number))
    };
    text.split_once(',')
        .and_then(|(azimuth, elevation)| {
            Some(Angles {
                azimuth: number(azimuth, -360.0, 360.0)?,
                elevation: number(elevation, 0.0, 90.0)?,
            })
        })
        .ok_or_else(|| {
            format!("found \"{text}\", allowed are an azimuth from -360 to 360 and an elevation from 0 to 90, in degrees, as in 24,14")
        })
}

/// Reads a number of stops; the error says what is allowed.
fn stops(text: &str) -> Result<f32, String> {
    let number = text.parse::<f32>().ok();
    number
        .filter(|number| (-STOPS..=STOPS).contains(number))
        .ok_or_else(|| format!("found \"{text}\", allowed is a number from -{STOPS} to {STOPS}"))
}

/// Reads an amount of detail; the error says what is allowed.
fn detail(text: &str) -> Result<f32, String> {
    let number = text.parse::<f32>().ok();
    number
        .filter(|number| (0.0..=1.0).contains(number))
        .ok_or_else(|| format!("found \"{text}\", allowed is a number from 0 to 1"))
}
