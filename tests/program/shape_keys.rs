//! Every mistake in the keys of a shape is a sentence that names the key and the remedy; nothing panics.

use std::fs;
use std::path::{Path, PathBuf};
use thurible::keyframes::{Canvas, ShapeError, ShapeSpec};

pub fn canvas(dimensions: usize) -> Canvas {
    Canvas {
        cells: vec![16; dimensions],
        periodic: vec![false; dimensions],
        length: 1.0,
    }
}

/// A fresh folder of its own for a test.
pub fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("shape_errors_{name}"));
    let _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder).unwrap();
    folder
}

pub fn refusal(shape: &str, dimensions: usize, base: &Path) -> ShapeError {
    let spec: ShapeSpec = toml::from_str(shape).unwrap_or_else(|error| panic!("{shape}: {error}"));
    spec.rasterise(&canvas(dimensions), base)
        .err()
        .unwrap_or_else(|| panic!("{shape}: was drawn"))
}

/// A shape, the dimensions of its box, and how it is refused.
const WRONG_KEYS: [(&str, usize, &str); 26] = [
    ("", 2, "`shape` is missing"),
    ("density = 1.0", 2, "`shape` is missing"),
    (
        "circle = { center = [0.5, 0.5], radius = 0.0 }",
        2,
        "`circle.radius` is 0",
    ),
    (
        "circle = { center = [0.5, 0.5], radius = -0.1 }",
        2,
        "`circle.radius` is -0.1",
    ),
    (
        "circle = { center = [0.5, 0.5], radius = nan }",
        2,
        "`circle.radius` is NaN",
    ),
    (
        "circle = { center = [0.5, inf], radius = 0.1 }",
        2,
        "`circle.center` is inf",
    ),
    (
        "circle = { center = [0.5], radius = 0.1 }",
        2,
        "`circle.center` has 1 numbers",
    ),
    (
        "circle = { center = [0.5, 0.5, 0.5], radius = 0.1 }",
        2,
        "`circle.center` has 3 numbers",
    ),
    (
        "sphere = { center = [1, 2, 3, 4], radius = 0.1 }",
        3,
        "`sphere.center` has 4 numbers",
    ),
    (
        "circle = { center = [5, 5], radius = 0.1 }",
        2,
        "`circle` puts nothing into the box",
    ),
    (
        "box = { min = [0.5, 0.5], max = [0.4, 0.6] }",
        2,
        "`box.max` is 0.4 along axis x",
    ),
    (
        "box = { min = [0.2, 0.2], max = [0.4, 0.6] }",
        3,
        "`box.min` has 2 numbers",
    ),
    (
        "torus = { center = [0.5, 0.5], axis = \"w\", radius = 0.2, tube = 0.1 }",
        3,
        "`torus.axis` is \"w\"",
    ),
    (
        "torus = { center = [0.5, 0.5], axis = [0, 0, 0], radius = 0.2, tube = 0.1 }",
        3,
        "`torus.axis` is [0.0",
    ),
    (
        "torus = { center = [0.5, 0.5], axis = \"x\", radius = 0.2, tube = 0.1 }",
        2,
        "`torus.axis` tilts",
    ),
    (
        "torus = { center = [0.5, 0.5], radius = 0.2, tube = 0 }",
        2,
        "`torus.tube` is 0",
    ),
    ("text = \"\"", 2, "`text` is \"\""),
    ("text = \"  \"", 2, "`text` is \"  \""),
    ("text = \"\u{4e2d}\"", 2, "`text` has the letter '\u{4e2d}'"),
    ("text = \"F\"\nheight = -1", 2, "`height` is -1"),
    ("text = \"F\"\ndepth = 0.1", 2, "`depth` is given"),
    ("text = \"F\"\nweight = 7", 2, "`weight` is 7"),
    (
        "text = \"F\"\ncircle = { center = [0.5, 0.5], radius = 0.1 }",
        2,
        "two shapes in one table",
    ),
    (
        "circle = { center = [0.5, 0.5], radius = 0.1 }\nheight = 1",
        2,
        "`height` is a key of `text`",
    ),
    (
        "circle = { center = [0.5, 0.5], radius = 0.1 }\ndensity = -1",
        2,
        "`density` is -1",
    ),
    ("shapes = []", 2, "`shapes` is empty"),
];

#[test]
fn wrong_keys_are_refused_by_name() {
    for (shape, dimensions, expected) in WRONG_KEYS {
        let error = refusal(shape, dimensions, Path::new("")).to_string();
        assert!(
            error.contains(expected),
            "{shape}\n  said    {error}\n  not     {expected}"
        );
        assert!(error.contains("; "), "no remedy: {error}");
    }
}

#[test]
fn unknown_keys_and_wrong_types_are_refused() {
    for (shape, expected) in [
        ("circel = 1", "unknown field `circel`"),
        (
            "circle = { center = [0.5, 0.5], radius = 0.2, colour = 1 }",
            "unknown field `colour`",
        ),
        ("circle = { center = [0.5, 0.5] }", "missing field `radius`"),
        ("circle = 0.2", "{ center = [x, y], radius = r }"),
        ("text = 5", "expected a string"),
        (
            "torus = { center = [0.5, 0.5], axis = 3, radius = 0.2, tube = 0.1 }",
            "three numbers",
        ),
    ] {
        let error = toml::from_str::<ShapeSpec>(shape).unwrap_err().to_string();
        assert!(
            error.contains(expected),
            "{shape}\n  said    {error}\n  not     {expected}"
        );
    }
}
