//! `[source]` and `[[keyframe]]`: the step is checked here, the shape by [`ShapeSpec`].

use crate::exit::Failure;
use crate::keyframes::ShapeSpec;
use crate::scene::check::shown;
use crate::scene::document::Document;
use crate::scene::model::Keyframe;
use crate::scene::raw::read;
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
        let step = match document.required(
            &at,
            table.remove("step"),
            "write the step it stands at, as in step = 40",
        )? {
            Value::Integer(step) => document.whole(&at, step, 2..=steps)?,
            other => {
                return Err(document.outside(
                    &at,
                    shown(&other),
                    format_args!("a whole number from 2 to {steps}"),
                ));
            }
        };
        if let Some(twin) = keyframes.iter().find(|keyframe| keyframe.step == step) {
            let why = format!(
                "is {step}, but `{}` stands at that step already; give each keyframe a step of its own",
                twin.key
            );
            return Err(document.refuse(&at, why));
        }
        let shape = shape(document, &key, table)?;
        keyframes.push(Keyframe { step, shape, key });
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
