//! `[source]` and `[[keyframe]]`: the step is checked here, the shape by [`ShapeSpec`].

use crate::exit::Failure;
use crate::keyframes::ShapeSpec;
use crate::scene::check::shown;
use crate::scene::document::Document;
use crate::scene::model::Keyframe;
use crate::scene::raw::read;
use core::ops::RangeInclusive;
use toml::{Table, Value};

pub(super) fn source(document: &Document, raw: Option<Table>) -> Result<ShapeSpec, Failure> {
    let table = document.required(
        "source",
        raw,
        "write [source] with a shape, as in circle = { center = [0.5, 0.5], radius = 0.2 }",
    )?;
    shape(document, "source", table)
}

pub(super) fn keyframes(
    document: &Document,
    raw: Option<Vec<Table>>,
    steps: usize,
) -> Result<Vec<Keyframe>, Failure> {
    let remedy = "write [[keyframe]] with a step and a shape, as in step = 40 and text = \"F\"";
    let tables = document.required("keyframe", raw.filter(|tables| !tables.is_empty()), remedy)?;
    let mut keyframes: Vec<Keyframe> = Vec::new();
    for (index, mut table) in tables.into_iter().enumerate() {
        let key = format!("keyframe[{index}]");
        let at = format!("{key}.step");
        let remedy = "write the step it stands at, as in step = 40";
        let step = document.required(&at, table.remove("step"), remedy)?;
        let step = whole(document, &at, step, 2..=steps)?;
        let hold = match table.remove("hold") {
            None => 0,
            Some(hold) => whole(document, &format!("{key}.hold"), hold, 0..=steps - step)?,
        };
        let shape = shape(document, &key, table)?;
        for step in step..=step + hold {
            if let Some(twin) = keyframes.iter().find(|keyframe| keyframe.step == step) {
                return Err(document.refuse(&at, twice(step, hold, twin)));
            }
            let (shape, key) = (shape.clone(), key.clone());
            keyframes.push(Keyframe { step, shape, key });
        }
    }
    keyframes.sort_by_key(|keyframe| keyframe.step);
    Ok(keyframes)
}

fn shape(document: &Document, key: &str, table: Table) -> Result<ShapeSpec, Failure> {
    refuse_what_is_to_come(document, key, &table)?;
    read(document, key, Value::Table(table))
}

/// Says of the shapes that a later version will read that this one does not.
fn refuse_what_is_to_come(document: &Document, key: &str, table: &Table) -> Result<(), Failure> {
    if table.contains_key("mesh") {
        let why = "is not there yet; for now use box, sphere, torus, capsule, text or file = \"x.npy\"";
        return Err(document.refuse(&format!("{key}.mesh"), why));
    }
    if let Some(Value::String(file)) = table.get("file")
        && file.to_ascii_lowercase().ends_with(".vdb")
    {
        let why = format!("is \"{file}\", but OpenVDB files cannot be read yet; convert it to .npy or .npz");
        return Err(document.refuse(&format!("{key}.file"), why));
    }
    if let Some(Value::Array(parts)) = table.get("shapes") {
        for (index, part) in parts.iter().enumerate() {
            if let Value::Table(part) = part {
                refuse_what_is_to_come(document, &format!("{key}.shapes[{index}]"), part)?;
            }
        }
    }
    Ok(())
}

/// A whole number in a range.
fn whole(
    document: &Document,
    key: &str,
    value: Value,
    allowed: RangeInclusive<usize>,
) -> Result<usize, Failure> {
    match value {
        Value::Integer(number) => document.whole(key, number, allowed),
        other => {
            let wanted = format!("a whole number from {} to {}", allowed.start(), allowed.end());
            Err(document.outside(key, shown(&other), wanted))
        }
    }
}

/// Why a keyframe cannot stand at `step`, where `twin` does.
fn twice(step: usize, hold: usize, twin: &Keyframe) -> String {
    let held = if hold > 0 { " with its `hold`" } else { "" };
    format!(
        "is {step}{held}, but `{}` stands at that step already; give each keyframe steps of its own",
        twin.key
    )
}
