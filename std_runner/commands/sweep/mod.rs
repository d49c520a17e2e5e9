//! `thurible sweep SCENE --vary key=a,b,c`: a scene with every value of some keys, on one page.

use super::options::{Options, Running};
use super::resume;
use crate::checkpoint::{self, Every};
use crate::compare::publish;
use crate::console;
use crate::exit::{DONE, Failure};
use crate::interrupt::Interrupt;
use crate::output::frame;
use crate::plan;
use crate::progress::{Clock, Mode};
use crate::report::{Block, Document, Shot, Table, bytes, number, seconds};
use crate::run::{Outputs, Request};
use crate::scene::Scene;
use clap::Args;
use serde_json::{Value, json};
use std::fs;
use std::path::{Path, PathBuf};

/// The name of the page and of its facts.
const STEM: &str = "sweep";
/// Most runs.
const MOST: usize = 1000;

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

/// One of the runs.
struct Run {
    /// What is set, `key=value` each.
    set: Vec<String>,
    /// Its folder.
    folder: PathBuf,
}

/// Solves all of them, or one, and writes the page; the answer is the exit code.
pub fn run(arguments: &SweepArguments) -> Result<u8, Failure> {
    let combinations = combinations(&arguments.vary)?;
    let scene = Scene::load(&arguments.scene, &arguments.options.set, None)?;
    let folder = arguments.output.clone().unwrap_or_else(|| {
        let mut name = scene.output.folder.file_name().unwrap_or_default().to_owned();
        name.push("_sweep");
        scene.output.folder.with_file_name(name)
    });
    let runs: Vec<Run> = combinations
        .into_iter()
        .enumerate()
        .map(|(index, set)| Run {
            folder: folder.join(format!("{:03}_{}", index + 1, in_a_name(&set.join("_")))),
            set,
        })
        .collect();
    // Nothing is refused after hours of solving.
    for run in &runs {
        plan::choose(&arguments.scene_of(run)?, &arguments.options.plan())?;
    }
    if arguments.list {
        for (index, run) in runs.iter().enumerate() {
            console::print(&format!("{:>4}  {}", index + 1, run.set.join(" ")));
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
        if let Err(failure) = publish::prepare(&folder, STEM)
            && !publish::is_marked(&folder, STEM)
        {
            return Err(failure);
        }
        return arguments.solve(run, &Interrupt::listen()?);
    }
    let mut page = publish::prepare(&folder, STEM)?;
    let interrupt = Interrupt::listen()?;
    let mut worst = DONE;
    for run in &runs {
        if interrupt.asked() {
            break;
        }
        match arguments.solve(run, &interrupt) {
            Ok(code) => worst = worst.max(code),
            Err(Failure::NotFinite(why)) => {
                console::error(&format!("thurible: {}: {why}", run.set.join(" ")));
                worst = worst.max(crate::exit::NOT_FINITE);
            }
            Err(other) => return Err(other),
        }
    }
    let table = table(&runs);
    let facts = json!({ "format": 1, "scene": arguments.scene.display().to_string(), "rows": runs.iter().map(facts).collect::<Vec<_>>() });
    let name = arguments
        .scene
        .file_stem()
        .unwrap_or_default()
        .to_string_lossy()
        .into_owned();
    publish::write(
        &mut page,
        STEM,
        &document(&name, &arguments.vary, &runs, table.clone()),
        &facts,
    )?;
    publish::announce(arguments.options.mode(), &page, STEM, &table.markdown(), facts);
    Ok(publish::code(&page, &interrupt, worst))
}

impl SweepArguments {
    fn scene_of(&self, run: &Run) -> Result<Scene, Failure> {
        let set: Vec<String> = self.options.set.iter().chain(&run.set).cloned().collect();
        Scene::load(&self.scene, &set, None)
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
        if !self.force && is_solved(&run.folder, &scene) {
            return Ok(DONE);
        }
        if !self.force && checkpoint::is_there(&run.folder) {
            let on = resume::On {
                threads,
                memory_limit,
                mode: self.options.mode(),
                checkpoint: self.checkpoint.unwrap_or_default(),
                watch: None,
                output: None,
                interrupt: Some(interrupt.clone()),
                clock,
            };
            return resume::go_on(checkpoint::open(&run.folder)?, on);
        }
        checkpoint::throw_away(&run.folder, self.force)?;
        let options = self.options.run(Outputs {
            arrays: true,
            images: scene.output.frames,
        });
        let request = Request {
            interrupt: Some(interrupt.clone()),
            overwrites: self.force,
            checkpoint: self.checkpoint.unwrap_or_default(),
            ..Request::new(scene, run.folder.clone(), clock)
        };
        Ok(options.solve(request)?.exit_code())
    }
}

/// Every combination of the values of all keys, that of the last key fastest.
fn combinations(vary: &[String]) -> Result<Vec<Vec<String>>, Failure> {
    let mut all = vec![Vec::new()];
    for one in vary {
        let (key, values) = one.split_once('=').ok_or_else(|| {
            Failure::Input(format!(
                "--vary {one}: there is no `=` in it; write key.path=a,b,c, as in --vary control.force_weight=1e2,1e3"
            ))
        })?;
        let values = split(values);
        if all.len().saturating_mul(values.len()) > MOST {
            return Err(Failure::Input(format!(
                "--vary {one}: there are more than {MOST} combinations; take fewer values"
            )));
        }
        let with = |set: &Vec<String>, value: &String| {
            let mut set = set.clone();
            set.push(format!("{}={}", key.trim(), value.trim()));
            set
        };
        all = all
            .iter()
            .flat_map(|set| values.iter().map(move |value| with(set, value)))
            .collect();
    }
    Ok(all)
}

/// Values between commas, those within brackets, braces and quotation marks left together.
fn split(values: &str) -> Vec<String> {
    let (mut parts, mut depth, mut quoted) = (vec![String::new()], 0, false);
    for letter in values.chars() {
        match letter {
            '"' => quoted = !quoted,
            '[' | '{' if !quoted => depth += 1,
            ']' | '}' if !quoted => depth -= 1,
            ',' if !quoted && depth == 0 => {
                parts.push(String::new());
                continue;
            }
            _ => {}
        }
        if let Some(part) = parts.last_mut() {
            part.push(letter);
        }
    }
    parts
}

/// A text as a part of a file's name.
fn in_a_name(text: &str) -> String {
    let plain = |letter: char| {
        if letter.is_ascii_alphanumeric() || "-+.=_".contains(letter) {
            letter
        } else {
            '_'
        }
    };
    text.chars().map(plain).take(80).collect()
}

/// The report of a run, if it has a whole result.
fn result(folder: &Path) -> Option<Value> {
    let report = fs::read(folder.join("report.json")).ok()?;
    let report: Value = serde_json::from_slice(&report).ok()?;
    let is_whole = report["status"].is_string() && report["status"] != "cancelled";
    is_whole.then_some(report)
}

/// Whether a folder holds the result of this very scene, with all that was set.
fn is_solved(folder: &Path, scene: &Scene) -> bool {
    result(folder).is_some_and(|report| {
        let set: Vec<&str> = scene.document.assignments().collect();
        report["scene"] == scene.document.text() && report["overrides"] == json!(set)
    })
}

/// What the page says of a run.
fn facts(run: &Run) -> Value {
    let report = result(&run.folder).unwrap_or_default();
    let errors = report["keyframes"].as_array().into_iter().flatten();
    let worst = errors
        .filter_map(|keyframe| keyframe["relative_l2"].as_f64())
        .fold(0.0, f64::max);
    json!({
        "set": run.set,
        "folder": run.folder.file_name().unwrap_or_default().to_string_lossy(),
        "status": report["status"],
        "iterations": report["history"].as_array().map(Vec::len),
        "seconds": report["seconds"]["total"],
        "objective": report["objective"],
        "keyframe_error": worst,
        "planned_bytes": report["memory"]["planned_bytes"],
    })
}

fn table(runs: &[Run]) -> Table {
    let row = |run: &Run| {
        let facts = facts(run);
        let real = |value: &Value| value.as_f64().map_or_else(|| "\u{2013}".into(), number);
        vec![
            run.set.join(" "),
            facts["status"]
                .as_str()
                .unwrap_or("not there yet")
                .replace('_', " "),
            facts["iterations"]
                .as_u64()
                .map_or_else(|| "\u{2013}".into(), |count| count.to_string()),
            facts["seconds"]
                .as_f64()
                .map_or_else(|| "\u{2013}".into(), seconds),
            real(&facts["objective"]["total"]),
            real(&facts["objective"]["data"]),
            real(&facts["objective"]["force"]),
            format!("{:.1} %", 100.0 * facts["keyframe_error"].as_f64().unwrap_or(0.0)),
            facts["planned_bytes"].as_u64().map_or_else(
                || "\u{2013}".into(),
                |count| bytes(usize::try_from(count).unwrap_or(usize::MAX)),
            ),
        ]
    };
    let head = vec![
        "run",
        "ended",
        "iterations",
        "time",
        "objective",
        "keyframes",
        "force",
        "worst keyframe",
        "memory",
    ];
    Table {
        names: 1,
        ours: head.len(),
        head,
        rows: runs.iter().map(row).collect(),
    }
}

fn document(name: &str, vary: &[String], runs: &[Run], table: Table) -> Document {
    let last = |run: &Run| {
        let steps = result(&run.folder)?["steps"].as_u64()?;
        let png = fs::read(run.folder.join(frame(usize::try_from(steps).ok()?))).ok()?;
        Some(Shot {
            caption: run.set.join(" "),
            png,
        })
    };
    let mut blocks = vec![Block::Table(table)];
    let shots: Vec<Shot> = runs.iter().filter_map(last).collect();
    if !shots.is_empty() {
        blocks.push(Block::Heading("The last step".into()));
        blocks.push(Block::Pictures(shots));
    }
    Document {
        title: format!("{name}, varied"),
        lead: format!(
            "The same scene with every combination of {}. Each run has a folder of its own with all that a solve writes.",
            vary.join(" and ")
        ),
        blocks,
        pictures: true,
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    #[test]
    fn all_combinations_are_there_once() {
        let vary = ["a.b=1,2".to_owned(), "c=\"x,y\",[1, 2],z".into()];
        let all = combinations(&vary).unwrap();
        assert_eq!(all.len(), 6);
        assert_eq!(all[1], ["a.b=1", "c=[1, 2]"]);
        assert_eq!(all[3], ["a.b=2", "c=\"x,y\""]);
        assert!(combinations(&["a".into()]).is_err());
        assert_eq!(in_a_name("a.b=[1, 2]/\""), "a.b=_1__2___");
    }
}
