//! `thurible track CAPTURE`: the flow behind frames of smoke.

use super::options::{Options, Overwriting, longer};
use super::words::Words;
use crate::exit::{DONE, Failure};
use crate::progress::Clock;
use crate::track::{self, CaptureScene, Request};
use clap::Args;
use std::path::{Path, PathBuf};
use thurible_core::Named;
use thurible_core::flow::Minimiser;

/// Arguments of `track`.
#[derive(Args, Debug)]
pub struct TrackArguments {
    /// The frames: a capture file (TOML), an .npz or .npy whose first axis is time, a result folder, or a folder or pattern of .npy, .npz,
    /// .vdb or picture files.
    pub capture: PathBuf,
    /// How the flow is found: direct, admm or horn_schunck [default: direct].
    #[arg(long, value_name = "M", value_parser = Words(Minimiser::WORDS.to_vec()), hide_possible_values = true)]
    pub method: Option<String>,
    /// Weight of smoothness, as --set track.alpha=X.
    #[arg(long, value_name = "X")]
    pub alpha: Option<f64>,
    /// Weight of the flow's kinetic energy, as --set track.beta=X.
    #[arg(long, value_name = "X")]
    pub beta: Option<f64>,
    /// True velocities to compare with: an .npz with velocity_x, velocity_y (and velocity_z).
    #[arg(long, value_name = "FILE")]
    pub truth: Option<PathBuf>,
    /// What becomes of a result that is there.
    #[command(flatten)]
    pub overwriting: Overwriting,
    /// The common options.
    #[command(flatten)]
    pub options: Options,
    /// The result folder [default: the name of the capture with _track at its end].
    #[arg(short, long, value_name = "DIR")]
    pub output: Option<PathBuf>,
    /// Print the memory that tracking needs, to the byte, and do nothing.
    #[arg(long)]
    pub plan: bool,
}

/// Tracks a capture and writes its result folder; the answer is the exit code.
pub fn run(arguments: &TrackArguments) -> Result<u8, Failure> {
    let clock = Clock::start();
    let scene = CaptureScene::load(&arguments.capture, &changes(arguments)?)?;
    let planned = track::planned(&scene, &arguments.options.plan())?;
    if arguments.plan {
        track::print_plan(&scene, &planned, arguments.options.mode());
        return Ok(DONE);
    }
    let folder = arguments
        .output
        .clone()
        .unwrap_or_else(|| beside(&arguments.capture));
    arguments.overwriting.check(&folder)?;
    let request = Request {
        scene,
        folder,
        mode: arguments.options.mode(),
        clock,
    };
    track::run(&request, planned)
}

/// What the command line changes of a capture: the option, and `key=value`.
fn changes(arguments: &TrackArguments) -> Result<Vec<(String, String)>, Failure> {
    let set = arguments.options.set.iter();
    let mut all: Vec<(String, String)> = set.map(|set| (format!("--set {set}"), set.clone())).collect();
    let mut add = |option: &str, key: &str, value: Option<String>| {
        let value = value.into_iter();
        all.extend(value.map(|value| (format!("--{option} {value}"), format!("{key}={value}"))));
    };
    let number = |given: Option<f64>| given.map(|given| given.to_string());
    add("method", "track.method", arguments.method.clone());
    add("alpha", "track.alpha", number(arguments.alpha));
    add("beta", "track.beta", number(arguments.beta));
    if let Some(truth) = &arguments.truth {
        // Paths of a capture start at its folder, those of the command line do not.
        let absolute = std::path::absolute(truth).map_err(|error| {
            Failure::File(format!(
                "--truth {}: {error}; give the path of an .npz",
                truth.display()
            ))
        })?;
        add(
            "truth",
            "capture.truth",
            Some(absolute.to_string_lossy().into_owned()),
        );
    }
    Ok(all)
}

/// The result folder beside a capture.
fn beside(capture: &Path) -> PathBuf {
    // A folder's name has no extension: the frames of plume.v001 and plume.v002 are two captures.
    if capture.is_dir() {
        return longer(capture, "_track");
    }
    let stem = capture
        .file_stem()
        .map(|stem| stem.to_string_lossy().replace('*', ""));
    let stem = stem
        .filter(|stem| !stem.is_empty())
        .unwrap_or_else(|| "capture".into());
    capture.with_file_name(format!("{}_track", stem.trim_end_matches(['_', '-'])))
}
