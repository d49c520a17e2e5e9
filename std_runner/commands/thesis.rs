//! `thurible thesis`: our row beside every figure and table of Gregson's thesis, on one page.

use super::options::{Options, Overwriting, Resources};
use super::words::Words;
use crate::bytes::rounded;
use crate::compare::publish;
use crate::console;
use crate::exit::{DONE, Failure, NOT_FINITE};
use crate::interrupt::Interrupt;
use crate::progress::{Display, Mode, in_words};
use crate::quoted::Scale;
use crate::thesis::{self, Bench, Done, Figure, Halt, Sheet};
use clap::Args;
use serde_json::json;
use std::path::PathBuf;

/// The name of the page and of its facts.
const STEM: &str = "thesis";

/// Arguments of `thesis`.
#[derive(Args, Debug)]
pub struct ThesisArguments {
    /// Which of them; all if none is named. --list shows the names.
    #[arg(value_name = "NAME", value_parser = Words(thesis::known().words()), hide_possible_values = true)]
    pub names: Vec<String>,
    /// Print the names, what they are and about how long they take, and run nothing.
    #[arg(long)]
    pub list: bool,
    /// The cells along each axis times this: 1, 1/2, 1/4 or 1/8; the frames stay.
    #[arg(long, value_name = "S", default_value = "1", value_parser = Scale::parse)]
    pub scale: Scale,
    /// Keep result.npz of every run too; at full size they are gigabytes.
    #[arg(long)]
    pub arrays: bool,
    /// Leave pictures and curves out of thesis.md; thesis.html keeps them.
    #[arg(long)]
    pub no_pictures: bool,
    /// Those of the machine.
    #[command(flatten)]
    pub resources: Resources,
    /// What becomes of a page and results that are there.
    #[command(flatten)]
    pub overwriting: Overwriting,
    /// Where the page and the result folders go.
    #[arg(short, long, value_name = "DIR", default_value = "out/thesis")]
    pub output: PathBuf,
}

/// Makes the figures and writes the page; the answer is the exit code.
pub fn run(arguments: &ThesisArguments) -> Result<u8, Failure> {
    if arguments.list {
        list(arguments.scale, arguments.resources.mode());
        return Ok(DONE);
    }
    let names = thesis::known().chosen(&arguments.names)?;
    let asked = thesis::figures().filter(|figure| names.contains(&figure.name));
    let asked: Vec<&'static Figure> = asked.collect();
    let options = Options {
        resources: arguments.resources.clone(),
        set: Vec::new(),
    };
    let earlier = arguments.overwriting.earlier();
    let mut folder = publish::prepare(&arguments.output, STEM, earlier)?;
    let interrupt = Interrupt::listen()?;
    let mut bench = Bench::new(
        &options,
        arguments.scale,
        (&arguments.output, earlier),
        &interrupt,
    );
    let mut done: Vec<Done> = Vec::new();
    let mut broken = None;
    for figure in &asked {
        if interrupt.asked() || broken.is_some() {
            break;
        }
        announce(figure, arguments, done.len(), asked.len());
        let mut sheet = Sheet::default();
        let whole = match (figure.make)(&mut bench, &mut sheet) {
            Ok(()) => true,
            Err(Halt::Asked) => false,
            Err(Halt::Failed(why)) => {
                sheet.fail(why);
                true
            }
            // What the figure has until then stays on the page.
            Err(Halt::Broken(failure)) => {
                broken = Some(failure);
                false
            }
        };
        done.push(Done { figure, sheet, whole });
        // After each figure, so that the page of a long run can be read meanwhile, and stays if the run is stopped.
        let mut page = thesis::page(&asked, &done, arguments.scale, &options);
        page.pictures = !arguments.no_pictures;
        let written = publish::write(&mut folder, STEM, &page, &thesis::facts(&done, arguments.scale));
        // Why it broke off is said, not that there is no page of it.
        if broken.is_none() {
            written?;
        }
    }
    if !arguments.arrays {
        let forgotten = bench.forget_all_arrays();
        if broken.is_none() {
            forgotten?;
        }
    }
    if let Some(failure) = broken {
        return Err(failure);
    }
    let table = format!("{}\n{}\n", thesis::overview(&asked, &done).plain(), thesis::RULE);
    publish::announce(
        options.mode(),
        &folder,
        STEM,
        &table,
        thesis::facts(&done, arguments.scale),
    );
    Ok(publish::code(&folder, &interrupt, exit_code(&done)))
}

/// Says which figure begins.
fn announce(figure: &Figure, arguments: &ThesisArguments, before: usize, all: usize) {
    let [seconds, _] = figure.expected(arguments.scale);
    let display = Display::new(arguments.resources.mode(), all);
    let fields = json!({ "name": figure.name, "title": figure.title, "number": before + 1, "of": all, "expected_seconds": seconds });
    display.event("figure", fields);
    display.note(&format!(
        "{} of {all}: {}: {}, about {}",
        before + 1,
        figure.name,
        figure.title,
        in_words(seconds)
    ));
}

/// 1 where any row failed.
fn exit_code(done: &[Done]) -> u8 {
    let failed = |done: &Done| done.sheet.counts()[1] > 0;
    if done.iter().any(failed) { NOT_FINITE } else { DONE }
}

/// Prints the names, and what each figure takes about.
fn list(scale: Scale, mode: Mode) {
    for figure in thesis::figures() {
        let [seconds, bytes] = figure.expected(scale);
        if mode == Mode::Json {
            let fields = json!({ "name": figure.name, "title": figure.title, "expected_seconds": seconds, "expected_bytes": bytes });
            Display::new(mode, 0).event("figure", fields);
            continue;
        }
        console::print(&format!(
            "{:<10}{:<62}about {}, {}",
            figure.name,
            figure.title,
            in_words(seconds),
            rounded(bytes as usize)
        ));
    }
    if mode == Mode::Json {
        return;
    }
    thesis::known()
        .lines()
        .iter()
        .for_each(|line| console::print(line));
}
