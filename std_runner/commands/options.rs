//! Options that several commands share.

use super::words::Words;
use crate::blocks::{self, Blocks};
use crate::checkpoint::{self, Every};
use crate::destination::{Earlier, put_in_order};
use crate::devices::{self, Searching};
use crate::exit::Failure;
use crate::plan::PlanOptions;
use crate::problem::Precision;
use crate::progress::Mode;
use crate::run::{Outputs, Request, RunOptions, share_of};
use crate::scene::steering;
use crate::{bytes, threads};
use clap::Args;
use core::ops::Deref;
use std::path::{Path, PathBuf};
use std::time::{SystemTime, UNIX_EPOCH};
use thurible_core::exec::Ranks;
use thurible_core::{Named, stable_fluids};

/// What a command takes of the machine, and how it tells its progress.
#[derive(Args, Clone, Debug)]
pub struct Running {
    /// Threads [default: as many as the machine offers].
    #[arg(long, value_name = "N", value_parser = threads::parse)]
    pub threads: Option<usize>,
    /// Ceiling for the one block of memory, as in 1GiB [default: the machine's memory].
    #[arg(long, value_name = "SIZE", value_parser = bytes::parse)]
    pub memory_limit: Option<usize>,
    /// Print nothing but errors.
    #[arg(long, conflicts_with = "json")]
    pub quiet: bool,
    /// Print JSON lines.
    #[arg(long)]
    pub json: bool,
    /// The programs that share the scene, where there are several.
    #[arg(skip)]
    pub ranks: Option<&'static dyn Ranks>,
}

impl Running {
    /// How progress is shown: a bar, JSON lines or nothing.
    pub fn mode(&self) -> Mode {
        match (self.quiet, self.json) {
            (true, _) => Mode::Quiet,
            (_, true) => Mode::Json,
            _ => Mode::Human,
        }
    }
}

/// What a command takes of the machine, and in which precision it computes.
#[derive(Args, Clone, Debug)]
pub struct Resources {
    /// Threads and memory.
    #[command(flatten)]
    pub running: Running,
    /// Precision of all fields [default: f32; of `simulate` and `guide`, where forces may be almost zero: f64; where a result is taken further: its own].
    #[arg(long, value_enum)]
    pub precision: Option<Precision>,
}

impl Deref for Resources {
    type Target = Running;

    fn deref(&self) -> &Running {
        &self.running
    }
}

/// What becomes of results and states that are there, and how often the state is kept.
#[derive(Args, Clone, Debug)]
pub struct Keeping {
    /// Write over a result that the folder holds, and throw away the state of a solve into it that was not finished.
    #[arg(long)]
    pub force: bool,
    /// Put the date and the time after the name of the result folder, so that no result is in the way.
    #[arg(long)]
    pub name_by_time: bool,
    /// How often the state is kept, for `thurible resume DIR`: every=60s, every=20 iterations, or off [default: once a minute where it takes over five minutes].
    #[arg(long, value_name = "every=60s|N", value_parser = checkpoint::parse)]
    pub checkpoint: Option<Every>,
    /// Its page.
    #[command(flatten)]
    pub watching: Watching,
}

/// What becomes of a result that is there, of commands that keep no state.
#[derive(Args, Clone, Debug)]
pub struct Overwriting {
    /// Write over a result that the folder holds.
    #[arg(long)]
    pub force: bool,
}

impl Overwriting {
    /// Refuses a folder whose result would be lost.
    pub(crate) fn check(&self, folder: &Path) -> Result<(), Failure> {
        self.earlier().check(folder, "-o DIR")
    }

    /// What becomes of it.
    pub(crate) fn earlier(&self) -> Earlier {
        Earlier::by(self.force)
    }
}

