//! `thurible resume DIR`: a solve that was not finished, on from the last state that was kept of it.

use super::options::{OnDevice, Running, Sharing, Watching};
use crate::checkpoint::{self, Every, Found, Solve};
use crate::destination::{self, place_of};
use crate::devices::Searching;
use crate::exit::Failure;
use crate::interrupt::Interrupt;
use crate::plan::PlanOptions;
use crate::problem::Precision;
use crate::progress::{Clock, Mode};
use crate::run::{Origin, Outputs, Request, RunOptions, share_of};
use crate::scene::Scene;
use crate::solves;
use clap::Args;
use std::path::{Path, PathBuf};
use thurible_core::exec::Ranks;
use thurible_core::{Method, Named, stable_fluids};

/// Arguments of `resume`.
#[derive(Args, Debug)]
pub struct ResumeArguments {
    /// The result folder of the solve, or the folder of its states.
    pub folder: PathBuf,
    /// What it takes of the machine: threads and ceiling may be others than before.
    #[command(flatten)]
    pub running: Running,
    /// Where the search goes on.
    #[command(flatten)]
    pub on: OnDevice,
    /// How ranks cut the box, whoever shared it before.
    #[command(flatten)]
    pub sharing: Sharing,
    /// How often the state is kept from now on: every=60s, every=20 iterations, or off.
    #[arg(long, value_name = "every=60s|N", value_parser = checkpoint::parse)]
    pub checkpoint: Option<Every>,
    /// Its page.
    #[command(flatten)]
    pub watching: Watching,
    /// Where the result goes [default: where it was to go].
    #[arg(short, long, value_name = "DIR")]
    pub output: Option<PathBuf>,
    /// Write over another result that the folder of -o holds.
    #[arg(long)]
    pub force: bool,
}

/// Goes on with a solve; the answer is the exit code.
pub fn run(arguments: &ResumeArguments) -> Result<u8, Failure> {
    let clock = Clock::start();
    let running = &arguments.running;
    let ranks = running.ranks;
    let on = On {
        ranks,
        sharing: arguments.sharing,
        threads: running.threads,
        memory_limit: running.memory_limit,
        device: arguments.on.open(ranks.is_some())?,
        mode: running.mode(),
        checkpoint: arguments.checkpoint.unwrap_or_default(),
        watch: arguments.watching.watch,
        output: arguments.output.as_deref(),
        force: arguments.force,
        interrupt: None,
        clock,
    };
    match ranks.filter(|ranks| ranks.rank() > 0) {
        // The state is the first rank's to hold and to read.
        Some(ranks) => follow(&Solve::heard(ranks)?, on),
        None => go_on(checkpoint::open(&arguments.folder)?, on),
    }
}

/// How a solve goes on.
pub(super) struct On<'a> {
    /// Threads and ceiling, which may be others than before.
    pub threads: Option<usize>,
    pub memory_limit: Option<usize>,
    /// The device that the search goes on, where that is no processor.
    pub device: Option<&'static dyn Searching>,
    /// How progress is shown.
    pub mode: Mode,
    /// How often the state is kept.
    pub checkpoint: Every,
    /// The port of its page, if there is one.
    pub watch: Option<u16>,
    /// Where the result goes, if not where it was to go.
    pub output: Option<&'a Path>,
    /// Whether another result that is there may go.
    pub force: bool,
    /// Listens for Ctrl-C; if there is none, the solve listens itself.
    pub interrupt: Option<Interrupt>,
    /// A clock that runs.
    pub clock: Clock,
    /// The programs that share it from now on, whoever shared it before.
    pub ranks: Option<&'static dyn Ranks>,
    /// How they cut the box.
    pub sharing: Sharing,
}

/// Goes on from what was found.
pub(super) fn go_on(found: Found, on: On<'_>) -> Result<u8, Failure> {
    let damaged = || checkpoint::damaged(&found.slot);
    // Before the others are told, who draw nothing and need none of these files.
    found.solve.check_inputs()?;
    if let Some(ranks) = on.ranks {
        found.solve.tell(ranks)?;
    }
    let (options, request) = asked(&found.solve, &damaged, on)?;
    let request = Request {
        found: Some(found),
        ..request
    };
    Ok(solves::solve(&options, request)?.exit_code())
}

/// Follows the first rank, which goes on with `solve`.
fn follow(solve: &Solve, on: On<'_>) -> Result<u8, Failure> {
    let damaged = || Failure::File("the state is damaged, or was kept by another version of thurible".into());
    let (options, request) = asked(solve, &damaged, on)?;
    options.follow(request)
}

/// How `solve` goes on, and what is asked for.
fn asked(solve: &Solve, damaged: &dyn Fn() -> Failure, on: On<'_>) -> Result<(RunOptions, Request), Failure> {
    let precision = [Precision::F32, Precision::F64];
    let precision = precision
        .into_iter()
        .find(|precision| precision.name() == solve.options.precision);
    let options = on.sharing.of(RunOptions {
        plan: PlanOptions {
            precision: precision.ok_or_else(damaged)?,
            threads: on.threads,
            limit: on.memory_limit,
            began_under: Some(solve.options.ceiling),
            share: on.ranks.map(share_of),
            blocks: None,
            on_this_machine: on.ranks.map_or(1, Ranks::on_this_machine),
        },
        mode: on.mode,
        ranks: on.ranks,
        device: on.device,
        outputs: Outputs {
            arrays: true,
            images: solve.options.images,
        },
    })?;
    let scene = scene_of(solve, damaged)?;
    let own = solve.destination();
    let folder = on.output.unwrap_or(own);
    // What its own folder held, it was allowed to write over when it began; what came there since it was not.
    let is_own = place_of(folder) == place_of(own) && solve.may_replace(folder);
    let origin = |earlier: &checkpoint::Earlier, option| {
        let (_, folder, step) = earlier.clone()?;
        Some(Origin { option, folder, step })
    };
    let request = Request {
        from: origin(&solve.options.from, "--from"),
        reference: origin(&solve.options.reference, "--reference"),
        free: solve.options.free.is_some(),
        earlier: destination::Earlier::by(is_own || on.force),
        checkpoint: on.checkpoint,
        watch: on.watch,
        interrupt: on.interrupt,
        ..Request::new(scene, folder.to_owned(), on.clock)
    };
    Ok((options, request))
}

fn scene_of(solve: &Solve, damaged: &dyn Fn() -> Failure) -> Result<Scene, Failure> {
    let document = solve.document()?;
    let Some(method) = &solve.options.free else {
        return Scene::of(document);
    };
    let scene = Scene::free_of(document)?;
    if method == stable_fluids::NAME {
        return Ok(scene.flow_by(Method::Simulate, true));
    }
    let method = Method::from_name(method).map_err(|_| damaged())?;
    Ok(scene.flow_by(method, false))
}
