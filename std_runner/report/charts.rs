//! The curves of a run.

use super::axes::Scale;
use super::chart::{Chart, Curve};
use super::iteration::IterationRecord;
use thurible_core::{Fact, Kind};

/// All figures that this run has data for, as HTML.
pub(crate) fn charts(history: &[IterationRecord]) -> String {
    let mut charts = vec![objective(history)];
    if history.iter().any(|entry| entry.level.is_some()) {
        charts.push(gains(history));
    }
    charts.extend(titles(history).into_iter().map(|title| of_facts(title, history)));
    charts.iter().map(Chart::to_html).collect()
}

/// The iterations of one grid after the other, coarsest first; a method without coarser grids has one piece.
pub(crate) fn by_grid(history: &[IterationRecord]) -> impl Iterator<Item = &[IterationRecord]> {
    history.chunk_by(|before, after| before.level == after.level && before.window == after.window)
}

fn objective(history: &[IterationRecord]) -> Chart {
    let curve = |name: &str, colour, value: fn(&IterationRecord) -> f64| {
        let pieces = by_grid(history).map(|piece| {
            piece
                .iter()
                .map(|entry| (entry.iteration as f64, value(entry)))
                .collect()
        });
        Curve {
            name: name.into(),
            colour,
            pieces: pieces.collect(),
        }
    };
    let note = if by_grid(history).count() > 1 {
        "Distance from the keyframes, price of the force, and their sum. Each piece is a grid; the values of one cannot be compared with those of another."
    } else {
        "Distance from the keyframes, price of the force, and their sum."
    };
    Chart {
        title: "Objective",
        note: note.into(),
        across: "iteration",
        scale: Scale::Counts,
        curves: vec![
            curve("total", 3, |entry| entry.objective.total()),
            curve("data", 1, |entry| entry.objective.data),
            curve("force", 2, |entry| entry.objective.force),
        ],
    }
}

fn gains(history: &[IterationRecord]) -> Chart {
    let gain = |pair: &[IterationRecord]| {
        let [before, after] = pair else { return None };
        let (was, is) = (before.objective.total(), after.objective.total());
        Some((after.iteration as f64, (was - is) / was))
    };
    let pieces = by_grid(history).map(|piece| piece.windows(2).filter_map(gain).collect());
    Chart {
        title: "Gain",
        note: "By how much an iteration lowers the objective, in parts of it; convergence is judged by it."
            .into(),
        across: "iteration",
        scale: Scale::Counts,
        curves: vec![Curve {
            name: "gain".into(),
            colour: 2,
            pieces: pieces.collect(),
        }],
    }
}

/// The charts that a method's facts are drawn in, in the order of the facts.
fn titles(history: &[IterationRecord]) -> Vec<&'static str> {
    let mut titles = Vec::new();
    for title in facts(history).filter_map(|fact| fact.chart) {
        if !titles.contains(&title) {
            titles.push(title);
        }
    }
    titles
}

/// What the method tells, as its first iteration that tells anything has it.
fn facts(history: &[IterationRecord]) -> impl Iterator<Item = Fact> {
    let first = history.iter().find(|entry| !entry.facts.0.is_empty());
    first
        .into_iter()
        .flat_map(|entry| entry.facts.0.iter().map(|&(fact, _)| fact))
}

/// The chart with this title: a curve for each of its facts. A series is spread over its iteration.
fn of_facts(title: &'static str, history: &[IterationRecord]) -> Chart {
    let drawn: Vec<Fact> = facts(history).filter(|fact| fact.chart == Some(title)).collect();
    let is_series = drawn.iter().any(|fact| fact.kind == Kind::Series);
    Chart {
        title,
        note: match drawn.as_slice() {
            [fact] => fact.words.into(),
            several => several.iter().map(in_words).collect::<Vec<_>>().join("; "),
        },
        across: if is_series {
            "iteration (series within)"
        } else {
            "iteration"
        },
        scale: Scale::Counts,
        curves: drawn
            .iter()
            .enumerate()
            .map(|(index, &fact)| curve_of(fact, index % 4 + 1, history))
            .collect(),
    }
}

/// A fact by the name of its curve, and what it is.
fn in_words(fact: &Fact) -> String {
    format!("{}: {}", fact.name.replace('_', " "), fact.words)
}

fn curve_of(fact: Fact, colour: usize, history: &[IterationRecord]) -> Curve {
    let name = fact.name.replace('_', " ");
    if fact.kind != Kind::Series {
        let point = |entry: &IterationRecord| Some((entry.iteration as f64, entry.facts.get(fact.name)?));
        let pieces = by_grid(history).map(|piece| piece.iter().filter_map(point).collect());
        return Curve {
            name,
            colour,
            pieces: pieces.collect(),
        };
    }
    let within = |entry: &IterationRecord| {
        let values = entry.facts.series(fact.name);
        let spacing = 1.0 / values.len().saturating_sub(1).max(1) as f64;
        let start = entry.iteration as f64 - 1.0;
        let point = |(index, &value): (usize, &f64)| (start + index as f64 * spacing, value);
        values.iter().enumerate().map(point).collect()
    };
    Curve {
        name,
        colour,
        pieces: history.iter().map(within).collect(),
    }
}
