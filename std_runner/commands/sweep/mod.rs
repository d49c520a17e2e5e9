//! `thurible sweep SCENE --vary key=a,b,c`: a scene with every value of some keys, on one page.

mod page;
mod runs;
mod there;

use super::options::{Options, Running, Sharing, longer};
use super::resume;
use crate::checkpoint::{self, Every};
use crate::compare::publish;
use crate::console;
use crate::destination::Earlier;
use crate::exit::{DONE, Failure, worse};
use crate::interrupt::Interrupt;
use crate::progress::{Clock, Display, Mode};
use crate::run::{Outputs, Request};
use crate::scene::Scene;
use crate::solves;
use clap::Args;
use page::{document, facts, table};
use runs::{Run, runs};
use serde_json::{Value, json};
use std::path::PathBuf;
use there::{is_of, report_in};

/// The name of the page and of its facts.
const STEM: &str = "sweep";

/// Arguments of `sweep`.
#[derive(Args, Debug)]
pub struct SweepArguments {
    /// The scene file (TOML).
    pub scene: PathBuf,
    /// A key and its values, as in control.force_weight=1e2,1e3; of several keys every combination is solved.
    #[arg(long, value_name = "KEY=A,B,C", required = true)]
    pub vary: Vec<String>,
    /// Solve this run alone, from 1, and write no page: for many machines at once.
    #[arg(long, value_name = "K")]
    pub only: Option<usize>,
    /// Print what would be solved, and solve nothing.
    #[arg(long)]
    pub list: bool,
    /// Solve again what is there already.
    #[arg(long)]
    pub force: bool,
    /// The common options.
    #[command(flatten)]
    pub options: Options,
    /// How often the states are kept: every=60s, every=20 iterations, or off.
    #[arg(long, value_name = "every=60s|N", value_parser = checkpoint::parse)]
    pub checkpoint: Option<Every>,
    /// Where the page and a result folder for each run go [default: `output.folder` of the scene with _sweep after it].
    #[arg(short, long, value_name = "DIR")]
    pub output: Option<PathBuf>,
}

/// Solves all of them, or one, and writes the page; the answer is the exit code.
pub fn run(arguments: &SweepArguments) -> Result<u8, Failure> {
    let scene = Scene::load(&arguments.scene, &arguments.options.set, None)?;
    let output = arguments.output.clone();
    let folder = output.unwrap_or_else(|| longer(&scene.output.folder, "_sweep"));
    let runs = runs(&arguments.vary, &folder)?;
    // Nothing is refused after hours of solving.
    for run in &runs {
        solves::check(&arguments.scene_of(run)?, &arguments.options.plan())?;
    }
    if arguments.list {
        for (index, run) in runs.iter().enumerate() {
            if arguments.options.mode() == Mode::Json {
                let fields = json!({ "number": index + 1, "set": run.set });
                Display::new(Mode::Json, 0).event("run", fields);
            } else {
                console::print(&format!("{:>4}  {}", index + 1, run.set.join(" ")));
            }
        }
        return Ok(DONE);
    }
    if let Some(number) = arguments.only {
        let run = number.checked_sub(1).and_then(|index| runs.get(index));
        let run = run.ok_or_else(|| {
            Failure::Input(format!(
                "--only {number}: there are runs from 1 to {}; --list shows them",
                runs.len()
            ))
        })?;
        // The folder is marked as one of ours. Of jobs that begin together the first one does it.
        if let Err(failure) = publish::prepare(&folder, STEM, Earlier::Replaced)
            && !publish::is_marked(&folder, STEM)
        {
            return Err(failure);
        }
        return arguments.solve(run, &Interrupt::listen()?);
    }
    // Results that are there are left as they are, and the page tells of them anew.
    let mut page = publish::prepare(&folder, STEM, Earlier::Replaced)?;
    let interrupt = Interrupt::listen()?;
    let mut worst = DONE;
    let mut failed = vec![None; runs.len()];
    for (run, why) in runs.iter().zip(&mut failed) {
        if interrupt.asked() {
            break;
        }
        match arguments.solve(run, &interrupt) {
            Ok(code) => worst = worse(worst, code),
            // The others may well be solved, and the page tells of them.
            Err(failure) => {
                console::error(&format!("thurible: {}: {failure}", run.set.join(" ")));
                worst = worse(worst, failure.code());
                *why = Some(failure.to_string());
            }
        }
    }
    let there = |(run, why): (&Run, &Option<String>)| match why {
        None => arguments.report_of(run),
        Some(_) => None,
    };
    let reports: Vec<Option<Value>> = runs.iter().zip(&failed).map(there).collect();
    let outcomes = reports.iter().zip(&failed);
    let rows = runs.iter().zip(outcomes);
    let rows: Vec<Value> = rows
        .map(|(run, (report, why))| facts(run, report.as_ref(), why.as_ref()))
        .collect();
    let table = table(&runs, &rows);
    let facts = json!({ "format": 1, "scene": arguments.scene.display().to_string(), "rows": &rows });
    let name = arguments
        .scene
        .file_stem()
        .unwrap_or_default()
        .to_string_lossy()
        .into_owned();
    publish::write(
        &mut page,
        STEM,
        &document((&name, &arguments.vary), &runs, (table.clone(), &rows), &reports),
        &facts,
    )?;
    publish::announce(arguments.options.mode(), &page, STEM, &table.plain(), facts);
    Ok(publish::code(&page, &interrupt, worst))
}

