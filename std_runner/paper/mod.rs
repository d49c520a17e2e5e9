//! `thurible paper`: the scenes of the paper's Table 2 and figures, on one page beside the paper's own figures.

mod catalogue;
mod page;
mod scale;
mod selection;

pub use scale::Scale;

use crate::bytes::rounded;
use crate::cli::PaperArguments;
use crate::compare::{self, Contest};
use crate::console;
use crate::exit::{DONE, Failure, INTERRUPTED};
use crate::interrupt::Interrupt;
use crate::plan::{self, size_in_words};
use crate::scene::Scene;
use crate::solve::{Order, Parts};
use catalogue::{Entry, GROUPS, SHEETS, Sheet};
use serde_json::{Value, json};
use std::path::PathBuf;

/// The name of the page and of its facts.
const STEM: &str = "paper";

/// A scene that has been solved.
struct Shown {
    entry: &'static Entry,
    contest: Contest,
}

/// A scene that is going to be solved.
struct Due {
    entry: &'static Entry,
    methods: Vec<String>,
    scenes: Vec<Scene>,
    folder: PathBuf,
}

/// Runs `paper`.
pub fn run(arguments: &PaperArguments) -> Result<u8, Failure> {
    let options = &arguments.options;
    let order = Order {
        wishes: options.wishes(),
        mode: options.mode(),
        parts: Parts {
            arrays: arguments.arrays,
            images: false,
        },
    };
    if arguments.list {
        return list(arguments, &order);
    }
    let sheets = selection::sheets(&arguments.names)?;
    refuse_unfit(&sheets, arguments)?;
    let due = due(&sheets, arguments, &order)?;
    compare::prepare(&arguments.output, STEM)?;
    due.iter()
        .try_for_each(|due| compare::check_below(&due.folder, &due.methods))?;
    let interrupt = Interrupt::listen()?;
    let mut shown = Vec::new();
    for due in due {
        if interrupt.asked() {
            break;
        }
        let contest = Contest::hold(due.scenes, &due.methods, &order, &due.folder, &interrupt)?;
        shown.push(Shown {
            entry: due.entry,
            contest,
        });
        // After each scene, so that a long run can be looked at, and leaves what it has if it is stopped.
        compare::write(
            &arguments.output,
            STEM,
            &page::page(&sheets, &shown, arguments.scale),
            &facts(&shown, arguments.scale),
        )?;
    }
    compare::tell(
        &order,
        &arguments.output,
        STEM,
        &page::table(&shown).markdown(),
        facts(&shown, arguments.scale),
    );
    let worst = shown
        .iter()
        .map(|shown| compare::code_of(&shown.contest))
        .max()
        .unwrap_or(DONE);
    Ok(if interrupt.asked() { INTERRUPTED } else { worst })
}

/// A sheet that was named must have a method that it is about.
fn refuse_unfit(sheets: &[&Sheet], arguments: &PaperArguments) -> Result<(), Failure> {
    let asked = &arguments.contenders.methods;
    let unfit = |sheet: &&&Sheet| {
        arguments.names.iter().any(|name| name == sheet.name)
            && sheet.members().all(|entry| entry.methods(asked).is_empty())
    };
    sheets.iter().find(unfit).map_or(Ok(()), |sheet| {
        let only = sheet.only();
        Err(Failure::Input(format!(
            "--methods {}: {} is about {} alone; add it, as in --methods {}",
            asked.join(","),
            sheet.name,
            compare::listed(only),
            only.join(",")
        )))
    })
}

/// Every scene once, checked and planned with each of its methods.
fn due(sheets: &[&Sheet], arguments: &PaperArguments, order: &Order) -> Result<Vec<Due>, Failure> {
    let mut all: Vec<Due> = Vec::new();
    for entry in sheets.iter().flat_map(|sheet| sheet.members()) {
        let methods = entry.methods(&arguments.contenders.methods);
        if methods.is_empty() || all.iter().any(|due| due.entry.name == entry.name) {
            continue;
        }
        let document = entry.document(arguments.scale, &arguments.options.set)?;
        let scenes = compare::entries(&document, &methods, order)?;
        all.push(Due {
            entry,
            methods,
            scenes,
            folder: arguments.output.join(entry.name),
        });
    }
    Ok(all)
}

fn facts(shown: &[Shown], scale: Scale) -> Value {
    let scene = |shown: &Shown| {
        let contest = &shown.contest;
        json!({ "name": shown.entry.name, "best": contest.best(), "rows": contest.figures(), "failed": compare::failed(contest) })
    };
    json!({ "format": 1, "scale": scale.name(), "scenes": shown.iter().map(scene).collect::<Vec<_>>() })
}

/// Prints the names, and what the first method that is asked for would take.
fn list(arguments: &PaperArguments, order: &Order) -> Result<u8, Failure> {
    let mut names = Vec::new();
    for sheet in SHEETS {
        console::print(&format!("{:<10}{}", sheet.name, sheet.title));
        for entry in sheet.members() {
            console::print(&format!(
                "{:<10}  {:<18}{:<40}{}",
                "",
                entry.name,
                entry.about,
                needs(entry, arguments, order)?
            ));
        }
        names.push(sheet.name);
    }
    for (group, members) in GROUPS.iter().filter(|(_, members)| members.len() < names.len()) {
        console::print(&format!("{group:<10}{}", members.join(" ")));
    }
    console::print(&format!("{:<10}all of them; without a name: table2", "all"));
    Ok(DONE)
}

/// Size and memory of an entry, or why it would not be solved.
fn needs(entry: &Entry, arguments: &PaperArguments, order: &Order) -> Result<String, Failure> {
    let methods = entry.methods(&arguments.contenders.methods);
    let Some(method) = methods.first() else {
        return Ok(format!("only by {}", compare::listed(entry.only)));
    };
    let scenes = compare::entries(
        &entry.document(arguments.scale, &arguments.options.set)?,
        core::slice::from_ref(method),
        order,
    )?;
    let planned = scenes
        .first()
        .map(|scene| plan::choose(scene, &order.wishes))
        .transpose()?;
    Ok(planned.map_or_else(String::new, |planned| {
        format!(
            "{}, {} steps, {} by {method}",
            size_in_words(&planned.problem.cells),
            planned.problem.steps,
            rounded(planned.plan.bytes())
        )
    }))
}
