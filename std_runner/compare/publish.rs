//! The folder of a page, and the page in it: shared by `compare`, `sweep`, `condense`, `paper` and `thesis`.

use crate::console;
use crate::destination::{Destination, Earlier};
use crate::exit::{FILE, Failure, INTERRUPTED};
use crate::interrupt::Interrupt;
use crate::output::{OutputError, write_bytes};
use crate::progress::{Display, Mode};
use crate::report::{self, Document};
use crate::scene::Scene;
use serde_json::{Value, json};
use std::fs;
use std::path::{Path, PathBuf};

/// The folder of a page, marked as one of ours before anything is solved, so that a run that was ended before there was anything can be repeated
/// into it.
///
/// # Errors
/// It holds a page that is not to be replaced, or as [`Destination::check`].
pub(crate) fn prepare(folder: &Path, stem: &str, earlier: Earlier) -> Result<Destination, Failure> {
    let mark = mark(stem);
    let names = ["json", "html", "md"].map(|kind| PathBuf::from(format!("{stem}.{kind}")));
    let mut page = Destination::check_for(folder, &mark, names.to_vec())?;
    // A page that a killed run was moving there is in its place by now.
    if earlier == Earlier::Refused && holds_page(&page.folder().join(&mark)) {
        return Err(Failure::File(format!(
            "{} holds a page already, {stem}.html: keep it and choose another folder with -o DIR, or write over it and the results below it with --force",
            folder.display()
        )));
    }
    if !page.folder().join(&mark).exists() {
        let empty = json!({ "format": 1 }).to_string();
        page.add(|folder| write_bytes(&folder.join(&mark), empty.as_bytes()))?;
    }
    Ok(page)
}

/// Whether the facts of a page are in the file `mark`, and not the mark alone.
fn holds_page(mark: &Path) -> bool {
    let facts = fs::read(mark).unwrap_or_default();
    let facts = serde_json::from_slice::<Value>(&facts).unwrap_or_default();
    facts.get("format").is_some() && facts.as_object().is_some_and(|facts| facts.len() > 1)
}

/// Whether somebody has marked the folder so.
pub(crate) fn is_marked(folder: &Path, stem: &str) -> bool {
    folder.join(mark(stem)).is_file()
}

fn mark(stem: &str) -> String {
    format!("{stem}.json")
}

/// Refuses a folder for a method below `folder` that cannot hold the result of its scene, or holds one that is not to be replaced.
pub(crate) fn check_below(
    (folder, earlier): (&Path, Earlier),
    methods: &[String],
    scenes: &[Scene],
    images: bool,
) -> Result<(), Failure> {
    let check = |(name, scene): (&String, &Scene)| {
        let files = report::files(scene.time.steps, images);
        let folder = folder.join(name);
        Destination::check(&folder, files)?;
        earlier.check(&folder, "-o DIR")
    };
    methods.iter().zip(scenes).try_for_each(check)
}

/// Writes the page as HTML and Markdown, and its facts as JSON.
pub(crate) fn write(
    destination: &mut Destination,
    stem: &str,
    page: &Document,
    facts: &Value,
) -> Result<(), Failure> {
    destination.fill(|folder| {
        let path = folder.join(format!("{stem}.json"));
        let json = serde_json::to_vec_pretty(facts).map_err(OutputError::of(&path))?;
        write_bytes(&path, &json)?;
        page.write(folder, stem)
    })
}

/// Prints the table and where the page is.
pub(crate) fn announce(mode: Mode, destination: &Destination, stem: &str, table: &str, facts: Value) {
    let page = destination.shown().join(format!("{stem}.html"));
    match mode {
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
    if let Some(why) = destination.diverted() {
        console::error(&format!("thurible: {why}"));
    }
}

/// The exit code of a page whose runs ended with `ended`.
pub(crate) fn code(destination: &Destination, interrupt: &Interrupt, ended: u8) -> u8 {
    if destination.diverted().is_some() {
        FILE
    } else if interrupt.asked() {
        INTERRUPTED
    } else {
        ended
    }
}