/// Where a search goes.
#[derive(Args, Clone, Debug)]
pub struct OnDevice {
    /// The device that the search of `direct` goes on: cpu, gpu for the first graphics card, or a part of a name that `thurible devices` lists.
    #[arg(long, value_name = "NAME", default_value = "cpu")]
    pub device: String,
    /// Ceiling for the device's memory, as in 8GiB [default: none]. What does not fit is streamed from this machine's, step by step.
    #[arg(long, value_name = "SIZE", value_parser = bytes::parse)]
    pub device_memory: Option<usize>,
}

impl OnDevice {
    /// The device, opened; none for `cpu`, which is all that ranks have.
    pub(crate) fn open(&self, is_shared: bool) -> Result<Option<&'static dyn Searching>, Failure> {
        let is_none = self.device.eq_ignore_ascii_case("cpu");
        if is_none && self.device_memory.is_some() {
            return Err(Failure::Input(
                "--device-memory is that of a device; name one by --device, or leave it out".into(),
            ));
        }
        if is_shared && !is_none {
            return Err(Failure::Input(format!(
                "--device {}: ranks search on processors alone; leave it out, or run `thurible` on one machine",
                self.device
            )));
        }
        devices::open(&self.device, self.device_memory)
    }
}

/// The page of a solve that runs.
#[derive(Args, Clone, Debug)]
pub struct Watching {
    /// Show frames and curves as they come, and the time that is left, on a page of this machine whose address is printed; a button on it stops the solve [default: any free port].
    #[arg(long, value_name = "PORT", num_args = 0..=1, require_equals = true, default_missing_value = "0", conflicts_with = "quiet")]
    pub watch: Option<u16>,
}

impl Keeping {
    /// `request` as these options have it; states in its way are refused, or thrown away when nothing else stands against it.
    pub(crate) fn keep(&self, mut request: Request) -> Result<Request, Failure> {
        if self.name_by_time {
            request.folder = by_time(&request.folder, SystemTime::now());
        }
        put_in_order(&request.folder);
        checkpoint::refuse_states(&request.folder, self.force)?;
        Ok(Request {
            earlier: Earlier::by(self.force),
            forced: self.force,
            checkpoint: self.checkpoint.unwrap_or_default(),
            watch: self.watching.watch,
            ..request
        })
    }
}

/// `folder` with `end` after its name, which `.` and `..` have too.
pub(super) fn longer(folder: &Path, end: &str) -> PathBuf {
    let resolved = if folder.file_name().is_none() {
        folder.canonicalize().ok()
    } else {
        None
    };
    let folder = resolved.as_deref().unwrap_or(folder);
    let mut name = folder.file_name().unwrap_or_default().to_owned();
    name.push(end);
    folder.with_file_name(name)
}

/// `folder` with the time in UTC after its name, as in `letter_2026-11-26_213045`.
fn by_time(folder: &Path, now: SystemTime) -> PathBuf {
    let seconds = now.duration_since(UNIX_EPOCH).map_or(0, |since| since.as_secs());
    let (days, second) = (seconds / 86_400, seconds % 86_400);
    // Days since 1 March of the year 0, in eras of 400 years: Howard Hinnant, "chrono-compatible low-level date algorithms", civil_from_days.
    let days = days + 719_468;
    let (era, day) = (days / 146_097, days % 146_097);
    let year = (day - day / 1460 + day / 36_524 - day / 146_096) / 365;
    let day = day - (365 * year + year / 4 - year / 100);
    let month = (5 * day + 2) / 153;
    let day = day - (153 * month + 2) / 5 + 1;
    let month = if month < 10 { month + 3 } else { month - 9 };
    let year = year + 400 * era + u64::from(month <= 2);
    let [hour, minute, second] = [second / 3600, second / 60 % 60, second % 60];
    let mut name = folder.file_name().unwrap_or("out".as_ref()).to_owned();
    name.push(format!(
        "_{year:04}-{month:02}-{day:02}_{hour:02}{minute:02}{second:02}"
    ));
    folder.with_file_name(name)
}

