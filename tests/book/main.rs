//! The book says what the program does: every command of the README and of docs/ runs, word for word and on small scenes, and the page of
//! scene keys is that of the schema.
#![cfg(all(unix, feature = "std"))]
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a test says what went wrong by panicking"
)]

mod commands;
mod defaults;
mod packages;
mod pages;
mod scene_keys;
mod workshop;

use std::path::Path;

/// The project's folder.
fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// What the program prints with `arguments`.
fn printed(arguments: &[&str]) -> String {
    let output = std::process::Command::new(env!("CARGO_BIN_EXE_thurible"))
        .args(arguments)
        .output()
        .unwrap();
    assert!(
        output.status.success(),
        "{arguments:?}: {}",
        String::from_utf8_lossy(&output.stderr)
    );
    String::from_utf8(output.stdout).unwrap()
}

fn schema() -> serde_json::Value {
    serde_json::from_str(&printed(&["schema"])).unwrap()
}

/// What a part of the schema `root` is: what it refers to, alone or beside null.
fn resolved<'a>(root: &'a serde_json::Value, schema: &'a serde_json::Value) -> &'a serde_json::Value {
    let several = schema
        .get("allOf")
        .or_else(|| schema.get("anyOf"))
        .and_then(|several| several.as_array());
    let mut parts = several
        .into_iter()
        .flatten()
        .filter(|part| part["type"] != "null");
    match (schema.get("$ref"), parts.next(), parts.next()) {
        (Some(place), ..) => root.pointer(&place.as_str().unwrap()[1..]).unwrap(),
        (None, Some(only), None) => resolved(root, only),
        _ => schema,
    }
}
