//! The page of the thesis' figures, and its facts.

use super::figure::Figure;
use super::sheet::Sheet;
use crate::commands::options::Options;
use crate::quoted::{NOT_GIVEN, Scale, machine};
use crate::report::{Block, Document, Table, bytes, count, seconds};
use crate::run::command_line;
use crate::threads;
use serde_json::{Value, json};

/// When a row counts as failed, for readers.
pub(crate) const RULE: &str = "A row has failed where its run came to no result, where a figure of it is not finite, or where the thesis gives an error for the same data at the same size \
     and ours is larger.";

/// A figure with what was made of it.
pub(crate) struct Done {
    pub figure: &'static Figure,
    pub sheet: Sheet,
    /// Whether it is whole.
    pub whole: bool,
}

impl Done {
    fn ended(&self) -> String {
        let [rows, failed] = self.sheet.counts();
        let rows = count(rows, "row");
        match (self.whole, failed) {
            (false, _) => format!("interrupted after {rows}"),
            (true, 0) => rows,
            (true, _) => format!("{rows}, {failed} failed"),
        }
    }
}

/// The page about what has been made so far; a figure that was asked for and is not there yet says so.
pub(crate) fn page(asked: &[&'static Figure], done: &[Done], scale: Scale, options: &Options) -> Document {
    let mut blocks = vec![
        Block::Text(measured(options)),
        Block::Code(command_line()),
        Block::Table(overview(asked, done)),
        Block::Text(RULE.into()),
        Block::Text(quoted_from(scale)),
    ];
    let mut done = done.iter();
    for figure in asked {
        blocks.push(Block::Heading(figure.title.into()));
        blocks.push(Block::Text(figure.text.into()));
        blocks.push(Block::Text(format!("The thesis: {}", figure.thesis)));
        match done.next() {
            Some(done) => {
                blocks.push(Block::Table(done.sheet.table()));
                blocks.extend(done.sheet.blocks.iter().cloned());
            }
            None => blocks.push(Block::Text("Not run: the run was stopped before.".into())),
        }
    }
    let size = match scale.divisor() {
        1 => "at full size".to_owned(),
        _ => format!("at {} of the cells along each axis", scale.name()),
    };
    Document {
        title: "The thesis' figures".into(),
        lead: format!(
            "Figures and tables of J. Gregson's thesis, made {size}, beside what it says of its own."
        ),
        blocks,
        pictures: true,
    }
}

fn measured(options: &Options) -> String {
    let resources = &options.resources;
    let count = resources.threads.unwrap_or_else(threads::available);
    let machine = machine(env!("CARGO_PKG_VERSION"), options.plan().precision.name(), count);
    format!(
        "All figures but those marked as the thesis' were produced by this one run: {machine}. Seconds are those of a row's run, reading, drawing and writing included; what rows share, as a \
         capture or its photographs, is not in them. Memory is the one block that a run takes."
    )
}

fn quoted_from(scale: Scale) -> String {
    let from = "The columns \"thesis\" quote J. Gregson, \"Applications of inverse problems in fluids and imaging\" (PhD thesis, University of British Columbia, 2015), measured by its author \
                with his own programs on data of his own, which is not part of this project.";
    match scale.divisor() {
        1 => from.into(),
        _ => format!(
            "{from} They are for the full size, not for the {} of this run.",
            scale.name()
        ),
    }
}

/// A row for each figure.
pub(crate) fn overview(asked: &[&'static Figure], done: &[Done]) -> Table {
    let row = |(index, figure): (usize, &&'static Figure)| {
        let done = done.get(index);
        let (spent, most) = done.map_or((0.0, 0), |done| done.sheet.spent());
        vec![
            figure.name.to_owned(),
            figure
                .title
                .split_once(": ")
                .map_or(figure.title, |(_, title)| title)
                .to_owned(),
            done.map_or_else(|| "not run".into(), Done::ended),
            if spent > 0.0 {
                seconds(spent)
            } else {
                NOT_GIVEN.into()
            },
            if most > 0 { bytes(most) } else { NOT_GIVEN.into() },
        ]
    };
    let head = vec!["figure", "what", "ended", "seconds of its rows", "most memory"];
    Table {
        rows: asked.iter().enumerate().map(row).collect(),
        names: 2,
        ours: head.len(),
        head,
    }
}

/// Everything as JSON.
pub(crate) fn facts(done: &[Done], scale: Scale) -> Value {
    let figure = |done: &Done| {
        let [rows, failed] = done.sheet.counts();
        json!({ "name": done.figure.name, "title": done.figure.title, "whole": done.whole, "rows": done.sheet.facts(),
                "count": rows, "failed": failed })
    };
    json!({ "format": 1, "scale": scale.name(), "figures": done.iter().map(figure).collect::<Vec<_>>() })
}