/// Options of every command that plans or solves.
#[derive(Args, Clone, Debug)]
pub struct Options {
    /// Those of the machine.
    #[command(flatten)]
    pub resources: Resources,
    /// Overrides of single keys of the scene.
    #[arg(
        long,
        value_name = "KEY=VALUE",
        help = "Override any key of the scene, as in --set time.steps=20 or --set 'keyframe[0].text=\"G\"'"
    )]
    pub set: Vec<String>,
}

impl Options {
    /// The options of the plan.
    pub fn plan(&self) -> PlanOptions {
        PlanOptions {
            precision: self.resources.precision.unwrap_or(Precision::F32),
            threads: self.resources.threads,
            limit: self.resources.memory_limit,
            began_under: None,
            share: self.resources.ranks.map(share_of),
            blocks: None,
            on_this_machine: self.resources.ranks.map_or(1, Ranks::on_this_machine),
        }
    }

    /// Those of the plan of a flow alone: without control the forces are the residuals of the steps, which single precision would not resolve.
    pub fn plan_of_a_flow(&self) -> PlanOptions {
        PlanOptions {
            precision: self.resources.precision.unwrap_or(Precision::F64),
            ..self.plan()
        }
    }

    /// How progress is shown.
    pub fn mode(&self) -> Mode {
        self.resources.mode()
    }

    /// The options of a solve that writes `outputs`.
    pub(crate) fn run(&self, outputs: Outputs) -> RunOptions {
        RunOptions {
            plan: self.plan(),
            mode: self.mode(),
            outputs,
            ranks: self.resources.ranks,
            device: None,
        }
    }
}

/// How ranks cut the box that they share.
#[derive(Args, Clone, Copy, Debug, Default)]
pub struct Sharing {
    /// Of ranks that share a scene: a block of the box for each, as in 2x4, two of them side by side along y and four along z [default: slabs along z for up to 8 ranks with 8 planes or more each, else the blocks with the fewest copies].
    #[arg(long, value_name = "YxZ", value_parser = blocks::parse)]
    pub blocks: Option<Blocks>,
}

impl Sharing {
    /// The options of a solve that ranks share so, if there are any.
    ///
    /// # Errors
    /// There are not as many blocks as ranks.
    pub(crate) fn of(self, mut options: RunOptions) -> Result<RunOptions, Failure> {
        if let Some(blocks) = self.blocks {
            blocks.check(options.ranks.map(Ranks::count))?;
        }
        options.plan.blocks = self.blocks;
        Ok(options)
    }
}

/// Arguments of `solve` and `plan`.
#[derive(Args, Debug)]
pub struct SceneArguments {
    /// The scene file (TOML).
    pub scene: PathBuf,
    /// The method, by its word.
    #[arg(long, value_name = "M", help = format!("The method, one of: {}", methods().join(", ")))]
    #[arg(value_parser = Words(methods()), hide_possible_values = true)]
    pub method: Option<String>,
    /// The common options.
    #[command(flatten)]
    pub options: Options,
}

/// The methods of `compare` and `paper`.
#[derive(Args, Debug)]
pub struct MethodList {
    /// The methods, in the order in which they run.
    #[arg(
        long,
        value_name = "M,M",
        value_delimiter = ',',
        default_value = "direct,admm",
        value_parser = Words(methods()),
        hide_possible_values = true
    )]
    pub methods: Vec<String>,
}

/// The words of all methods.
fn methods() -> Vec<&'static str> {
    let steering = steering().into_iter().map(Named::name);
    steering.chain([stable_fluids::NAME]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::time::Duration;

    #[test]
    fn folders_are_named_by_the_time() {
        for (seconds, name) in [
            (0, "x_1970-01-01_000000"),
            (951_782_399, "x_2000-02-28_235959"),
            (951_825_600, "x_2000-02-29_120000"),
            (1_795_728_645, "x_2026-11-26_213045"),
            (4_107_542_400, "x_2100-03-01_000000"),
        ] {
            let now = UNIX_EPOCH + Duration::from_secs(seconds);
            assert_eq!(by_time(Path::new("out/x"), now), Path::new("out").join(name));
        }
    }
}
