//! A bar on a terminal, plain lines elsewhere, JSON lines for programs, or nothing.

use super::clock::in_words;
use crate::console;
use crate::keyframes::Note;
use crate::plan::size_in_words;
use crate::report::{IterationRecord, cells};
use core::fmt::Arguments;
use indicatif::{ProgressBar, ProgressStyle};
use serde_json::{Value, json};
use std::io::{IsTerminal, stderr};
use thurible_core::{Kind, Progress};

/// How progress is shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mode {
    /// A bar, or plain lines where stderr is no terminal.
    Human,
    /// JSON lines on stdout.
    Json,
    /// No output but errors.
    Quiet,
}

/// Where progress goes.
pub struct Display {
    mode: Mode,
    bar: Option<ProgressBar>,
    limit: usize,
    summary: String,
}

impl Display {
    /// A display for a solve of at most `limit` iterations.
    pub fn new(mode: Mode, limit: usize) -> Self {
        let bar = (mode == Mode::Human && stderr().is_terminal()).then(|| {
            let style = ProgressStyle::with_template("{spinner} [{bar:14}] {pos}/{len} {wide_msg}");
            let style = style
                .unwrap_or_else(|_| ProgressStyle::default_bar())
                .progress_chars("=> ");
            ProgressBar::new(u64::try_from(limit).unwrap_or(u64::MAX)).with_style(style)
        });
        Display {
            mode,
            bar,
            limit,
            summary: String::new(),
        }
    }

    /// How progress is shown.
    pub fn mode(&self) -> Mode {
        self.mode
    }

    /// How many iterations, or pieces of work, there are at most.
    pub fn limit(&self) -> usize {
        self.limit
    }

    /// Prints a sentence between the lines of progress.
    pub fn note(&self, text: &str) {
        match (self.mode, &self.bar) {
            (Mode::Human, Some(bar)) => bar.println(text),
            (Mode::Human, None) => console::error(text),
            _ => {}
        }
    }

    /// Prints a warning; with `--json` as an event.
    pub fn warning(&self, text: &str) {
        match self.mode {
            Mode::Json => self.event("warning", json!({ "message": text })),
            _ => self.note(&format!("warning: {text}")),
        }
    }

    /// What was found in a file; with `--json` an event.
    pub fn file_note(&self, note: &Note) {
        match (note.warning, self.mode) {
            (true, _) => self.warning(&note.text),
            (false, Mode::Json) => self.event("note", json!({ "message": note.text })),
            (false, _) => self.note(&note.text),
        }
    }

    /// Prints one JSON line, if progress is shown in JSON.
    pub fn event(&self, name: &str, mut fields: Value) {
        if self.mode == Mode::Json {
            fields["event"] = name.into();
            console::print(&fields.to_string());
        }
    }

    /// Shows beside the bar what the solve is doing within an iteration.
    pub fn detail(&self, text: Arguments<'_>) {
        if let Some(bar) = &self.bar {
            bar.set_message(format!("{}{text}", self.summary));
        }
    }

    /// Keeps the spinner moving.
    pub fn tick(&self) {
        if let Some(bar) = &self.bar {
            bar.tick();
        }
    }

    /// Shows an outer iteration that ended `seconds` after the start; `left` seconds are left, about, where that is known.
    pub fn iteration(&mut self, progress: &Progress, seconds: f64, left: Option<f64>) {
        self.event("iteration", iteration_fields(progress, (seconds, left)));
        if self.mode != Mode::Human {
            return;
        }
        let done = iterations_on_the_finest_grid(progress);
        let cells = size_in_words(&cells(progress));
        let left = match left {
            Some(left) => format!("about {} left, ", in_words(left)),
            None if cells.is_empty() => String::new(),
            None => format!("on {cells} cells, "),
        };
        let text = format!(
            "{left}data {:.3e}, force {:.3e}, {}",
            progress.objective.data,
            progress.objective.force,
            manner(progress)
        );
        match &self.bar {
            Some(bar) => {
                bar.set_position(u64::try_from(done).unwrap_or(u64::MAX));
                bar.set_message(text.clone());
            }
            None => console::error(&format!("{done:>4}/{} {text}", self.limit)),
        }
        self.summary = text + ", ";
    }

    /// Shows that `done` pieces of work are over, and `text`.
    pub fn piece(&self, done: usize, text: &str) {
        match (self.mode, &self.bar) {
            (_, Some(bar)) => {
                bar.set_position(u64::try_from(done).unwrap_or(u64::MAX));
                bar.set_message(text.to_owned());
            }
            (Mode::Human, None) => console::error(&format!("{done:>4}/{} {text}", self.limit)),
            _ => {}
        }
    }

    /// Removes the bar from the screen.
    pub fn close(&self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }
}

/// A method that counts the iterations of each grid may begin on coarser ones, which the limit does not count.
pub(super) fn iterations_on_the_finest_grid(progress: &Progress) -> usize {
    match (progress.level, progress.level_iteration) {
        (_, 0) => progress.iteration,
        (0, iteration) => iteration,
        _ => 0,
    }
}

/// What is particular to the method in an iteration: its first two numbers.
fn manner(progress: &Progress) -> String {
    let numbers = progress
        .report
        .iter()
        .filter(|(fact, _)| fact.kind == Kind::Number);
    let shown: Vec<_> = numbers
        .take(2)
        .filter_map(|(fact, values)| Some(format!("{} {:.1e}", fact.name.replace('_', " "), values.last()?)))
        .collect();
    if shown.is_empty() {
        "one pass".into()
    } else {
        shown.join(", ")
    }
}

fn iteration_fields(progress: &Progress, (seconds, left): (f64, Option<f64>)) -> Value {
    serde_json::to_value(IterationRecord::new(seconds, left, progress)).unwrap_or_default()
}