impl SweepArguments {
    fn scene_of(&self, run: &Run) -> Result<Scene, Failure> {
        let set: Vec<String> = self.options.set.iter().chain(&run.set).cloned().collect();
        Scene::load(&self.scene, &set, None)
    }

    /// The report of a run's whole result, if that is of this very scene.
    fn report_of(&self, run: &Run) -> Option<Value> {
        let scene = self.scene_of(run).ok()?;
        let precision = self.options.plan().precision.name();
        report_in(&run.folder).filter(|report| is_of(report, &scene, precision))
    }

    /// Solves a run, unless its result is there; one that was not finished goes on.
    fn solve(&self, run: &Run, interrupt: &Interrupt) -> Result<u8, Failure> {
        let clock = Clock::start();
        let Running {
            threads,
            memory_limit,
            ..
        } = self.options.resources.running;
        if self.options.mode() == Mode::Human {
            console::print(&format!("{}:", run.set.join(" ")));
        }
        let scene = self.scene_of(run)?;
        let options = self.options.run(Outputs {
            arrays: true,
            images: scene.output.frames,
        });
        let precision = options.plan.precision.name();
        let another = |what: &str| {
            let shown = run.folder.display();
            Failure::File(format!(
                "{shown} holds {what} of another scene, of other settings or of another precision: choose another folder with -o DIR, or solve all again with --force"
            ))
        };
        if let (false, Some(report)) = (self.force, report_in(&run.folder)) {
            return if is_of(&report, &scene, precision) {
                Ok(DONE)
            } else {
                Err(another("the result"))
            };
        }
        if !self.force && checkpoint::is_there(&run.folder) {
            let found = checkpoint::open(&run.folder)?;
            if !found.solve.is_of(&scene.document, precision) {
                return Err(another("the state"));
            }
            let on = resume::On {
                sharing: Sharing::default(),
                device: None,
                threads,
                memory_limit,
                mode: self.options.mode(),
                checkpoint: self.checkpoint.unwrap_or_default(),
                watch: None,
                // A sweep may have been moved since.
                output: Some(&run.folder),
                force: true,
                interrupt: Some(interrupt.clone()),
                clock,
                ranks: None,
            };
            return resume::go_on(found, on);
        }
        checkpoint::refuse_states(&run.folder, self.force)?;
        let request = Request {
            interrupt: Some(interrupt.clone()),
            forced: self.force,
            checkpoint: self.checkpoint.unwrap_or_default(),
            ..Request::new(scene, run.folder.clone(), clock)
        };
        Ok(solves::solve(&options, request)?.exit_code())
    }
}
