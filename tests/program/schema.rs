//! The JSON schema of scenes: every example and what `thurible new` writes fulfil it, and what is wrong does not.

use super::support::{fresh_folder, run};
use serde_json::Value;
use std::fs;
use std::path::Path;

/// Why `value` does not fulfil `schema`, a part of `root`; keywords that are not known here are a mistake of the test.
fn wrong(root: &Value, schema: &Value, value: &Value, at: &str) -> Option<String> {
    if schema == &Value::Bool(true) {
        return None;
    }
    let number = |key: &str| schema.get(key).and_then(Value::as_f64);
    for (keyword, held) in schema.as_object().unwrap_or_else(|| panic!("{at}: {schema}")) {
        let found = match keyword.as_str() {
            "$ref" => {
                let place = held.as_str().unwrap().strip_prefix('#').unwrap();
                wrong(root, root.pointer(place).unwrap(), value, at)
            }
            "anyOf" => {
                let why: Vec<_> = held
                    .as_array()
                    .unwrap()
                    .iter()
                    .map(|one| wrong(root, one, value, at))
                    .collect();
                why.iter()
                    .all(Option::is_some)
                    .then(|| format!("{at}: none of {why:?}"))
            }
            "allOf" => held
                .as_array()
                .unwrap()
                .iter()
                .find_map(|one| wrong(root, one, value, at)),
            "enum" => (!held.as_array().unwrap().contains(value))
                .then(|| format!("{at}: {value} is none of {held}")),
            "const" => (held != value).then(|| format!("{at}: {value} is not {held}")),
            "type" => {
                let is = |kind: &str| match kind {
                    "object" => value.is_object(),
                    "array" => value.is_array(),
                    "string" => value.is_string(),
                    "boolean" => value.is_boolean(),
                    "null" => value.is_null(),
                    "integer" => value.is_i64() || value.is_u64(),
                    "number" => value.is_number(),
                    other => panic!("{other}"),
                };
                let kinds = held.as_array().cloned().unwrap_or_else(|| vec![held.clone()]);
                (!kinds.iter().any(|kind| is(kind.as_str().unwrap())))
                    .then(|| format!("{at}: {value} is no {held}"))
            }
            "minimum" => value
                .as_f64()
                .filter(|x| *x < number("minimum").unwrap())
                .map(|x| format!("{at}: {x}")),
            "maximum" => value
                .as_f64()
                .filter(|x| *x > number("maximum").unwrap())
                .map(|x| format!("{at}: {x}")),
            "exclusiveMinimum" => value
                .as_f64()
                .filter(|x| *x <= held.as_f64().unwrap())
                .map(|x| format!("{at}: {x}")),
            "exclusiveMaximum" => value
                .as_f64()
                .filter(|x| *x >= held.as_f64().unwrap())
                .map(|x| format!("{at}: {x}")),
            "minItems" => value
                .as_array()
                .filter(|items| items.len() < number("minItems").unwrap() as usize)
                .map(|_| at.into()),
            "maxItems" => value
                .as_array()
                .filter(|items| items.len() > number("maxItems").unwrap() as usize)
                .map(|_| at.into()),
            "items" => value.as_array().and_then(|items| {
                let mut items = items.iter().enumerate();
                items.find_map(|(index, item)| wrong(root, held, item, &format!("{at}[{index}]")))
            }),
            "required" => value.as_object().and_then(|table| {
                let missing = held
                    .as_array()
                    .unwrap()
                    .iter()
                    .find(|key| !table.contains_key(key.as_str().unwrap()));
                missing.map(|key| format!("{at}: no {key}"))
            }),
            "properties" => value.as_object().and_then(|table| {
                let keys = held.as_object().unwrap();
                table
                    .iter()
                    .find_map(|(key, value)| wrong(root, keys.get(key)?, value, &format!("{at}.{key}")))
            }),
            "additionalProperties" => {
                assert_eq!(held, &Value::Bool(false));
                let keys = &schema["properties"];
                let mut table = value.as_object().into_iter().flatten();
                table
                    .find(|(key, _)| keys.get(key).is_none())
                    .map(|(key, _)| format!("{at}: there is no {key}"))
            }
            "$schema" | "title" | "description" | "default" | "format" | "definitions" | "x-default"
            | "x-unit" => None,
            other => panic!("{at}: the keyword {other} is not known to this test"),
        };
        if found.is_some() {
            return found;
        }
    }
    None
}

fn schema() -> Value {
    let ended = run(&["schema"]);
    assert_eq!(ended.code, 0, "{}", ended.err);
    serde_json::from_str(&ended.out).unwrap()
}

fn check(schema: &Value, text: &str) -> Option<String> {
    let scene: toml::Table = toml::from_str(text).unwrap();
    wrong(schema, schema, &serde_json::to_value(scene).unwrap(), "scene")
}

#[test]
fn every_example_and_the_scene_of_new_fulfil_the_schema() {
    let (schema, root) = (schema(), Path::new(env!("CARGO_MANIFEST_DIR")));
    let mut count = 0;
    for folder in ["examples", "examples/effects"] {
        for entry in fs::read_dir(root.join(folder)).unwrap() {
            let path = entry.unwrap().path();
            if path.extension().is_some_and(|end| end == "toml") {
                let found = check(&schema, &fs::read_to_string(&path).unwrap());
                assert_eq!(found, None, "{}", path.display());
                count += 1;
            }
        }
    }
    assert!(count > 20, "{count}");
    let folder = fresh_folder("schema_new");
    let name = folder.join("mine");
    assert_eq!(run(&["new", name.to_str().unwrap(), "--quiet"]).code, 0);
    let text = fs::read_to_string(folder.join("mine.toml")).unwrap();
    assert_eq!(check(&schema, &text), None);
    // What stands behind # are examples of keys.
    let keys = ["steps = ", "box = ", "image = ", "weight = "];
    for line in text
        .lines()
        .filter_map(|line| line.strip_prefix("# "))
        .filter(|line| keys.iter().any(|key| line.starts_with(key)))
    {
        let line = line.split(" # ").next().unwrap();
        let found = check(
            &schema,
            &format!("[grid]\ncells = [8, 8]\n[time]\nsteps = 4\n[[keyframe]]\n{line}\n"),
        );
        assert_eq!(found, None, "{line}");
    }
}

#[test]
fn what_is_wrong_does_not_fulfil_the_schema() {
    let schema = schema();
    let head = "[grid]\ncells = [8, 8]\n[time]\nsteps = 4\n";
    assert_eq!(check(&schema, head), None);
    for wrong in [
        "[source]\ncircle = { center = [0.5, 0.5], radios = 0.2 }",
        "[source]\nimage = \"a.png\"\nink = \"bright\"",
        "[source]\nmesh = \"a.obj\"\nfit = { middle = [0, 0, 0] }",
        "[source]\nshapes = [{ text = 5 }]",
        "[[keyframe]]\nstep = 0\ntext = \"F\"",
        "[[keyframe]]\nsteps = { from = 2 }\nfiles = \"a_*.obj\"",
        "[[keyframe]]\nstep = 2\nregion = { box = { min = [0, 0] } }",
        "[[emitter]]\nrate = 0\ntext = \"F\"",
        "[[template]]\nkind = \"storm\"\ncenter = [0.5, 0.5]\nradius = 0.1",
        "[method]\nname = \"newton\"",
        "[method.direct]\nhistory = 0",
        "[control]\nsmoothness = \"much\"",
        "[gird]\ncells = [8, 8]",
    ] {
        assert!(check(&schema, &format!("{head}{wrong}\n")).is_some(), "{wrong}");
    }
}
