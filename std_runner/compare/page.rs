//! The page of a comparison, in parts that the page of the paper's scenes uses too.

use super::columns::{COLUMNS, MEMORY, cells};
use super::comparison::{Comparison, Lost};
use super::figures::{Figures, descends, way};
use super::words::listed;
use crate::quoted::machine;
use crate::report::{
    Block, Chart, Curve, Document, IterationRecord, RunRecord, Scale, Shot, Table, number, product, seconds,
    smoothness,
};
use crate::stay::Stay;

/// The page about one scene.
pub(crate) fn page(name: &str, comparison: &Comparison) -> Document {
    let methods: Vec<&str> = comparison.records().map(|record| record.method.name()).collect();
    let mut blocks = comparison
        .records()
        .next()
        .map(conditions)
        .into_iter()
        .flatten()
        .collect::<Vec<_>>();
    blocks.extend(comparison.note.iter().map(said));
    blocks.push(Block::Table(table(&comparison.figures())));
    blocks.extend(notes(comparison));
    if let Some(chart) = by_seconds(comparison) {
        blocks.push(Block::Heading("Curves".into()));
        blocks.push(Block::Charts(vec![chart, by_iteration(comparison)]));
    }
    blocks.push(Block::Heading("The last keyframe".into()));
    blocks.extend(last_keyframe(comparison));
    blocks.push(Block::Heading("On the way".into()));
    for solved in &comparison.solved {
        blocks.push(Block::Part(solved.record.method.name().into()));
        blocks.push(strip(&solved.gallery.strip));
    }
    if let Some(record) = comparison.records().next() {
        blocks.push(Block::Heading("The command and the scene".into()));
        blocks.push(Block::Code(record.command.clone()));
        blocks.push(Block::Code(record.scene.trim_end().into()));
    }
    Document {
        title: format!("{name}, compared"),
        lead: format!(
            "The same scene solved by {}, one after the other in one process.",
            listed(&methods)
        ),
        blocks,
        pictures: true,
    }
}

/// A note as a sentence on a page.
pub(crate) fn said(note: &String) -> Block {
    Block::Text(format!("{note}."))
}

/// What was measured, on what.
fn conditions(record: &RunRecord) -> Vec<Block> {
    let scene = format!(
        "{} cells, {} steps of {}, force weight r = {}, smoothness of the force {}, {} transport, keyframes at step {}.",
        product(&record.cells),
        record.steps,
        number(record.dt),
        number(record.force_weight),
        smoothness(record),
        record.advection.scheme,
        listed(
            &record
                .worst_of_each()
                .map(|keyframe| steps(keyframe.stay))
                .collect::<Vec<_>>()
                .iter()
                .map(String::as_str)
                .collect::<Vec<_>>()
        )
    );
    vec![Block::Text(scene), Block::Text(measured(record))]
}

/// `40`, or `40 to 46`.
fn steps(stay: Stay) -> String {
    if stay.is_held() {
        format!("{} to {}", stay.first, stay.last)
    } else {
        stay.first.to_string()
    }
}

/// Which program on which machine made the figures, and what the columns mean.
pub(crate) fn measured(record: &RunRecord) -> String {
    format!(
        "All figures but those marked as the paper's own were produced by this one run: {}. Seconds count from the first \
         iteration on, coarser grids and ADMM's nested start included, and leave out reading, drawing and writing. \"To 1 %\" is when the objective first came within 1 % of the least that \
         any method of this run ended with; \"to worst end\" is when it came to where the worst of them ended, single passes aside, so that every method that descends has such a time. Objectives on coarser grids are not comparable and not shown.",
        machine(&record.version, &record.precision, record.threads)
    )
}

fn table(rows: &[Figures]) -> Table {
    let mut head = vec!["method"];
    head.extend(COLUMNS);
    let row = |figures: &Figures| {
        let mut row = vec![figures.method.name().to_owned()];
        row.extend(cells(figures));
        row
    };
    Table {
        names: 1,
        ours: head.len(),
        head,
        rows: rows.iter().map(row).collect(),
    }
}

/// What the figures of another simulator are.
fn elsewhere(figures: &Figures) -> Option<Block> {
    let own = figures.own_objective?;
    Some(Block::Text(format!(
        "{}: objective, its parts and the worst keyframe are those of the others: its flow was brought to faces and projected, the smoke carried by that, and the force \
         taken that makes it, from the velocity at the start that was found. On its own grid, by its own price, its objective is {}; curves and pictures are of that.",
        figures.method.name(),
        number(own.total())
    )))
}

