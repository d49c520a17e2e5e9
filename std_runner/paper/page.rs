//! The page of the paper's scenes.

use super::catalogue::Entry;
use super::sections::{Content, GROUPS, SECTIONS, Section};
use super::tables::{SolvedScene, beside, quoted_from, table};
use super::verdict;
use crate::compare::{self, Lost};
use crate::quoted::Scale;
use crate::report::{Block, Chart, Curve, Document, RunRecord};

/// The page about what has been solved so far.
pub(crate) fn page(sections: &[&Section], solved: &[SolvedScene], scale: Scale) -> Document {
    let mut blocks = Vec::new();
    if let Some(record) = solved.iter().flat_map(|scene| scene.comparison.records()).next() {
        blocks.push(Block::Text(compare::measured(record)));
        blocks.push(Block::Code(record.command.clone()));
    }
    // All scenes have the transport that --set gave, or none was changed.
    let mut notes = solved.iter().filter_map(|scene| scene.comparison.note.as_ref());
    blocks.extend(notes.next().map(compare::said));
    blocks.extend([
        Block::Table(table(solved)),
        Block::Text(verdict::RULE.into()),
        Block::Text(compare::MEMORY.into()),
    ]);
    let rows: Vec<&SolvedScene> = solved.iter().filter(|scene| in_table(scene.entry)).collect();
    if !rows.is_empty() {
        blocks.extend([
            Block::Heading("Beside the paper's Table 2".into()),
            Block::Table(beside(&rows)),
            Block::Text(quoted_from(scale)),
        ]);
    }
    for section in sections {
        blocks.push(Block::Heading(section.title.into()));
        blocks.push(Block::Text(section.text.into()));
        let own: Vec<&SolvedScene> = section
            .members()
            .filter_map(|entry| solved.iter().find(|scene| scene.entry.name == entry.name))
            .collect();
        if own.is_empty() {
            blocks.push(Block::Text(absent(section)));
        } else {
            blocks.extend(blocks_of(section, &own));
        }
    }
    let size = if scale.name() == "1" {
        "at full size".to_owned()
    } else {
        format!("at {} of the cells along each axis, with all steps", scale.name())
    };
    Document {
        title: "The paper's scenes".into(),
        lead: format!("Scenes of Pan & Manocha, solved {size}, beside what the paper says of its own."),
        blocks,
        pictures: true,
    }
}

fn absent(section: &Section) -> String {
    match section.only() {
        [] => "Not run: the run was stopped before.".into(),
        methods => format!(
            "Not run: it is about {}, which --methods did not name, or the run was stopped before.",
            compare::listed(methods)
        ),
    }
}

/// Whether a row of the paper's Table 2 is about the scene.
fn in_table(entry: &Entry) -> bool {
    let table = GROUPS[0].1;
    SECTIONS
        .iter()
        .any(|section| table.contains(&section.name) && section.entries.contains(&entry.name))
}

fn blocks_of(section: &Section, solved: &[&SolvedScene]) -> Vec<Block> {
    let mut charts = match section.content {
        Content::Cycles => cycles(solved).into_iter().collect(),
        Content::Optimality => solved
            .iter()
            .flat_map(|scene| scene.comparison.records())
            .flat_map(|record| [optimality(record), fixed_point(record)])
            .collect(),
        Content::Results | Content::Steps => Vec::new(),
    };
    charts.extend(solved.iter().filter_map(|scene| {
        Some(Chart {
            title: scene.entry.about,
            ..compare::by_seconds(&scene.comparison)?
        })
    }));
    let mut blocks = vec![Block::Charts(charts)];
    for scene in solved {
        blocks.push(Block::Part(scene.entry.about.into()));
        blocks.extend(scene.comparison.failed.iter().map(|Lost { method, why, .. }| {
            Block::Text(format!(
                "{}: {method} came to no result: {why}",
                scene.entry.about
            ))
        }));
        blocks.extend(compare::last_keyframe(&scene.comparison));
        if section.content == Content::Steps
            && let Some(solved) = scene.comparison.solved.first()
        {
            blocks.push(Block::Part(format!(
                "{}, steps by {}",
                scene.entry.about,
                solved.record.method.name()
            )));
            blocks.push(compare::strip(&solved.gallery.strip));
        }
    }
    blocks
}

/// Residuals of the first Navier-Stokes problem of each entry, if ADMM has solved any.
fn cycles(solved: &[&SolvedScene]) -> Option<Chart> {
    let first = |record: &RunRecord| {
        let residuals = record.history.first()?.facts.series("nso_residuals");
        (!residuals.is_empty()).then(|| residuals.to_vec())
    };
    let residuals: Vec<_> = solved
        .iter()
        .filter_map(|scene| Some((scene.entry.about, scene.comparison.records().find_map(first)?)))
        .collect();
    let curve = |(index, (name, residuals)): (usize, (&str, Vec<f64>))| {
        Curve::new(
            name,
            index % 4 + 1,
            residuals
                .into_iter()
                .enumerate()
                .map(|(cycle, residual)| (cycle as f64, residual)),
        )
    };
    (!residuals.is_empty()).then(|| Chart {
        title: "First Navier\u{2013}Stokes problem",
        note: "Residual max |f| before the first V-cycle and after each.".into(),
        across: "V-cycle",
        scale: crate::report::Scale::Counts,
        curves: residuals.into_iter().enumerate().map(curve).collect(),
    })
}

/// The paper's Figure 7, left: the whole problem by iteration of ADMM.
fn optimality(record: &RunRecord) -> Chart {
    let curve = |name: &str, colour, fact: &str| {
        let points = record
            .history
            .iter()
            .filter_map(|entry| Some((entry.iteration as f64, entry.facts.get(fact)?)));
        Curve::new(name, colour, points)
    };
    Chart {
        title: "Optimality",
        note: "Largest violation of the optimality conditions, and the residual of the advection problem's fixed point.".into(),
        across: "iteration of ADMM",
        scale: crate::report::Scale::Counts,
        curves: vec![
            curve("KKT", 3, "kkt"),
            curve("advection problem", 1, "ao_residuals"),
        ],
    }
}

/// The paper's Figure 7, right: the advection problem by fixed-point iteration, in the first iterations of ADMM.
fn fixed_point(record: &RunRecord) -> Chart {
    let curve = |(index, residuals): (usize, &[f64])| {
        let points = residuals
            .iter()
            .enumerate()
            .map(|(iteration, &residual)| ((iteration + 1) as f64, residual));
        Curve::new(format!("ADMM {}", index + 1), index % 4 + 1, points)
    };
    Chart {
        title: "The advection problem",
        note: "Residual of its fixed point in each of its iterations, within iterations 1, 2 and 3 of ADMM."
            .into(),
        across: "fixed-point iteration",
        scale: crate::report::Scale::Counts,
        curves: record
            .history
            .iter()
            .map(|entry| entry.facts.series("ao_residuals"))
            .filter(|residuals| !residuals.is_empty())
            .take(3)
            .enumerate()
            .map(curve)
            .collect(),
    }
}
