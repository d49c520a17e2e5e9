//! `thurible compare SCENE`: the same scene by several methods, on one page.

mod contest;
mod figures;
mod page;

pub use figures::{Figures, NEAR};

pub(crate) use contest::{Contest, entries};
pub(crate) use page::{COLUMNS, MEMORY, by_seconds, cells, in_brief, last_keyframe, listed, measured, strip};

use crate::cli::CompareArguments;
use crate::console;
use crate::destination::Destination;
use crate::exit::{DONE, Failure, INTERRUPTED, NOT_FINITE};
use crate::interrupt::Interrupt;
use crate::output::{OutputError, create_folder, write_bytes};
use crate::progress::{Display, Mode};
use crate::scene::{Document, Scene};
use crate::solve::{Order, Parts};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

/// The name of the page and of its facts.
const STEM: &str = "compare";

/// Runs `compare`.
pub fn run(arguments: &CompareArguments) -> Result<u8, Failure> {
    let (options, methods) = (&arguments.options, &arguments.contenders.methods);
    let mut document = Document::read(&arguments.scene)?;
    for assignment in &options.set {
        document.set(assignment)?;
    }
    let scene = Scene::of(document.clone())?;
    let order = Order {
        wishes: options.wishes(),
        mode: options.mode(),
        parts: Parts {
            arrays: true,
            images: scene.output.frames,
        },
    };
    let entries = entries(&document, methods, &order)?;
    let folder = arguments
        .output
        .clone()
        .unwrap_or_else(|| beside(&scene.output.folder));
    prepare(&folder, STEM)?;
    check_below(&folder, methods)?;
    let interrupt = Interrupt::listen()?;
    let contest = Contest::hold(entries, methods, &order, &folder, &interrupt)?;
    let name = arguments
        .scene
        .file_stem()
        .map_or_else(|| "scene".into(), |stem| stem.to_string_lossy());
    let facts = json!({ "format": 1, "scene": name, "best": contest.best(), "rows": contest.figures(), "failed": failed(&contest) });
    write(&folder, STEM, &page::page(&name, &contest), &facts)?;
    tell(&order, &folder, STEM, &page::summary(&contest), facts);
    Ok(if interrupt.asked() {
        INTERRUPTED
    } else {
        code_of(&contest)
    })
}

/// The folder of a comparison beside that of a solve.
fn beside(folder: &Path) -> PathBuf {
    let mut name = folder.file_name().unwrap_or_default().to_owned();
    name.push("_compare");
    folder.with_file_name(name)
}

/// Refuses a folder that holds something else, and marks it as one of ours before anything is solved.
pub(crate) fn prepare(folder: &Path, stem: &str) -> Result<(), Failure> {
    let mark = format!("{stem}.json");
    Destination::check_for(folder, &mark)?;
    let cannot = |error: OutputError| Failure::File(error.to_string());
    create_folder(folder).map_err(cannot)?;
    let path = folder.join(mark);
    if path.exists() {
        Ok(())
    } else {
        write_bytes(&path, json!({ "format": 1 }).to_string().as_bytes()).map_err(cannot)
    }
}

/// Refuses a folder for a method below `folder` that holds something else.
pub(crate) fn check_below(folder: &Path, methods: &[String]) -> Result<(), Failure> {
    create_folder(folder).map_err(|error| Failure::File(error.to_string()))?;
    methods
        .iter()
        .try_for_each(|name| Destination::check(&folder.join(name)).map(drop))
}

/// The methods of a contest that came to no result.
pub(crate) fn failed(contest: &Contest) -> Value {
    contest
        .failed
        .iter()
        .map(|(method, why)| json!({ "method": method, "why": why }))
        .collect()
}

/// The exit code of a contest that nobody interrupted.
pub(crate) fn code_of(contest: &Contest) -> u8 {
    if contest.failed.is_empty() {
        DONE
    } else {
        NOT_FINITE
    }
}

/// Writes the page in both forms and its facts.
pub(crate) fn write(
    folder: &Path,
    stem: &str,
    page: &crate::report::Document,
    facts: &Value,
) -> Result<(), Failure> {
    let path = folder.join(format!("{stem}.json"));
    let json = serde_json::to_vec_pretty(facts).map_err(OutputError::of(&path));
    json.and_then(|json| write_bytes(&path, &json))
        .and_then(|()| page.write(folder, stem))
        .map_err(|error| Failure::File(error.to_string()))
}

/// Says what came of it and where it is.
pub(crate) fn tell(order: &Order, folder: &Path, stem: &str, table: &str, facts: Value) {
    let page = folder.join(format!("{stem}.html"));
    match order.mode {
        Mode::Human => {
            console::print(&format!("\n{table}"));
            console::print(&format!("the page is {}", page.display()));
        }
        Mode::Json => {
            let mut fields = facts;
            fields["page"] = page.display().to_string().into();
            Display::new(Mode::Json, 0).event(stem, fields);
        }
        Mode::Quiet => {}
    }
}