/// Notes below the table.
fn notes(comparison: &Comparison) -> Vec<Block> {
    let rows = comparison.figures();
    let mut notes: Vec<Block> = race(&rows).map(Block::Text).into_iter().collect();
    notes.extend(rows.iter().filter_map(elsewhere));
    notes.extend(
        comparison
            .failed
            .iter()
            .map(|Lost { method, why, .. }| Block::Text(format!("{method} came to no result: {why}"))),
    );
    notes.extend(comparison.records().flat_map(|record| {
        let said = |remark: &String| Block::Text(format!("{}: {remark}.", record.method.name()));
        record.remarks.iter().map(said)
    }));
    notes.push(Block::Text(MEMORY.into()));
    notes
}

/// Which method was first at the final objective of the worst one.
fn race(rows: &[Figures]) -> Option<String> {
    let descending = rows
        .iter()
        .filter(|row| row.iterations > 1 && row.own_objective.is_none());
    let worst = descending.max_by(|one, other| one.objective.total().total_cmp(&other.objective.total()))?;
    let mut times: Vec<(&str, f64)> = rows
        .iter()
        .filter_map(|row| Some((row.method.name(), row.seconds_to_worst?)))
        .collect();
    times.sort_by(|one, other| one.1.total_cmp(&other.1));
    let [(first, least), rest @ ..] = times.as_slice() else {
        return None;
    };
    let rest: Vec<String> = rest
        .iter()
        .map(|(name, time)| {
            format!(
                "{name} after {} ({:.1} times as long)",
                seconds(*time),
                time / least
            )
        })
        .collect();
    let others = if rest.is_empty() {
        return None;
    } else {
        rest.join(", ")
    };
    Some(format!(
        "The objective {}, at which {} ended, was reached by {first} after {}, {others}.",
        number(worst.objective.total()),
        worst.method.name(),
        seconds(*least)
    ))
}

/// Curves of the objective over `across`, one for each method.
fn objective(comparison: &Comparison, across: fn(&IterationRecord, usize) -> f64) -> Vec<Curve> {
    let curve = |(index, record): (usize, &RunRecord)| {
        let points = way(record)
            .iter()
            .enumerate()
            .map(|(place, entry)| (across(entry, place), entry.objective.total()));
        Curve::new(record.method.name(), index % 4 + 1, points)
    };
    comparison.records().enumerate().map(curve).collect()
}

/// The objective against seconds, if any method has more than one point.
pub(crate) fn by_seconds(comparison: &Comparison) -> Option<Chart> {
    comparison.records().any(descends).then(|| Chart {
        title: "Objective against time",
        note: "On the scene's own grid; what a method spends on coarser grids before shows as a later beginning.".into(),
        across: "seconds",
        scale: Scale::Logarithmic,
        curves: objective(comparison, |entry, _| entry.seconds),
    })
}

fn by_iteration(comparison: &Comparison) -> Chart {
    Chart {
        title: "Objective by iteration",
        note: "On the scene's own grid.".into(),
        across: "iteration on the finest grid",
        scale: Scale::Counts,
        curves: objective(comparison, |_, place| place as f64 + 1.0),
    }
}

/// The last keyframe, what each method made of it, and by how much that is off.
pub(crate) fn last_keyframe(comparison: &Comparison) -> Vec<Block> {
    let mut shots = Vec::new();
    let mut differences = Vec::new();
    for solved in &comparison.solved {
        let (Some(pictures), Some(facts)) = (
            solved.gallery.keyframes.last(),
            solved.record.worst_of_each().last(),
        ) else {
            continue;
        };
        let held = pictures.stay.is_held();
        let (at_most, at_step) = if held {
            ("at most ", format!(" at step {}", pictures.step))
        } else {
            ("", String::new())
        };
        if shots.is_empty() {
            shots.push(Shot {
                caption: format!("keyframe, {}", pictures.stay),
                png: pictures.target.clone(),
            });
        }
        shots.push(Shot {
            caption: solved.record.method.name().into(),
            png: pictures.reached.clone(),
        });
        differences.push(Shot {
            caption: format!(
                "{}: off by {at_most}{:.1} %{at_step}",
                solved.record.method.name(),
                100.0 * facts.relative_l2
            ),
            png: pictures.difference.clone(),
        });
    }
    vec![Block::Pictures(shots), Block::Pictures(differences)]
}

/// A strip of pictures of some steps, from first to last.
pub(crate) fn strip(pictures: &[(usize, Vec<u8>)]) -> Block {
    Block::Strip(
        pictures
            .iter()
            .map(|(step, png)| Shot {
                caption: format!("step {step}"),
                png: png.clone(),
            })
            .collect(),
    )
}

/// The table of the page, for the terminal.
pub(crate) fn summary(comparison: &Comparison) -> String {
    table(&comparison.figures()).plain()
}
