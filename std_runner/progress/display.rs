//! A bar on a terminal, plain lines elsewhere, JSON lines for programs, or nothing.

use super::clock::in_words;
use crate::console;
use core::fmt::Arguments;
use indicatif::{ProgressBar, ProgressStyle};
use serde_json::{Value, json};
use std::io::{IsTerminal, stderr};
use thurible_core::{AdmmProgress, DirectProgress, Progress};

/// How progress is shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mode {
    /// A bar, or plain lines where stderr is no terminal.
    Human,
    /// JSON lines on stdout.
    Json,
    /// Nothing.
    Quiet,
}

/// Where progress goes.
pub struct Display {
    mode: Mode,
    bar: Option<ProgressBar>,
    limit: usize,
    /// Seconds after the start at which the first iteration on the finest grid began.
    begun: f64,
    summary: String,
}

impl Display {
    /// For a solve of at most `limit` iterations.
    pub fn new(mode: Mode, limit: usize) -> Self {
        let bar = (mode == Mode::Human && stderr().is_terminal()).then(|| {
            let style = ProgressStyle::with_template("{spinner} [{bar:14}] {pos}/{len} {wide_msg}");
            let style = style.unwrap_or_else(|_| ProgressStyle::default_bar()).progress_chars("=> ");
            ProgressBar::new(u64::try_from(limit).unwrap_or(u64::MAX)).with_style(style)
        });
        Display { mode, bar, limit, begun: 0.0, summary: String::new() }
    }

    /// A sentence between the lines of progress.
    pub fn note(&self, text: &str) {
        match (self.mode, &self.bar) {
            (Mode::Human, Some(bar)) => bar.println(text),
            (Mode::Human, None) => console::error(text),
            _ => {}
        }
    }

    /// A warning; with `--json` an event.
    pub fn warning(&self, text: &str) {
        match self.mode {
            Mode::Json => self.event("warning", json!({ "message": text })),
            _ => self.note(&format!("warning: {text}")),
        }
    }

    /// One JSON line, if that is how progress is shown.
    pub fn event(&self, name: &str, mut fields: Value) {
        if self.mode == Mode::Json {
            fields["event"] = name.into();
            console::print(&fields.to_string());
        }
    }

    /// What the solve is doing within an iteration.
    pub fn detail(&self, text: Arguments<'_>) {
        if let Some(bar) = &self.bar {
            bar.set_message(format!("{}{text}", self.summary));
        }
    }

    /// Something small is done.
    pub fn tick(&self) {
        if let Some(bar) = &self.bar {
            bar.tick();
        }
    }

    /// An outer iteration is over, `seconds` after the start.
    pub fn iteration(&mut self, progress: &Progress, seconds: f64) {
        self.event("iteration", iteration_fields(progress, seconds));
        if self.mode != Mode::Human {
            return;
        }
        let parts = format!("data {:.3e}, force {:.3e}, {}", progress.objective.data, progress.objective.force, detail(progress));
        let done = done(progress);
        let text = if done == 0 {
            self.begun = seconds;
            format!("{} of {} cells, {parts}", progress.direct.level_iteration, grid(&progress.direct))
        } else {
            let left = self.limit.saturating_sub(done) as f64 * (seconds - self.begun) / done as f64;
            format!("at most {} left, {parts}", in_words(left))
        };
        match &self.bar {
            Some(bar) => {
                bar.set_position(u64::try_from(done).unwrap_or(u64::MAX));
                bar.set_message(text.clone());
            }
            None => console::error(&format!("{done:>4}/{} {text}", self.limit)),
        }
        self.summary = text + ", ";
    }

    /// Takes the bar off the screen.
    pub fn close(&self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }
}

/// Whether the direct method made this iteration: it alone names a grid.
fn is_direct(progress: &Progress) -> bool {
    progress.direct.cells[0] > 0
}

/// Iterations that count towards the limit: 0 while the direct method is on a coarser grid.
fn done(progress: &Progress) -> usize {
    match (is_direct(progress), progress.direct.level) {
        (true, 0) => progress.direct.level_iteration,
        (true, _) => 0,
        (false, _) => progress.iteration.max(1),
    }
}

/// `32 x 32`; the axis that a plane has not is left out.
fn grid(direct: &DirectProgress) -> String {
    let dims = if direct.cells[2] > 1 { 3 } else { 2 };
    direct.cells[..dims].iter().map(usize::to_string).collect::<Vec<_>>().join(" x ")
}

/// What the method says about the iteration.
fn detail(progress: &Progress) -> String {
    if is_direct(progress) {
        return format!("step {}", progress.direct.step);
    }
    let residual = progress.admm.nso_residuals.last().copied().unwrap_or(f64::NAN);
    format!("residual {residual:.0e}, change {:.1e}", progress.admm.density_change)
}

fn iteration_fields(progress: &Progress, seconds: f64) -> Value {
    let mut fields = json!({
        "iteration": progress.iteration,
        "seconds": seconds,
        "data": progress.objective.data,
        "force": progress.objective.force,
        "total": progress.objective.total(),
    });
    let own = if is_direct(progress) { direct_fields(&progress.direct) } else { admm_fields(&progress.admm) };
    if let (Value::Object(fields), Value::Object(own)) = (&mut fields, own) {
        fields.extend(own);
    }
    fields
}

fn direct_fields(direct: &DirectProgress) -> Value {
    json!({
        "cells": direct.cells,
        "level": direct.level,
        "level_iteration": direct.level_iteration,
        "step": direct.step,
        "slope": direct.slope,
        "evaluations": direct.evaluations,
    })
}

fn admm_fields(admm: &AdmmProgress) -> Value {
    json!({
        "ao_step": admm.ao_step,
        "density_change": admm.density_change,
        "nso_residuals": admm.nso_residuals.as_slice(),
        "kkt": admm.kkt,
        "ao_residual": admm.ao_residual,
        "gap": admm.gap,
        "data_of_star": admm.data_of_star,
        "held": admm.held,
    })
}
