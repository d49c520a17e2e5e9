//! What may stand at keys that take several kinds of values, for editors: JSON schemas, which say no more than the reader of the scene allows
//! and no less than what can be said without the rest of the scene.

use crate::keyframes::ShapeSpec;
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde_json::{Map, Value, json};
use thurible_core::problem::{CELLS, MAX_FILTERS, MAX_SMOOTHNESS, MAX_STEPS};
use thurible_core::{Boundary, Named, Scheme, TemplateKind};

/// The names of all choices.
fn names<T: Named + 'static>() -> Vec<&'static str> {
    T::ALL.iter().map(|choice| choice.name()).collect()
}

fn step(words: &str, least: usize) -> Value {
    json!({ "description": words, "type": "integer", "minimum": least, "maximum": MAX_STEPS })
}

pub(super) fn cells(_: &mut SchemaGenerator) -> Schema {
    json_schema!({ "type": "array", "minItems": 2, "maxItems": 3,
        "items": { "type": "integer", "minimum": CELLS.start(), "maximum": CELLS.end() } })
}

pub(super) fn steps(_: &mut SchemaGenerator) -> Schema {
    json_schema!({ "type": "integer", "minimum": 2, "maximum": MAX_STEPS })
}

pub(super) fn positive(_: &mut SchemaGenerator) -> Schema {
    json_schema!({ "type": "number", "exclusiveMinimum": 0 })
}

pub(super) fn part(_: &mut SchemaGenerator) -> Schema {
    json_schema!({ "type": "number", "exclusiveMinimum": 0, "exclusiveMaximum": 1 })
}

pub(super) fn scheme(_: &mut SchemaGenerator) -> Schema {
    json_schema!({ "enum": names::<Scheme>() })
}

pub(super) fn boundary(_: &mut SchemaGenerator) -> Schema {
    let word = json!({ "enum": names::<Boundary>() });
    let sides =
        json!({ "type": "array", "minItems": 2, "maxItems": 2, "items": { "enum": ["wall", "open"] } });
    json_schema!({ "anyOf": [
        word,
        { "type": "array", "minItems": 2, "maxItems": 3, "items": { "anyOf": [word, sides] } }
    ] })
}

pub(super) fn smoothness(_: &mut SchemaGenerator) -> Schema {
    json_schema!({ "anyOf": [{ "const": "auto" }, { "type": "number", "minimum": 0, "maximum": MAX_SMOOTHNESS }] })
}

pub(super) fn filters(_: &mut SchemaGenerator) -> Schema {
    json_schema!({ "anyOf": [{ "const": "auto" }, { "type": "integer", "minimum": 0, "maximum": MAX_FILTERS }] })
}

pub(super) fn schedule(_: &mut SchemaGenerator) -> Schema {
    json_schema!({ "type": "array", "minItems": 1,
        "items": { "type": "array", "minItems": 2, "maxItems": 2, "items": { "type": "number", "minimum": 0 } } })
}

pub(super) fn velocity(_: &mut SchemaGenerator) -> Schema {
    json_schema!({ "anyOf": [
        { "const": "rest" },
        { "type": "object", "required": ["file"], "additionalProperties": false, "properties": { "file": { "description": "A .npz with one step of the arrays `velocity_x`, `velocity_y` (and `velocity_z`) as a result has them.", "type": "string" } } }
    ] })
}

pub(super) fn shape(generator: &mut SchemaGenerator) -> Schema {
    generator.subschema_for::<ShapeSpec>()
}

/// A table with the keys of a shape and others.
fn shape_and(generator: &mut SchemaGenerator, more: Value) -> Value {
    let mut table = ShapeSpec::json_schema(generator).to_value();
    if let (Some(Value::Object(keys)), Value::Object(more)) = (table.get_mut("properties"), more) {
        keys.extend(more);
    }
    table
}

fn list(items: Value) -> Schema {
    json_schema!({ "type": "array", "items": items })
}

pub(super) fn obstacles(generator: &mut SchemaGenerator) -> Schema {
    let shape = shape(generator);
    list(shape.to_value())
}

pub(super) fn emitters(generator: &mut SchemaGenerator) -> Schema {
    let positive = |words: &str| json!({ "description": words, "type": "number", "exclusiveMinimum": 0 });
    let more = json!({
        "from": step("It adds smoke to the steps after this one.", 0),
        "to": step("It adds smoke up to this step.", 1),
        "rate": positive("So much density a step."),
        "target": positive("It fills up to this density."),
        "steps": sequence("A shape for each of many steps, of `files` or of an array whose first axis is time: each adds smoke until the next one does.", 0),
        "files": files(),
        "velocity": vector("It takes the flow there along while it adds smoke.")
    });
    list(shape_and(generator, more))
}

/// Where a sequence stands, whose first step is at least this one.
fn sequence(words: &str, least: usize) -> Value {
    json!({
        "description": words, "type": "object", "additionalProperties": false, "required": ["from", "every"],
        "properties": { "from": step("The first step.", least), "every": step("How many steps apart they are.", 1) }
    })
}

fn files() -> Value {
    json!({ "description": "Pictures, meshes, volumes or arrays, one for each step, as in \"horse_*.png\".", "type": "string" })
}

fn vector(words: &str) -> Value {
    json!({ "description": words, "type": "array", "minItems": 2, "maxItems": 3, "items": { "type": "number" } })
}

pub(super) fn keyframes(generator: &mut SchemaGenerator) -> Schema {
    let region = json!({ "description": "Where it matters: any shape.", "allOf": [shape(generator)] });
    let more = json!({
        "step": step("The step it stands at: 2 or later, but for Stable Fluids.", 1),
        "steps": sequence("A shape for each of many steps, of `files` or of an array whose first axis is time.", 1),
        "files": files(),
        "hold": step("It is kept for so many more steps.", 0),
        "region": region,
        "weight": { "description": "How much it matters beside other keyframes; of a text, by how much its strokes are thickened.",
                    "type": "number" }
    });
    list(shape_and(generator, more))
}

pub(super) fn releases(_: &mut SchemaGenerator) -> Schema {
    json_schema!({ "type": "array", "maxItems": 1, "items": {
        "type": "object", "additionalProperties": false, "required": ["from"],
        "properties": { "from": step("The step from which no force acts.", 2) }
    } })
}

pub(super) fn templates(_: &mut SchemaGenerator) -> Schema {
    let numbers = json!({ "description": "How strong it is where the search begins, and in `thurible simulate`.",
        "anyOf": [{ "type": "number" }, vector("")] });
    json_schema!({ "type": "array", "items": {
        "type": "object", "additionalProperties": false, "required": ["kind", "center", "radius"],
        "properties": {
            "kind": { "description": "What it does.", "enum": names::<TemplateKind>() },
            "center": vector("Its middle."),
            "radius": { "description": "How far it reaches.", "type": "number", "exclusiveMinimum": 0 },
            "from": step("It acts from this step on.", 0),
            "to": step("It acts up to this step.", 1),
            "interval": step("Another strength every so many steps.", 1),
            "move": { "description": "Whether its middle and its radius are searched for too.", "type": "boolean" },
            "amplitude": numbers,
            "size": { "description": "Of noise: the length of its waves.", "type": "number", "exclusiveMinimum": 0 },
            "seed": { "description": "Of noise: which one.", "type": "integer", "minimum": 0, "maximum": u32::MAX }
        }
    } })
}

/// A table of choices, which others fill in.
pub(super) fn table(_: &mut SchemaGenerator) -> Schema {
    Schema::from(Map::from_iter([("type".to_owned(), "object".into())]))
}
