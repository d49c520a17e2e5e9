//! The curves of a run.

use super::axes::Scale;
use super::chart::{Chart, Curve};
use super::record::{AdmmRecord, IterationRecord, RunRecord};

/// All figures that this run has data for, as HTML.
pub(super) fn charts(record: &RunRecord) -> String {
    let history = &record.history;
    let mut charts = vec![objective(history)];
    if history.iter().any(|entry| entry.direct.is_some()) {
        charts.push(gains(history));
    }
    if history.iter().any(|entry| entry.admm.is_some()) {
        charts.extend([density_change(history), residuals(history), optimality(history)]);
    }
    charts.iter().map(Chart::to_html).collect()
}

/// The iterations of one grid after the other, coarsest first; a method without coarser grids has one piece.
pub(crate) fn by_grid(history: &[IterationRecord]) -> impl Iterator<Item = &[IterationRecord]> {
    let level = |entry: &IterationRecord| entry.direct.as_ref().map(|direct| direct.level.clone());
    history.chunk_by(move |before, after| level(before) == level(after))
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
        note,
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
        note: "By how much an iteration lowers the objective, in parts of it; convergence is judged by it.",
        across: "iteration",
        scale: Scale::Counts,
        curves: vec![Curve {
            name: "gain".into(),
            colour: 2,
            pieces: pieces.collect(),
        }],
    }
}

fn density_change(history: &[IterationRecord]) -> Chart {
    Chart {
        title: "Change of the density",
        note: "Largest change in one iteration, in parts of the source's largest density; convergence is judged by it.",
        across: "iteration",
        scale: Scale::Counts,
        curves: vec![curve_of("density change", 1, history, |admm| admm.density_change)],
    }
}

fn residuals(history: &[IterationRecord]) -> Chart {
    let pieces = history.iter().filter_map(|entry| {
        let residuals = &entry.admm.as_ref()?.nso_residuals;
        let spacing = 1.0 / residuals.len().saturating_sub(1).max(1) as f64;
        let start = entry.iteration as f64 - 1.0;
        Some(
            residuals
                .iter()
                .enumerate()
                .map(|(cycle, &residual)| (start + cycle as f64 * spacing, residual))
                .collect(),
        )
    });
    Chart {
        title: "Navier\u{2013}Stokes problem",
        note: "Residual max |f| before the first V-cycle of each iteration and after each.",
        across: "iteration (V-cycles within)",
        scale: Scale::Counts,
        curves: vec![Curve {
            name: "residual".into(),
            colour: 2,
            pieces: pieces.collect(),
        }],
    }
}

fn optimality(history: &[IterationRecord]) -> Chart {
    Chart {
        title: "Optimality",
        note: "Residuals of the whole problem's optimality conditions, of the advection problem, and the gap between v and v*.",
        across: "iteration",
        scale: Scale::Counts,
        curves: vec![
            curve_of("KKT", 3, history, |admm| admm.kkt),
            curve_of("advection", 1, history, |admm| {
                admm.ao_residuals.last().copied().unwrap_or(f64::NAN)
            }),
            curve_of("gap", 2, history, |admm| admm.gap),
        ],
    }
}

fn curve_of(name: &str, colour: usize, history: &[IterationRecord], value: fn(&AdmmRecord) -> f64) -> Curve {
    let points = history
        .iter()
        .filter_map(|entry| Some((entry.iteration as f64, value(entry.admm.as_ref()?))));
    Curve::new(name, colour, points)
}
