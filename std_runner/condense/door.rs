//! The door of the command: all cases by all variants, their folders, the page.

use super::cases::{Case, cases, folder};
use super::job::{self, Listeners, Outcome, status_word};
use super::page::{self, Done};
use super::planned::{planned, print_plan};
use super::written;
use crate::bytes;
use crate::compare::publish;
use crate::destination::{Destination, Earlier};
use crate::exit::{DONE, Failure, code_of, worse};
use crate::interrupt::Interrupt;
use crate::plan::PlanOptions;
use crate::progress::{Display, Mode};
use crate::scene::Document;
use std::path::PathBuf;

/// The name of the page and of its facts.
const STEM: &str = "condense";

/// What is asked for.
pub(crate) struct Request {
    pub document: Document,
    pub folder: PathBuf,
    pub earlier: Earlier,
    pub options: PlanOptions,
    pub mode: Mode,
}

/// Prints the memory that everything takes.
pub(crate) fn plan(request: &Request) -> Result<u8, Failure> {
    for case in cases(&request.document, most(request))? {
        if request.mode == Mode::Quiet {
            planned(&case, &request.options)?;
        } else {
            print_plan(&case, &request.options, request.mode)?;
        }
    }
    Ok(DONE)
}

/// Bytes that the meshes may take: those of the ceiling.
fn most(request: &Request) -> usize {
    let ceiling = request.options.limit.or_else(bytes::of_machine);
    ceiling.unwrap_or(usize::MAX)
}

/// Solves everything and writes the page; the answer is the exit code.
pub(crate) fn run(request: &Request) -> Result<u8, Failure> {
    let cases = cases(&request.document, most(request))?;
    // All is refused before anything is solved.
    let plans = cases.iter().map(|case| planned(case, &request.options));
    let plans = plans.collect::<Result<Vec<_>, _>>()?;
    let mut folder = publish::prepare(&request.folder, STEM, request.earlier)?;
    for case in &cases {
        for variant in &case.variants {
            let folder = place(request, case, &variant.name);
            Destination::check(&folder, files())?;
            request.earlier.check(&folder, "-o DIR")?;
        }
    }
    let interrupt = Interrupt::listen()?;
    let mut done: Vec<Done<'_>> = Vec::new();
    let mut ended = DONE;
    for (case, plans) in cases.iter().zip(&plans) {
        done.push(Done {
            case,
            outcomes: Vec::new(),
        });
        for (variant, fits) in case.variants.iter().zip(plans) {
            if interrupt.asked() {
                break;
            }
            let display = Display::new(request.mode, case.problem.steps);
            let listeners = Listeners {
                interrupt: &interrupt,
                display: &display,
                precision: request.options.precision,
            };
            let mut outcome = job::run(case, variant, fits, listeners)?;
            let mut destination = Destination::check(&place(request, case, &variant.name), files())?;
            destination.fill(|folder| written::write(folder, case, variant, &outcome))?;
            outcome.keep_last(case.problem.mesh.rest.len());
            display.close();
            say(&display, &outcome);
            ended = worse(ended, code_of(outcome.status));
            if let Some(done) = done.last_mut() {
                done.outcomes.push(outcome);
            }
        }
    }
    done.retain(|done| !done.outcomes.is_empty());
    let page = page::page(&name(&request.document), &done)?;
    let facts = page::facts(&done);
    publish::write(&mut folder, STEM, &page, &facts)?;
    publish::announce(request.mode, &folder, STEM, &page::table(&done).plain(), facts);
    Ok(publish::code(&folder, &interrupt, ended))
}

fn files() -> Vec<PathBuf> {
    ["result.npz", "report.json"].map(PathBuf::from).to_vec()
}

/// The name of a scene: that of its preset or file.
fn name(document: &Document) -> String {
    document
        .path()
        .file_stem()
        .map_or_else(String::new, |stem| stem.to_string_lossy().into_owned())
}

/// The folder of a variant, in that of its case where there are several.
fn place(request: &Request, case: &Case, variant: &str) -> PathBuf {
    request.folder.join(folder(&case.label)).join(variant)
}

fn say(display: &Display, outcome: &Outcome) {
    let sum: usize = outcome.iterations.iter().sum();
    display.note(&format!(
        "  {} after {sum} iterations in {} of the steps, {:.2} s",
        status_word(outcome.status),
        outcome.iterations.len(),
        outcome.total
    ));
}
