//! The columns of the table of a comparison; the page of the paper's scenes has the same.

use super::figures::Figures;
use crate::report::{bytes, number};
use thurible_core::{Named, Status};

/// Names of the columns after those that say which run it is.
pub(crate) const COLUMNS: [&str; 14] = [
    "ended",
    "iterations",
    "on coarser grids",
    "s to 1 %",
    "s to worst end",
    "s to own stop",
    "s per iteration",
    "s per AO",
    "s per NSO",
    "objective",
    "keyframe part",
    "force part",
    "worst keyframe (before)",
    "memory (paper's M)",
];

/// The cells of [`COLUMNS`].
pub(crate) fn cells(figures: &Figures) -> Vec<String> {
    let or_dash = |value: Option<f64>| value.map_or_else(|| "\u{2013}".into(), seconds_alone);
    vec![
        status(figures.status).into(),
        figures.iterations.to_string(),
        figures.coarser_iterations.to_string(),
        figures
            .seconds_to_best
            .map_or_else(|| "not reached".into(), seconds_alone),
        or_dash(figures.seconds_to_worst),
        seconds_alone(figures.seconds),
        seconds_alone(figures.iteration_average),
        or_dash(figures.ao_average),
        or_dash(figures.nso_average),
        number(figures.objective.total()),
        number(figures.objective.data),
        number(figures.objective.force),
        format!(
            "{:.1} % ({:.1} %)",
            100.0 * figures.keyframe_error,
            100.0 * figures.keyframe_error_before
        ),
        format!(
            "{} ({})",
            bytes(figures.planned_bytes),
            bytes(figures.paper_bound_bytes)
        ),
    ]
}

/// Iterations, seconds per AO, per NSO and in all, and memory.
pub(crate) fn in_brief(figures: &Figures) -> [String; 5] {
    let or_dash = |value: Option<f64>| value.map_or_else(|| "\u{2013}".into(), seconds_alone);
    let iterations = figures.iterations.to_string();
    [
        iterations,
        or_dash(figures.ao_average),
        or_dash(figures.nso_average),
        seconds_alone(figures.seconds),
        bytes(figures.planned_bytes),
    ]
}

/// Seconds to three digits or four, without a unit.
fn seconds_alone(value: f64) -> String {
    let decimals = if value >= 100.0 {
        0
    } else if value >= 10.0 {
        1
    } else if value >= 1.0 {
        2
    } else if value >= 0.1 {
        3
    } else {
        return number(value);
    };
    format!("{value:.decimals$}")
}

/// How a solve ended, in a word or three.
pub(crate) fn status(status: Status) -> &'static str {
    match status {
        Status::MaxIterations => "at its limit",
        Status::Cancelled => "interrupted",
        other => other.name(),
    }
}

/// A note on the last column.
pub(crate) const MEMORY: &str = "Memory is the one block that a solve takes, source and keyframes included. The paper's M = 4 (1 + d) N prod(n) / (1 - 2^-d) \
     numbers bounds its own method, ADMM, without source and keyframes; it is given here in the precision of this run.";
