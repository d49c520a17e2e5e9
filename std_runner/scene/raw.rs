//! The sections of a scene as TOML spells them; serde refuses unknown keys and wrong types, `build` the rest. Those about methods are
//! left as they are: `method` reads them by the tables of the core.

use crate::exit::Failure;
use crate::scene::document::Document;
use serde::Deserialize;
use serde::de::DeserializeOwned;
use serde_path_to_error::Segment;
use toml::{Table, Value};

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawScene {
    pub grid: Option<RawGrid>,
    pub time: Option<RawTime>,
    pub source: Option<Table>,
    pub keyframe: Option<Vec<Table>>,
    pub emitter: Option<Vec<Table>>,
    pub obstacle: Option<Vec<Table>>,
    pub release: Option<Vec<Table>>,
    pub template: Option<Vec<Table>>,
    #[serde(default)]
    pub flow: RawFlow,
    #[serde(default)]
    pub control: RawControl,
    #[serde(default)]
    pub advection: RawAdvection,
    pub method: Option<Value>,
    pub simulation: Option<Value>,
    #[serde(default)]
    pub output: RawOutput,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawGrid {
    pub cells: Option<Vec<i64>>,
    pub boundary: Option<Value>,
    pub length: Option<f64>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawTime {
    pub steps: Option<i64>,
    pub dt: Option<f64>,
}

#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawFlow {
    pub viscosity: Option<f64>,
    pub buoyancy: Option<f64>,
    pub gravity: Option<Vec<f64>>,
}

#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawControl {
    pub force_weight: Option<f64>,
    pub smoothness: Option<Value>,
    pub schedule: Option<Value>,
    pub mask: Option<Value>,
    pub filters: Option<Value>,
    pub match_mass: Option<bool>,
    pub initial_velocity: Option<Value>,
}

#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawAdvection {
    pub scheme: Option<String>,
    pub tolerance: Option<f64>,
}

#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawProjection {
    pub tolerance: Option<f64>,
}

#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawOutput {
    pub folder: Option<String>,
    pub frames: Option<bool>,
}

/// Reads `value`, which stands at key `prefix` of the scene, as a `T`.
pub(crate) fn read<T: DeserializeOwned>(
    document: &Document,
    prefix: &str,
    value: Value,
) -> Result<T, Failure> {
    serde_path_to_error::deserialize(value).map_err(|error| {
        let mut key = prefix.to_string();
        for segment in error.path().iter() {
            match segment {
                Segment::Seq { index } => key.push_str(&format!("[{index}]")),
                Segment::Map { key: name } if key.is_empty() => key.push_str(name),
                Segment::Map { key: name } => key.push_str(&format!(".{name}")),
                _ => {}
            }
        }
        document.misfit(&key, error.inner().message())
    })
}

impl Document {
    /// Refuses a key of the table at `key` that is none of `known`, as serde refuses it of a struct.
    pub(super) fn only(&self, key: &str, table: &Table, known: &[&str]) -> Result<(), Failure> {
        let Some(odd) = table.keys().find(|name| !known.contains(&name.as_str())) else {
            return Ok(());
        };
        let known = known.join("`, `");
        let message = format!("unknown field `{odd}`, expected one of `{known}`");
        Err(self.misfit(&format!("{key}.{odd}"), &message))
    }

    /// Turns serde's sentence about `key` into ours.
    fn misfit(&self, key: &str, message: &str) -> Failure {
        let mut plain = message.trim().replace('\n', ", ");
        for (serde_word, word) in PLAIN_WORDS {
            plain = plain.replace(serde_word, word);
        }
        // The name of a table's type is ours.
        if let Some((before, _)) = plain.split_once("expected a table Raw") {
            plain = format!("{before}expected a table");
        }
        let at = if key.is_empty() {
            self.place("")
        } else {
            format!("{}: `{key}`", self.place(key))
        };
        match plain.strip_prefix("unknown field ") {
            Some(rest) => {
                let (name, allowed) = rest.split_once(", ").unwrap_or((rest, ""));
                Failure::Input(format!(
                    "{at}: there is no key {name} here; {allowed}; correct its name or take it out"
                ))
            }
            None if plain.starts_with("missing field ") => Failure::Input(format!(
                "{at}: {}; add it",
                plain.replacen("missing field ", "there is no ", 1)
            )),
            None => Failure::Input(format!("{at}: {plain}; {}", remedy_of(key))),
        }
    }
}

/// serde's words for types, and what a reader of TOML calls them.
const PLAIN_WORDS: [(&str, &str); 13] = [
    ("invalid type: ", "found "),
    ("invalid value: ", "found "),
    (", expected usize", ", expected a whole number from 0"),
    (", expected u32", ", expected a whole number from 0"),
    (", expected i64", ", expected a whole number"),
    (", expected f64", ", expected a number"),
    (", expected f32", ", expected a number"),
    ("a sequence", "a list [ ... ]"),
    ("sequence", "a list"),
    ("expected a map", "expected a table"),
    ("found map", "found a table"),
    ("expected struct", "expected a table"),
    ("expected path string", "expected a string"),
];

fn remedy_of(key: &str) -> &'static str {
    match key {
        "keyframe" => "write each keyframe as a table of its own under [[keyframe]]",
        "emitter" => "write each emitter as a table of its own under [[emitter]]",
        "obstacle" => "write each obstacle as a table of its own under [[obstacle]]",
        "template" => "write each template as a table of its own under [[template]]",
        "release" => "write it as [[release]], with from = 40 under it",
        "source" => "write a shape under [source], as in circle = { center = [0.5, 0.5], radius = 0.2 }",
        _ => "write a value of that kind",
    }
}
