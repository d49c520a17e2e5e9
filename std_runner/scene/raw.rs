//! The sections of a scene as TOML spells them; serde refuses unknown keys and wrong types, `build` the rest. Those about methods are
//! left as they are: `method` reads them by the tables of the core.

use crate::exit::Failure;
use crate::scene::document::Document;
use crate::scene::kinds;
use schemars::JsonSchema;
use serde::Deserialize;
use serde::de::DeserializeOwned;
use serde_path_to_error::Segment;
use toml::{Table, Value};

#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct RawScene {
    /// The box.
    pub grid: Option<RawGrid>,
    /// The steps.
    pub time: Option<RawTime>,
    /// The smoke at step 0: one shape.
    #[schemars(schema_with = "kinds::shape")]
    pub source: Option<Table>,
    /// What it should look like later.
    #[schemars(schema_with = "kinds::keyframes")]
    pub keyframe: Option<Vec<Table>>,
    /// Smoke that is made on the way, in any shape.
    #[schemars(schema_with = "kinds::emitters")]
    pub emitter: Option<Vec<Table>>,
    /// Nothing flows through it: any shape.
    #[schemars(schema_with = "kinds::obstacles")]
    pub obstacle: Option<Vec<Table>>,
    /// No force acts from this step on.
    #[schemars(schema_with = "kinds::releases")]
    pub release: Option<Vec<Table>>,
    /// Winds and vortices of which the force is made.
    #[schemars(schema_with = "kinds::templates")]
    pub template: Option<Vec<Table>>,
    /// The fluid.
    #[serde(default)]
    pub flow: RawFlow,
    /// What is asked of the flow.
    #[serde(default)]
    pub control: RawControl,
    /// How density is carried.
    #[serde(default)]
    pub advection: RawAdvection,
    /// How it is solved.
    #[schemars(schema_with = "kinds::table")]
    pub method: Option<Value>,
    /// Choices that concern several methods.
    #[schemars(schema_with = "kinds::table")]
    pub simulation: Option<Value>,
    /// What is written.
    #[serde(default)]
    pub output: RawOutput,
}

#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct RawGrid {
    /// Cells along each axis: two numbers for a plane, three for a box.
    #[schemars(schema_with = "kinds::cells")]
    pub cells: Option<Vec<i64>>,
    /// How the box ends: a word for all axes, or a list with one for each.
    #[schemars(schema_with = "kinds::boundary")]
    pub boundary: Option<Value>,
    /// The longest side of the box; all lengths are in this unit.
    #[schemars(schema_with = "kinds::positive")]
    pub length: Option<f64>,
}

#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct RawTime {
    /// The densities are numbered 0 to this.
    #[schemars(schema_with = "kinds::steps")]
    pub steps: Option<i64>,
    /// Length of a step.
    #[schemars(schema_with = "kinds::positive")]
    pub dt: Option<f64>,
}

#[derive(Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct RawFlow {
    /// How thick the fluid is; 1e-4 is like thin syrup.
    pub viscosity: Option<f64>,
    /// Whether the flow slips along walls and obstacles, or sticks to them by its viscosity.
    pub slip: Option<bool>,
    /// Acceleration where the density is 1, against gravity.
    pub buoyancy: Option<f64>,
    /// Which way is down.
    pub gravity: Option<Vec<f64>>,
}

#[derive(Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct RawControl {
    /// Small: the keyframes are met closely; large: the force stays small.
    #[schemars(schema_with = "kinds::positive")]
    pub force_weight: Option<f64>,
    /// Forces finer than so many cells are dear.
    #[schemars(schema_with = "kinds::smoothness")]
    pub smoothness: Option<Value>,
    /// What force_weight is multiplied by at some steps.
    #[schemars(schema_with = "kinds::schedule")]
    pub schedule: Option<Value>,
    /// Where force may act: any shape.
    #[schemars(schema_with = "kinds::shape")]
    pub mask: Option<Value>,
    /// How coarse the coarsest blur is that keyframes are compared at.
    #[schemars(schema_with = "kinds::filters")]
    pub filters: Option<Value>,
    /// Scale each keyframe to the mass of the smoke at its step.
    pub match_mass: Option<bool>,
    /// The velocity at step 0.
    #[schemars(schema_with = "kinds::velocity")]
    pub initial_velocity: Option<Value>,
}

#[derive(Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct RawAdvection {
    /// How density is carried.
    #[schemars(schema_with = "kinds::scheme")]
    pub scheme: Option<String>,
    /// What the series of a step may leave out.
    #[schemars(schema_with = "kinds::part")]
    pub tolerance: Option<f64>,
}

#[derive(Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct RawProjection {
    pub tolerance: Option<f64>,
}

#[derive(Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct RawOutput {
    /// The folder of the result, from that of the scene file on.
    pub folder: Option<String>,
    /// A picture of every step, and an animation.
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
    pub(crate) fn only(&self, key: &str, table: &Table, known: &[&str]) -> Result<(), Failure> {
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
