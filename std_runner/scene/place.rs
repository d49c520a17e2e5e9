//! Keys as text: `keyframe[0].circle.radius`, and the line at which each stands in a file.

use std::collections::BTreeMap;
use toml::de::{DeTable, DeValue};

/// One step of a key path.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Segment {
    /// A key of a table.
    Key(String),
    /// An entry of a list, from 0.
    Index(usize),
}

/// Splits `keyframe[0].step`, or `keyframe.0.step`.
pub(super) fn parse_key(text: &str) -> Result<Vec<Segment>, String> {
    let example = "write something like grid.cells or keyframe[0].step";
    let mut segments = Vec::new();
    for part in text.replace('[', ".").replace(']', "").split('.') {
        let name = part.trim();
        if name.is_empty() {
            return Err(format!("the key `{text}` has an empty part; {example}"));
        }
        segments.push(match name.parse() {
            Ok(index) => Segment::Index(index),
            Err(_) => Segment::Key(name.to_string()),
        });
    }
    Ok(segments)
}

/// The text of a key path, in the one form that all messages use.
pub(super) fn join(segments: &[Segment]) -> String {
    let mut text = String::new();
    for segment in segments {
        match segment {
            Segment::Key(name) if text.is_empty() => text.push_str(name),
            Segment::Key(name) => text.push_str(&format!(".{name}")),
            Segment::Index(index) => text.push_str(&format!("[{index}]")),
        }
    }
    text
}

/// The line of every key and list entry of a TOML text.
pub(super) fn line_index(text: &str) -> Result<BTreeMap<String, usize>, toml::de::Error> {
    let mut lines = BTreeMap::new();
    let root = DeTable::parse(text)?;
    walk_table(text, root.get_ref(), "", &mut lines);
    Ok(lines)
}

fn walk_table(text: &str, table: &DeTable<'_>, prefix: &str, lines: &mut BTreeMap<String, usize>) {
    for (key, value) in table.iter() {
        let name = key.get_ref();
        let path = if prefix.is_empty() {
            name.to_string()
        } else {
            format!("{prefix}.{name}")
        };
        lines.insert(path.clone(), line_of(text, key.span().start));
        walk_value(text, value.get_ref(), &path, lines);
    }
}

fn walk_value(text: &str, value: &DeValue<'_>, path: &str, lines: &mut BTreeMap<String, usize>) {
    match value {
        DeValue::Table(table) => walk_table(text, table, path, lines),
        DeValue::Array(items) => {
            for (index, item) in items.iter().enumerate() {
                let entry = format!("{path}[{index}]");
                lines.insert(entry.clone(), line_of(text, item.span().start));
                walk_value(text, item.get_ref(), &entry, lines);
            }
        }
        _ => {}
    }
}

/// The line, from 1, of byte `at`.
pub(super) fn line_of(text: &str, at: usize) -> usize {
    1 + text
        .as_bytes()
        .iter()
        .take(at)
        .filter(|&&byte| byte == b'\n')
        .count()
}
