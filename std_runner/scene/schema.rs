//! The JSON schema of a scene, by which editors complete and check it.

use super::keys;
use super::method::{section, steering};
use super::raw::RawScene;
use schemars::generate::SchemaSettings;
use serde_json::{Map, Value, json};
use thurible_core::choices::{self, Choice, Choices, Kind, Numbers};
use thurible_core::problem::MAX_STEPS;
use thurible_core::solver::MAX_ITERATIONS;
use thurible_core::{Method, Named, Params, stable_fluids};

/// The schema, of draft 7, which editors of TOML know best.
#[must_use]
pub fn schema() -> Value {
    let generator = SchemaSettings::draft07().into_generator();
    let mut root = generator.into_root_schema_for::<RawScene>().to_value();
    root["title"] = "A scene for thurible".into();
    root["required"] = json!(["grid", "time"]);
    // All other keys have defaults, or may be missing where others are there.
    if let Some(Value::Object(parts)) = root.get_mut("definitions") {
        for (name, part) in parts.iter_mut().filter(|(name, _)| name.starts_with("Raw")) {
            match name.as_str() {
                "RawGrid" => part["required"] = json!(["cells"]),
                "RawTime" => part["required"] = json!(["steps"]),
                _ => drop(part.as_object_mut().and_then(|part| part.remove("required"))),
            }
        }
    }
    if let Some(Value::Object(sections)) = root.get_mut("properties") {
        for (name, table) in tables() {
            sections.insert(name, table);
        }
    }
    keys::annotate(&mut root);
    root
}

/// `[method]`, and the sections of choices that concern several methods.
fn tables() -> Map<String, Value> {
    let names: Vec<&str> = steering()
        .into_iter()
        .map(Named::name)
        .chain([stable_fluids::NAME])
        .collect();
    let mut method = json!({
        "name": { "description": "How it is solved.", "enum": names },
        "iterations": whole("At most, on the finest grid.", 1, MAX_ITERATIONS),
        "window": whole("So many steps at a time.", 2, MAX_STEPS),
        "stride": whole("How many steps later the next window begins.", 1, MAX_STEPS),
        "projection": said("Projections onto flows free of divergence, in every method.",
            object(json!({ "tolerance": said("What a projection may leave of the divergence.", number(Numbers::Below(1.0))) })))
    });
    let mut tables = Map::new();
    let params = Params::default();
    for &of in Method::ALL {
        let choices = params.choices(of);
        let words = format!("Choices of {}.", of.name());
        let table = said(&words, object(Value::Object(entries(choices))));
        match section(of).strip_prefix("method.") {
            Some(name) => method[name] = table,
            None if choices.table().is_empty() => {}
            None => drop(tables.insert(section(of), said("Choices that concern several methods.", table))),
        }
    }
    method[stable_fluids::NAME] = said(&format!("Choices of {}.", stable_fluids::NAME), fluids());
    tables.insert("method".into(), said("How it is solved.", object(method)));
    tables
}

/// `[method.stable_fluids]`.
fn fluids() -> Value {
    let mut table = entries(&stable_fluids::FluidsParams::default());
    let words: Vec<&str> = stable_fluids::Control::ALL
        .iter()
        .map(|control| control.name())
        .collect();
    table.insert("control".into(), json!({ "description": "What is searched for.", "type": "array", "minItems": 1, "items": { "enum": words } }));
    table.insert("slots".into(), json!({ "description": "States that are kept; 0 keeps all of a gradient.", "anyOf": [{ "const": "auto" }, whole("", 0, MAX_STEPS)] }));
    object(Value::Object(table))
}

fn object(properties: Value) -> Value {
    json!({ "type": "object", "additionalProperties": false, "properties": properties })
}

/// The same with a description.
fn said(words: &str, mut schema: Value) -> Value {
    schema["description"] = words.into();
    schema
}

fn whole(words: &str, least: usize, most: usize) -> Value {
    json!({ "description": words, "type": "integer", "minimum": least, "maximum": most })
}

fn number(numbers: Numbers) -> Value {
    match numbers {
        Numbers::Finite => json!({ "type": "number" }),
        Numbers::Positive => json!({ "type": "number", "exclusiveMinimum": 0 }),
        Numbers::NotNegative => json!({ "type": "number", "minimum": 0 }),
        Numbers::Fraction => json!({ "type": "number", "minimum": 0, "exclusiveMaximum": 1 }),
        Numbers::Below(limit) | Numbers::Within(limit) => {
            json!({ "type": "number", "exclusiveMinimum": 0, "exclusiveMaximum": limit })
        }
        Numbers::UpTo(most) => json!({ "type": "number", "minimum": 0, "maximum": most }),
    }
}

/// A table of choices, each with its default.
fn entries(choices: &dyn Choices) -> Map<String, Value> {
    let table = choices.table().iter().enumerate();
    table
        .map(|(index, choice)| (choice.name.to_owned(), entry(choice, choices.get(index))))
        .collect()
}

/// A line of a table of choices.
fn entry(choice: &Choice, standard: Option<choices::Value<'_>>) -> Value {
    let mut entry = match choice.kind {
        Kind::Number(numbers) => number(numbers),
        Kind::Count(most) => whole("", 1, most),
        Kind::Automatic(most) => json!({ "anyOf": [{ "const": "auto" }, whole("", 1, most)] }),
        Kind::Flag => json!({ "type": "boolean" }),
        Kind::Word(words) => json!({ "enum": words }),
    };
    entry["description"] = format!("{}: {}", choice.words, choice.kind).into();
    entry["default"] = match standard {
        None => return entry,
        Some(choices::Value::Number(number)) => number.into(),
        Some(choices::Value::Count(count)) => count.into(),
        Some(choices::Value::Automatic) => "auto".into(),
        Some(choices::Value::Flag(flag)) => flag.into(),
        Some(choices::Value::Word(word)) => word.into(),
    };
    entry
}
