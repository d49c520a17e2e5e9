//! What the schema of scenes says of a key beside its type: the value that it has where a scene leaves it out, and its unit.

use serde_json::{Value, json};

/// A key, what it is where a scene leaves it out (JSON, words where that depends on the scene, or nothing), and its unit.
type Key = (&'static str, &'static str, &'static str);

const VELOCITY: &str = "length / time";
const FORCE: &str = "length / time^2";

/// Tables of the schema by their place there, each with its keys.
const TABLES: &[(&str, &[Key])] = &[
    (
        "/definitions/RawGrid/properties",
        &[
            ("cells", "", "cells"),
            ("boundary", r#""wall""#, ""),
            ("length", "1.0", "length"),
        ],
    ),
    (
        "/definitions/RawTime/properties",
        &[("steps", "", "steps"), ("dt", "1.0", "time")],
    ),
    (
        "/definitions/RawFlow/properties",
        &[
            ("viscosity", "0.0", "length^2 / time"),
            ("slip", "true", ""),
            ("buoyancy", "0.0", FORCE),
            ("gravity", "against y in 2D, against z in 3D", ""),
        ],
    ),
    (
        "/definitions/RawControl/properties",
        &[
            ("force_weight", "1000 dt^4 / length^2", "time^4 / length^2"),
            ("smoothness", r#""auto""#, "cells"),
            ("schedule", "1 at every step", "steps, factors"),
            ("mask", "everywhere", ""),
            ("filters", r#""auto""#, "filters"),
            ("match_mass", "true", ""),
            ("initial_velocity", r#""rest""#, VELOCITY),
        ],
    ),
    (
        "/definitions/RawAdvection/properties",
        &[
            ("scheme", r#""limited""#, ""),
            ("tolerance", "1e-5", "parts of the largest density"),
        ],
    ),
    (
        "/definitions/RawOutput/properties",
        &[("folder", r#""out""#, ""), ("frames", "true", "")],
    ),
    ("/definitions/ShapeSpec/properties", SHAPE),
    ("/definitions/BallKeys/properties", LENGTHS),
    ("/definitions/BlockKeys/properties", LENGTHS),
    ("/definitions/TorusKeys/properties", LENGTHS),
    ("/definitions/CapsuleKeys/properties", LENGTHS),
    (
        "/definitions/FitPlace/properties",
        &[
            ("center", "the middle of the box", "length"),
            ("size", "what 0.8 of the box allows", "length"),
        ],
    ),
    ("/properties/emitter/items/properties", SHAPE),
    (
        "/properties/emitter/items/properties",
        &[
            ("from", "0", "steps"),
            ("to", "`time.steps`", "steps"),
            ("steps", "one shape, by `from` and `to`", ""),
            ("files", "", ""),
            ("rate", "this or `target`", "density / step"),
            ("target", "this or `rate`", "density"),
            ("velocity", "that of the flow", VELOCITY),
        ],
    ),
    ("/properties/keyframe/items/properties", SHAPE),
    (
        "/properties/keyframe/items/properties",
        &[
            ("step", "this or `steps`", "steps"),
            ("steps", "this or `step`", ""),
            ("files", "", ""),
            ("hold", "0", "steps"),
            ("region", "everywhere", ""),
            ("weight", "1; of a text 0", ""),
        ],
    ),
    ("/properties/emitter/items/properties/steps/properties", SEQUENCE),
    ("/properties/keyframe/items/properties/steps/properties", SEQUENCE),
    ("/properties/release/items/properties", &[("from", "", "steps")]),
    (
        "/properties/template/items/properties",
        &[
            ("center", "", "length"),
            ("radius", "", "length"),
            ("from", "0", "steps"),
            ("to", "`time.steps`", "steps"),
            ("interval", "`to` - `from`", "steps"),
            ("move", "false", ""),
            ("amplitude", "0", FORCE),
            ("size", "`radius`", "length"),
            ("seed", "0", ""),
        ],
    ),
    (
        "/properties/method/properties",
        &[
            ("name", "`direct`; `templates` where there is any", ""),
            ("iterations", "60", ""),
            ("window", "all steps at once", "steps"),
            ("stride", "half of `window`", "steps"),
        ],
    ),
    (
        "/properties/method/properties/projection/properties",
        &[("tolerance", "1e-5", "parts of the divergence")],
    ),
    (
        "/properties/method/properties/admm/properties",
        &[("penalty", "1000 dt^2 / length^2", "time^2 / length^2")],
    ),
    (
        "/properties/method/properties/guide/properties",
        &[
            ("radius", "", "cells"),
            ("curl_noise", "", "cells / step"),
            ("noise_sigma", "", "cells"),
        ],
    ),
    (
        "/properties/method/properties/stable_fluids/properties",
        &[
            ("control", r#"["initial_velocity"]"#, ""),
            ("slots", r#""auto""#, "states"),
            ("diffusion", "", "length^2 / time"),
        ],
    ),
];

/// Where a sequence stands.
const SEQUENCE: &[Key] = &[("from", "", "steps"), ("every", "", "steps")];

/// Keys of a shape.
const SHAPE: &[Key] = &[
    ("density", "1.0", "density"),
    ("font", "DejaVu Sans Bold", ""),
    ("height", "half of the box, or what fits", "length"),
    ("center", "the middle of the box", "length"),
    (
        "depth",
        "0.3 of `height`; of a picture 0.15 of the box's height",
        "length",
    ),
    ("weight", "0.0", "parts of `height`"),
    ("ink", "by the picture", ""),
    ("name", "the only array; of a volume `density`", ""),
    ("entry", "all of the array", ""),
    ("fit", "0.8 of the box, in its middle", ""),
    ("up", "y of OBJ and glTF, else z", ""),
];

/// Keys of balls, boxes, rings and capsules.
const LENGTHS: &[Key] = &[
    ("center", "", "length"),
    ("radius", "", "length"),
    ("min", "", "length"),
    ("max", "", "length"),
    ("tube", "", "length"),
    ("axis", r#""z""#, ""),
    ("from", "", "length"),
    ("to", "", "length"),
];

/// Writes defaults and units into the schema `root`: `default` where it is a value, `x-default` where it is said in words, `x-unit`.
pub(super) fn annotate(root: &mut Value) {
    for (place, keys) in TABLES {
        let Some(Value::Object(table)) = root.pointer_mut(place) else {
            continue;
        };
        for (name, otherwise, unit) in *keys {
            let Some(Value::Object(key)) = table.get_mut(*name) else {
                continue;
            };
            if !otherwise.is_empty() {
                let value = serde_json::from_str::<Value>(otherwise);
                key.remove("default");
                key.remove("x-default");
                match value {
                    Ok(value) => drop(key.insert("default".into(), value)),
                    Err(_) => drop(key.insert("x-default".into(), json!(otherwise))),
                }
            }
            key.remove("x-unit");
            if !unit.is_empty() {
                key.insert("x-unit".into(), json!(unit));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_table_is_in_the_schema_with_its_keys() {
        let schema = crate::scene::schema();
        for (place, keys) in TABLES {
            let table = schema.pointer(place);
            assert!(table.is_some(), "{place}");
            let found = |name: &str| table.is_some_and(|table| table.get(name).is_some());
            let missing = keys.iter().map(|(name, ..)| *name).find(|name| !found(name));
            // One list serves four bodies, none of which has all of its keys.
            assert!(missing.is_none() || *keys == LENGTHS, "{place}: {missing:?}");
        }
    }
}
