//! The page of a sweep: a row and the last step of each run.

use super::runs::Run;
use crate::output::frame;
use crate::report::{Block, Document, Shot, Table, bytes, number, seconds};
use serde_json::{Value, json};
use std::fs;

/// What the page says of a run with this report, or why it has none where it came to nothing.
pub(super) fn facts(run: &Run, report: Option<&Value>, why: Option<&String>) -> Value {
    let report = report.cloned().unwrap_or_default();
    let errors = report["keyframes"].as_array().into_iter().flatten();
    let worst = errors
        .filter_map(|keyframe| keyframe["relative_l2"].as_f64())
        .reduce(f64::max);
    json!({
        "set": run.set,
        "folder": run.folder.file_name().unwrap_or_default().to_string_lossy(),
        "status": report["status"],
        "why": why,
        "iterations": report["history"].as_array().map(Vec::len),
        "seconds": report["seconds"]["total"],
        "objective": report["objective"],
        "keyframe_error": worst,
        "planned_bytes": report["memory"]["planned_bytes"],
    })
}

/// A row for each of the runs, of which these are the facts.
pub(super) fn table(runs: &[Run], facts: &[Value]) -> Table {
    let row = |(run, facts): (&Run, &Value)| {
        let none = || "\u{2013}".to_owned();
        let real = |value: &Value| value.as_f64().map_or_else(none, number);
        vec![
            run.set.join(" "),
            match (&facts["status"], &facts["why"]) {
                (Value::String(status), _) => status.replace('_', " "),
                (_, Value::String(_)) => "failed".into(),
                _ => "not there yet".into(),
            },
            facts["iterations"]
                .as_u64()
                .map_or_else(none, |count| count.to_string()),
            facts["seconds"].as_f64().map_or_else(none, seconds),
            real(&facts["objective"]["total"]),
            real(&facts["objective"]["data"]),
            real(&facts["objective"]["force"]),
            facts["keyframe_error"]
                .as_f64()
                .map_or_else(none, |error| format!("{:.1} %", 100.0 * error)),
            facts["planned_bytes"]
                .as_u64()
                .map_or_else(none, |count| bytes(usize::try_from(count).unwrap_or(usize::MAX))),
        ]
    };
    let head = vec![
        "run",
        "ended",
        "iterations",
        "time",
        "objective",
        "keyframes",
        "force",
        "worst keyframe",
        "memory",
    ];
    Table {
        names: 1,
        ours: head.len(),
        head,
        rows: runs.iter().zip(facts).map(row).collect(),
    }
}

/// The page: the table, of which these are the facts, and pictures of the `reports`.
pub(super) fn document(
    (name, vary): (&str, &[String]),
    runs: &[Run],
    (table, facts): (Table, &[Value]),
    reports: &[Option<Value>],
) -> Document {
    let last = |(run, report): (&Run, &Option<Value>)| {
        let steps = report.as_ref()?["steps"].as_u64()?;
        let png = fs::read(run.folder.join(frame(usize::try_from(steps).ok()?))).ok()?;
        Some(Shot {
            caption: run.set.join(" "),
            png,
        })
    };
    let why = |(run, facts): (&Run, &Value)| {
        let why = facts["why"].as_str()?;
        Some(Block::Text(format!(
            "{} came to no result: {why}",
            run.set.join(" ")
        )))
    };
    let mut blocks = vec![Block::Table(table)];
    blocks.extend(runs.iter().zip(facts).filter_map(why));
    let shots: Vec<Shot> = runs.iter().zip(reports).filter_map(last).collect();
    if !shots.is_empty() {
        blocks.push(Block::Heading("The last step".into()));
        blocks.push(Block::Pictures(shots));
    }
    Document {
        title: format!("{name}, varied"),
        lead: format!(
            "The same scene with every combination of {}. Each run has a folder of its own with all that a solve writes.",
            vary.join(" and ")
        ),
        blocks,
        pictures: true,
    }
}
