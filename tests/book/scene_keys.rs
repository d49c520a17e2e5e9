//! docs/scene_keys.md, which is made of the schema.

use super::{resolved, root as project, schema};
use core::fmt::Write;
use serde_json::Value;
use std::fs;

const HEAD: &str = "# Every key of a scene

Made of the schema that `thurible schema` prints, by `THURIBLE_WRITE_DOCS=1 cargo test --test book`; `cargo test` fails where it is not
current. A scene is a TOML file; `thurible new NAME` writes one with comments, [effects](effects.md), [shapes](shapes.md) and
[methods](methods.md) say more. `--set control.force_weight=1e2` changes a key for one run. Keys in *italics* must be there.

Lengths are in the unit of `grid.length`, times in that of `time.dt`; steps are counted from 0.
";

/// The tables in the order in which one writes a scene; others follow.
const ORDER: [&str; 14] = [
    "grid",
    "time",
    "source",
    "keyframe",
    "emitter",
    "obstacle",
    "release",
    "template",
    "control",
    "flow",
    "advection",
    "method",
    "simulation",
    "output",
];

fn number(schema: &Value, what: &str) -> String {
    let at = |key: &str| schema.get(key).and_then(Value::as_f64);
    match [
        at("minimum"),
        at("maximum"),
        at("exclusiveMinimum"),
        at("exclusiveMaximum"),
    ] {
        [Some(least), Some(most), ..] => format!("{what} from {least} to {most}"),
        [Some(least), .., Some(below)] => format!("{what} from {least}, below {below}"),
        [Some(least), ..] => format!("{what} from {least}"),
        [.., Some(above), Some(below)] => format!("{what} above {above} and below {below}"),
        [.., Some(above), None] => format!("{what} above {above}"),
        _ => what.into(),
    }
}

/// The keys of a table, as `{ center, radius }`.
fn braces(schema: &Value) -> String {
    let keys: Vec<_> = schema["properties"]
        .as_object()
        .unwrap()
        .keys()
        .cloned()
        .collect();
    format!("`{{ {} }}`", keys.join(", "))
}

/// What may stand at a key.
fn kind(root: &Value, schema: &Value) -> String {
    let text = |value: &Value| format!("`{value}`");
    if schema.to_string().contains("\"#/definitions/ShapeSpec\"") && schema.get("type").is_none() {
        return "[a shape](#shapes)".into();
    }
    let schema = resolved(root, schema);
    if let Some(words) = schema.get("enum").and_then(Value::as_array) {
        return words.iter().map(text).collect::<Vec<_>>().join(", ");
    }
    if let Some(word) = schema.get("const") {
        return text(word);
    }
    if let Some(several) = schema.get("anyOf").and_then(Value::as_array) {
        let kinds = several.iter().filter(|one| one["type"] != "null");
        return kinds.map(|one| kind(root, one)).collect::<Vec<_>>().join(" or ");
    }
    let of = |held: &Value| held.as_str().map(str::to_owned);
    let kinds = schema["type"].as_array();
    let name = kinds.map_or_else(|| of(&schema["type"]), |kinds| kinds.iter().find_map(of));
    match name.as_deref() {
        Some("number") => number(schema, "number"),
        Some("integer") => number(schema, "whole number"),
        Some("string") => "text".into(),
        Some("boolean") => "`true` or `false`".into(),
        Some("array") => {
            let count = match (schema.get("minItems"), schema.get("maxItems")) {
                (Some(least), Some(most)) if least == most => format!("{least} of "),
                (Some(least), Some(most)) => format!("{least} or {most} of "),
                _ => String::new(),
            };
            let items = kind(root, &schema["items"]);
            let items = match items
                .strip_prefix("whole number")
                .or_else(|| items.strip_prefix("number"))
            {
                Some(range) => items.replacen(&format!("number{range}"), &format!("numbers{range}"), 1),
                None => items,
            };
            format!("list of {count}{items}")
        }
        Some("object") => braces(schema),
        other => panic!("{other:?}: {schema}"),
    }
}

/// Keys that a table has beside those of a shape come first in it; one of these bodies says which shape it is.
const BODIES: [&str; 10] = [
    "circle", "sphere", "box", "torus", "capsule", "text", "image", "mesh", "file", "shapes",
];

/// The page as it is written.
struct Page<'a> {
    root: &'a Value,
    /// The keys of a shape, which have a section of their own.
    shape: &'a Value,
    text: String,
}

/// Whether a shape stands at a key, or a list of them.
fn is_shape(key: &Value) -> bool {
    let items = key.get("items").unwrap_or(key);
    items.get("properties").is_none() && key.to_string().contains("\"#/definitions/ShapeSpec\"")
}

fn words(schema: &Value) -> Option<&str> {
    schema.get("description").and_then(Value::as_str)
}

/// What is said of a key. The words of a choice end with its kind, which has a column of its own.
fn sentence(words: &str) -> String {
    const KINDS: [&str; 5] = [
        "a whole number",
        "a number",
        "a finite number",
        "true or false",
        "\"",
    ];
    let bare = match words.rsplit_once(": ") {
        Some((bare, kind)) if KINDS.iter().any(|begins| kind.starts_with(begins)) => bare,
        _ => words,
    };
    let mut letters = bare.trim_end_matches('.').chars();
    let first = letters.next().map(|first| first.to_uppercase().to_string());
    format!("{}{}.", first.unwrap_or_default(), letters.as_str())
}

