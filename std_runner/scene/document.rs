//! The text of a scene with `--set` applied, and where each key stands, so that every error can say so.

use crate::exit::Failure;
use crate::scene::place::{Segment, join, line_index, line_of, parse_key};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use toml::{Table, Value};

/// A parsed scene file that remembers the line of every key and what `--set` changed.
#[derive(Clone, Debug)]
pub struct Document {
    path: PathBuf,
    text: String,
    table: Table,
    lines: BTreeMap<String, usize>,
    overrides: Vec<Override>,
}

/// What the command line changed.
#[derive(Clone, Debug)]
struct Override {
    /// The key, in the one form that all messages use.
    key: String,
    /// The option, for messages.
    option: String,
    /// `key = value`, as [`Document::set`] reads it.
    assignment: String,
}

impl Document {
    /// Reads and parses `path`.
    pub fn read(path: &Path) -> Result<Self, Failure> {
        let shown = path.display();
        let bytes = std::fs::read(path).map_err(|error| {
            Failure::File(format!("cannot read the scene {shown}: {error}; give the path of a scene file, or write one with `thurible new NAME`"))
        })?;
        let text = String::from_utf8(bytes).map_err(|_| {
            Failure::Input(format!(
                "{shown} is not UTF-8 text; a scene is a TOML file, `thurible new NAME` writes one"
            ))
        })?;
        Self::parse(path, text)
    }

    /// Parses `text` as if it had been read from `path`.
    pub fn parse(path: &Path, text: String) -> Result<Self, Failure> {
        let broken = |error: toml::de::Error| {
            let line = error.span().map_or(1, |span| line_of(&text, span.start));
            let message = error.message().replace('\n', ", ");
            Failure::Input(format!(
                "{}:{line}: not valid TOML: {message}; correct this line",
                path.display()
            ))
        };
        let table: Table = toml::from_str(&text).map_err(broken)?;
        let lines = line_index(&text).map_err(broken)?;
        Ok(Document {
            path: path.to_path_buf(),
            text,
            table,
            lines,
            overrides: Vec::new(),
        })
    }

    /// Applies one `--set key.path=value`; the value is TOML, or else a string.
    pub fn set(&mut self, assignment: &str) -> Result<(), Failure> {
        let option = format!("--set {assignment}");
        let Some((key, value)) = assignment.split_once('=') else {
            return Err(Failure::Input(format!(
                "{option}: there is no `=` in it; write key.path=value, as in --set time.steps=20"
            )));
        };
        self.replace(option, key.trim(), parse_value(value.trim()))
    }

    /// Puts `value` at `key` because the command line said so in `option`, which later errors will name.
    pub fn replace(&mut self, option: String, key: &str, value: Value) -> Result<(), Failure> {
        let refuse = |why: String| Failure::Input(format!("{option}: {why}"));
        let segments = parse_key(key).map_err(refuse)?;
        let key = join(&segments);
        let assignment = format!("{key}={value}");
        assign(&mut self.table, &segments, value).map_err(refuse)?;
        self.overrides.push(Override {
            key,
            option,
            assignment,
        });
        Ok(())
    }

    /// What was changed of the file, in order, each as [`Self::set`] reads it.
    pub fn assignments(&self) -> impl Iterator<Item = &str> {
        self.overrides.iter().map(|change| change.assignment.as_str())
    }

    /// Whether the command line gave the value of `key`.
    pub fn overrides(&self, key: &str) -> bool {
        self.overrides.iter().any(|change| within(key, &change.key))
    }

    /// The table of the whole scene, overrides included.
    pub fn table(&self) -> &Table {
        &self.table
    }

    /// The text as it was read.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// The file's path as it was given.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The folder that relative paths of the scene start from.
    pub fn folder(&self) -> &Path {
        self.path.parent().unwrap_or(Path::new(""))
    }

    /// Where the value of `key` was given: `--set ...`, or file and line (of its table, if it is missing).
    pub fn place(&self, key: &str) -> String {
        let mut latest = self.overrides.iter().rev();
        if let Some(change) = latest.find(|change| within(key, &change.key)) {
            return change.option.clone();
        }
        let file = self.path.display();
        let mut latest = self.overrides.iter().rev();
        let touched = latest.find(|change| within(&change.key, key));
        let also = touched.map_or(String::new(), |change| format!(" with {}", change.option));
        let mut at = key;
        loop {
            if let Some(line) = self.lines.get(at) {
                return format!("{file}:{line}{also}");
            }
            match at.rfind(['.', '[']) {
                Some(cut) => at = &at[..cut],
                None => return format!("{file}{also}"),
            }
        }
    }

    /// A refusal of what stands at `key`.
    pub fn refuse(&self, key: &str, why: impl core::fmt::Display) -> Failure {
        Failure::Input(format!("{}: `{key}` {why}", self.place(key)))
    }
}

/// Whether key `inner` is `outer` or lies inside it.
fn within(inner: &str, outer: &str) -> bool {
    inner
        .strip_prefix(outer)
        .is_some_and(|rest| rest.is_empty() || rest.starts_with(['.', '[']))
}

fn parse_value(text: &str) -> Value {
    let parsed = toml::from_str::<Table>(&format!("value = {text}")).ok();
    match parsed {
        Some(mut table) if table.len() == 1 => table
            .remove("value")
            .unwrap_or_else(|| Value::String(text.into())),
        _ => Value::String(text.into()),
    }
}

fn assign(table: &mut Table, segments: &[Segment], value: Value) -> Result<(), String> {
    let Some((Segment::Key(first), rest)) = segments.split_first() else {
        return Err("the key must begin with the name of a section, as in grid.cells".into());
    };
    if rest.is_empty() {
        table.insert(first.clone(), value);
        return Ok(());
    }
    let fresh = if matches!(rest[0], Segment::Index(_)) {
        Value::Array(Vec::new())
    } else {
        Value::Table(Table::new())
    };
    descend(table.entry(first.clone()).or_insert(fresh), first, rest, value)
}

fn descend(slot: &mut Value, name: &str, rest: &[Segment], value: Value) -> Result<(), String> {
    match (slot, rest) {
        (Value::Table(table), [Segment::Key(_), ..]) => assign(table, rest, value),
        (Value::Array(items), [Segment::Index(index), deeper @ ..]) => {
            let count = items.len();
            if *index == count {
                items.push(Value::Table(Table::new()));
            }
            let item = items
                .get_mut(*index)
                .ok_or_else(|| format!("`{name}` has no entry {index}; there are {count}, counted from 0"))?;
            if deeper.is_empty() {
                *item = value;
                return Ok(());
            }
            descend(item, name, deeper, value)
        }
        (Value::Array(_), _) => Err(format!("`{name}` is a list; write {name}[0] for its first entry")),
        _ => Err(format!("`{name}` holds a value and has no keys inside it")),
    }
}
