//! The page: iterations of every case by every variant, energy and residual on the way, the deformed mesh.

use super::cases::{Case, Variant};
use super::draw::draw;
use super::job::{Outcome, status_word};
use super::written::record;
use crate::output::OutputError;
use crate::report::{Block, Chart, Curve, Document, Scale, Shot, Table, bytes, number, seconds};
use serde_json::{Value, json};
use std::path::Path;
use thurible_core::Status;

/// Step counts that a row of the table shows.
const SHOWN: usize = 12;
/// Colours of curves.
const COLOURS: usize = 4;

/// A case with what its variants came to.
pub(super) struct Done<'a> {
    pub case: &'a Case,
    pub outcomes: Vec<Outcome>,
}

/// The facts of the page.
pub(super) fn facts(done: &[Done<'_>]) -> Value {
    let runs = done.iter().flat_map(|done| {
        let pairs = done.case.variants.iter().zip(&done.outcomes);
        pairs.map(|(variant, outcome)| {
            let mut fields = record(done.case, variant, outcome);
            if let Some(fields) = fields.as_object_mut() {
                ["scene", "command", "memory"]
                    .iter()
                    .for_each(|key| drop(fields.remove(*key)));
                fields.insert("planned_bytes".into(), outcome.planned.into());
            }
            fields
        })
    });
    json!({ "format": 1, "kind": "condense", "version": env!("CARGO_PKG_VERSION"), "runs": runs.collect::<Vec<_>>() })
}

/// The table: a row for each case and variant.
pub(super) fn table(done: &[Done<'_>]) -> Table {
    let swept = done.len() > 1;
    let mut rows = Vec::new();
    for Done { case, outcomes } in done {
        for (index, (variant, outcome)) in case.variants.iter().zip(outcomes).enumerate() {
            let mut row = if index == 0 {
                vec![case.label.clone()]
            } else {
                vec![String::new()]
            };
            if !swept {
                row.clear();
            }
            row.extend([
                variant.name.clone(),
                counts(outcome),
                outcome.builds.iter().sum::<usize>().to_string(),
                ended(outcome),
                outcome
                    .energy
                    .last()
                    .map_or_else(String::new, |&value| energy(value)),
                seconds(outcome.total),
                bytes(outcome.planned),
            ]);
            rows.push(row);
        }
    }
    let mut head = vec!["problem"];
    if !swept {
        head.clear();
    }
    head.extend([
        "method",
        "iterations",
        "builds",
        "ended",
        "energy",
        "seconds",
        "memory",
    ]);
    Table {
        names: if swept { 2 } else { 1 },
        ours: head.len(),
        head,
        rows,
    }
}

/// `17 = 5, 5, 7`.
fn counts(outcome: &Outcome) -> String {
    let sum: usize = outcome.iterations.iter().sum();
    if outcome.iterations.len() < 2 {
        return sum.to_string();
    }
    let each: Vec<String> = outcome
        .iterations
        .iter()
        .take(SHOWN)
        .map(usize::to_string)
        .collect();
    let more = if outcome.iterations.len() > SHOWN {
        ", .."
    } else {
        ""
    };
    format!("{sum} = {}{more}", each.join(", "))
}

fn ended(outcome: &Outcome) -> String {
    let word = status_word(outcome.status).replace('_', " ");
    if outcome.status == Status::Converged {
        return word;
    }
    format!("{word}, step {}", outcome.ended_in)
}

/// The page of a scene.
pub(super) fn page(name: &str, done: &[Done<'_>]) -> Result<Document, OutputError> {
    let mut blocks = vec![Block::Table(table(done))];
    blocks.push(Block::Text(
        "Iterations in all and of each step, the rest of the steps left out where a step ended otherwise than converged; how often the basis, or the factor of its Hessian, was built; the energy at the end.".into(),
    ));
    for Done { case, outcomes } in done {
        if !case.label.is_empty() {
            blocks.push(Block::Heading(case.label.clone()));
        }
        blocks.push(Block::Charts(charts(case, outcomes)));
        let shots = shots(case, outcomes)?;
        if !shots.is_empty() {
            blocks.push(Block::Pictures(shots));
        }
    }
    let mesh = done.first().map(|done| &done.case.problem.mesh);
    let lead = mesh.map_or_else(String::new, |mesh| {
        let kind = ["", "springs in a row", "triangles", "tetrahedra"].get(mesh.dims).copied().unwrap_or_default();
        format!(
            "Coordinate condensation and what it is measured by, on {kind}; Young's modulus {} and Poisson's ratio {} in the first problem.",
            number(mesh.material.young),
            number(mesh.material.poisson)
        )
    });
    Ok(Document {
        title: format!("Condensation: {name}"),
        lead,
        blocks,
        pictures: true,
    })
}

/// Where each step begins in the lists of states, and ends.
fn steps(outcome: &Outcome) -> impl Iterator<Item = core::ops::Range<usize>> {
    let mut begin = 0;
    outcome.iterations.iter().map(move |count| {
        let range = begin..begin + count + 1;
        begin = range.end;
        range
    })
}

/// The least energy that any variant found in each step.
fn least(outcomes: &[Outcome]) -> Vec<f64> {
    let mut least: Vec<f64> = Vec::new();
    for outcome in outcomes {
        for (index, range) in steps(outcome).enumerate() {
            let found = outcome
                .energy
                .get(range)
                .unwrap_or(&[])
                .iter()
                .copied()
                .fold(f64::INFINITY, f64::min);
            match least.get_mut(index) {
                Some(least) => *least = least.min(found),
                None => least.push(found),
            }
        }
    }
    least
}

/// Charts of a few variants each, so that every curve has its colour.
fn charts(case: &Case, outcomes: &[Outcome]) -> Vec<Chart> {
    let least = least(outcomes);
    let few = case.variants.chunks(COLOURS).zip(outcomes.chunks(COLOURS));
    few.flat_map(|(variants, outcomes)| charts_of(variants, outcomes, &least))
        .collect()
}

/// An energy in digits that tell those of two methods apart.
fn energy(value: f64) -> String {
    let plain = value == 0.0 || (1e-2..1e6).contains(&value.abs());
    if plain {
        format!("{value:.6}")
    } else {
        format!("{value:.6e}")
    }
}

/// A number of a state: of a run, the step and the place in its lists.
type Number<'a> = &'a dyn Fn(&Outcome, usize, usize) -> f64;

fn curves(variants: &[Variant], outcomes: &[Outcome], across: Number<'_>, value: Number<'_>) -> Vec<Curve> {
    let curve = |(index, (variant, outcome)): (usize, (&Variant, &Outcome))| Curve {
        name: variant.name.clone(),
        colour: index + 1,
        pieces: steps(outcome)
            .enumerate()
            .map(|(step, range)| {
                range
                    .map(|at| (across(outcome, step, at), value(outcome, step, at)))
                    .collect()
            })
            .collect(),
    };
    variants.iter().zip(outcomes).enumerate().map(curve).collect()
}

fn charts_of(variants: &[Variant], outcomes: &[Outcome], least: &[f64]) -> [Chart; 4] {
    // A step has one state more than iterations.
    let iteration = |_: &Outcome, step: usize, at: usize| (at - step) as f64;
    let second = |outcome: &Outcome, _: usize, at: usize| outcome.at.get(at).copied().unwrap_or_default();
    let energy = |outcome: &Outcome, step: usize, at: usize| {
        outcome.energy.get(at).copied().unwrap_or_default() - least.get(step).copied().unwrap_or_default()
    };
    let residual =
        |outcome: &Outcome, _: usize, at: usize| outcome.residual.get(at).copied().unwrap_or_default();
    let above = "Above the least energy that any of them found in the step. Each piece is a step.";
    let left = "What is compared with the tolerance. Each piece is a step.";
    let chart = |title, note: &str, across: (&'static str, Number<'_>), value: Number<'_>| Chart {
        title,
        note: note.into(),
        across: across.0,
        scale: Scale::Counts,
        curves: curves(variants, outcomes, across.1, value),
    };
    [
        chart("Energy", above, ("iteration", &iteration), &energy),
        chart("Energy in time", above, ("seconds", &second), &energy),
        chart("Residual", left, ("iteration", &iteration), &residual),
        chart("Residual in time", left, ("seconds", &second), &residual),
    ]
}

/// The last state of each variant, in one frame.
fn shots(case: &Case, outcomes: &[Outcome]) -> Result<Vec<Shot>, OutputError> {
    let mesh = &case.problem.mesh;
    let states = outcomes.iter().map(|outcome| outcome.position.as_slice());
    let mut frames: Vec<&[f64]> = states.clone().collect();
    frames.push(&mesh.rest);
    let finite = frames
        .iter()
        .all(|frame| frame.iter().all(|x| x.is_finite() && x.abs() < 1e6));
    let mut shots = Vec::new();
    for ((variant, outcome), state) in case.variants.iter().zip(outcomes).zip(states) {
        if let Some(picture) = finite.then(|| draw(mesh, &frames, state)).flatten() {
            let png = picture
                .to_png()
                .map_err(OutputError::of(Path::new("condense.html")))?;
            let caption = format!(
                "{} after step {}, {}",
                variant.name,
                outcome.iterations.len(),
                ended(outcome)
            );
            shots.push(Shot { caption, png });
        }
    }
    Ok(shots)
}