/// A value as one would write it.
fn shown(value: &Value) -> String {
    match value.as_f64() {
        Some(small) if small != 0.0 && small.abs() < 1e-2 => format!("`{small:e}`"),
        _ => format!("`{value}`"),
    }
}

impl Page<'_> {
    fn new(root: &Value) -> Page<'_> {
        Page {
            root,
            shape: &root["definitions"]["ShapeSpec"],
            text: HEAD.to_owned(),
        }
    }

    fn head(&mut self, title: &str, words: &str) {
        let columns = "| key | what it may be | default | unit | meaning |\n|---|---|---|---|---|";
        write!(self.text, "\n## {title}\n\n{words}\n\n{columns}\n").unwrap();
    }

    /// The row of a key; `at` is the key that it stands in, with a dot.
    fn row(&mut self, at: &str, name: &str, key: &Value, needed: bool) {
        let held = resolved(self.root, key);
        let said = words(key).or_else(|| words(held)).unwrap_or_default();
        assert!(!said.is_empty(), "the key {at}{name} has no description");
        let said = sentence(said);
        let otherwise = match (key.get("default"), key.get("x-default").and_then(Value::as_str)) {
            (Some(value), _) => shown(value),
            (None, words) => words.unwrap_or_default().into(),
        };
        let unit = key.get("x-unit").and_then(Value::as_str).unwrap_or_default();
        let mark = if needed { "*" } else { "" };
        let kind = kind(self.root, key);
        writeln!(
            self.text,
            "| {mark}`{at}{name}`{mark} | {kind} | {otherwise} | {unit} | {said} |"
        )
        .unwrap();
    }

    /// The rows of a table's keys but for some, and of those of tables within them.
    fn rows(&mut self, at: &str, table: &Value, but: &dyn Fn(&str) -> bool, within: bool) {
        let needed = table["required"].as_array().cloned().unwrap_or_default();
        for (name, key) in table["properties"]
            .as_object()
            .unwrap()
            .iter()
            .filter(|(name, _)| !but(name))
        {
            let several = key.get("anyOf").and_then(Value::as_array);
            let tables: Vec<&Value> = match several {
                Some(several) => several.iter().map(|one| resolved(self.root, one)).collect(),
                None => vec![resolved(self.root, key)],
            };
            let inner = tables
                .into_iter()
                .find(|table| table.get("properties").is_some() && !is_shape(key));
            // A table in a section is one of its own.
            if !within && resolved(self.root, key).get("properties").is_some() && !is_shape(key) {
                continue;
            }
            self.row(at, name, key, needed.contains(&name.as_str().into()));
            if let Some(inner) = inner {
                self.rows(&format!("{at}{name}."), inner, &|_| false, true);
            }
        }
    }

    /// A table of the scene, and those within it, each a section.
    fn section(&mut self, name: &str, schema: &Value) {
        let many = schema.get("items").is_some();
        let title = if many {
            format!("`[[{name}]]`")
        } else {
            format!("`[{name}]`")
        };
        let said = words(schema).unwrap();
        if is_shape(schema) {
            write!(
                self.text,
                "\n## {title}\n\n{said} Its keys are those of a [shape](#shapes).\n"
            )
            .unwrap();
            return;
        }
        let table = resolved(self.root, schema.get("items").unwrap_or(schema));
        let keys = &table["properties"];
        let shape = self.shape["properties"].as_object().unwrap();
        let drawn = shape.keys().all(|key| keys.get(key).is_some());
        let and = if drawn {
            " It has the keys of a [shape](#shapes), too."
        } else {
            ""
        };
        self.head(&title, &format!("{said}{and}"));
        // A key with other words than those of a shape is the table's own.
        let of_shape = |key: &str| drawn && shape.get(key).is_some_and(|of| words(of) == words(&keys[key]));
        self.rows("", table, &of_shape, many);
        for (inner, key) in keys.as_object().unwrap() {
            if !many && resolved(self.root, key).get("properties").is_some() && !is_shape(key) {
                self.section(&format!("{name}.{inner}"), key);
            }
        }
    }

    fn shapes(&mut self) {
        self.head(
            "Shapes",
            "One of the first ten keys, and what goes with it: [shapes](shapes.md) says more of each.",
        );
        let keys = self.shape["properties"].as_object().unwrap();
        let others = keys
            .keys()
            .map(String::as_str)
            .filter(|key| !BODIES.contains(key));
        for only in BODIES.into_iter().chain(others) {
            self.rows("", self.shape, &|key| key != only, true);
        }
    }
}

/// The whole page.
fn page(root: &Value) -> String {
    let (mut page, tables) = (Page::new(root), root["properties"].as_object().unwrap());
    let others = tables
        .keys()
        .map(String::as_str)
        .filter(|name| !ORDER.contains(name));
    for name in ORDER.into_iter().chain(others) {
        page.section(name, &tables[name]);
    }
    page.shapes();
    page.text
}

#[test]
fn the_page_of_scene_keys_is_current() {
    let path = project().join("docs/scene_keys.md");
    let made = page(&schema());
    if std::env::var_os("THURIBLE_WRITE_DOCS").is_some() {
        fs::write(&path, &made).unwrap();
    }
    let found = fs::read_to_string(&path).unwrap_or_default();
    assert!(
        found == made,
        "docs/scene_keys.md is not current: THURIBLE_WRITE_DOCS=1 cargo test --test book"
    );
}
