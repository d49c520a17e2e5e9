//! The order of the core's modules: each imports only from those before it.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a test says what went wrong by panicking"
)]

use std::fs;
use std::path::{Path, PathBuf};

/// The path of the data. Numbers, memory and vectors of numbers know each other and count as one module.
const ORDER: [&[&str]; 18] = [
    &["words"],
    &["real", "memory", "simd"],
    &["exec"],
    &["observe"],
    &["checkpoint"],
    &["progress"],
    &["grid"],
    &["field"],
    &["operators"],
    &["problem"],
    &["poisson"],
    &["transport"],
    &["force"],
    &["objective"],
    &["optimise"],
    &["nso"],
    &["method"],
    &["solver"],
];

fn place(module: &str) -> Option<usize> {
    ORDER.iter().position(|names| names.contains(&module))
}

/// Every source file below `folder`.
fn sources(folder: &Path) -> Vec<PathBuf> {
    let mut list = Vec::new();
    for entry in fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()) {
        if entry.is_dir() && !entry.ends_with("target") && !entry.ends_with("ffi") {
            list.extend(sources(&entry));
        } else if entry.extension().is_some_and(|end| end == "rs") {
            list.push(entry);
        }
    }
    list
}

/// The top-level modules that `crate::..` and `$crate::..` name in a file, comments left out.
fn imports(text: &str) -> Vec<String> {
    let code: Vec<&str> = text
        .lines()
        .map(|line| line.split("//").next().unwrap_or(""))
        .collect();
    let code = code.join("\n");
    let mut list = Vec::new();
    for rest in code.split("crate::").skip(1) {
        let name = |text: &str| {
            text.chars()
                .take_while(|c| c.is_alphanumeric() || *c == '_')
                .collect::<String>()
        };
        match rest.strip_prefix('{') {
            // `use crate::{a, b::c}`: the first name of every entry at the top of the braces.
            Some(group) => {
                let mut depth = 0;
                let inside = group.chars().take_while(|&c| {
                    depth += i32::from(c == '{') - i32::from(c == '}');
                    depth >= 0
                });
                list.extend(
                    inside
                        .collect::<String>()
                        .split(',')
                        .map(|entry| name(entry.trim())),
                );
            }
            None => list.push(name(rest)),
        }
    }
    list.retain(|name| name.chars().next().is_some_and(char::is_lowercase));
    list
}

/// The module of a file of the core.
fn module_of(core: &Path, file: &Path) -> String {
    let path = file.strip_prefix(core).unwrap();
    path.components()
        .next()
        .unwrap()
        .as_os_str()
        .to_str()
        .unwrap()
        .trim_end_matches(".rs")
        .to_owned()
}

#[test]
fn modules_import_only_from_their_left() {
    let core = Path::new(env!("CARGO_MANIFEST_DIR")).join("core");
    let mut wrong = Vec::new();
    for file in sources(&core)
        .into_iter()
        .filter(|file| !file.ends_with("lib.rs"))
    {
        let (module, text) = (module_of(&core, &file), fs::read_to_string(&file).unwrap());
        let Some(own) = place(&module) else {
            wrong.push(format!("{module} has no place in the order"));
            continue;
        };
        for import in imports(&text) {
            match place(&import) {
                Some(other) if other <= own => {}
                Some(_) => wrong.push(format!(
                    "{} imports from {import}, which comes later",
                    file.strip_prefix(&core).unwrap().display()
                )),
                None if ["multiversion", "vectorised"].contains(&import.as_str()) => {}
                None => wrong.push(format!(
                    "{} imports from {import}, which has no place in the order",
                    file.display()
                )),
            }
        }
    }
    wrong.sort();
    wrong.dedup();
    assert!(
        wrong.is_empty(),
        "the order of the modules is broken:\n{}",
        wrong.join("\n")
    );
}

#[test]
fn every_module_of_the_order_is_public_in_the_crate() {
    let text = fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("core/lib.rs")).unwrap();
    let modules: Vec<&str> = text
        .lines()
        .filter_map(|line| line.strip_prefix("pub mod ")?.strip_suffix(';'))
        .collect();
    for module in &modules {
        assert!(place(module).is_some(), "{module} has no place in the order");
    }
    for name in ORDER.iter().copied().flatten() {
        assert!(modules.contains(name), "{name} is not a module of the core");
    }
}

/// Beside the C interface, which `sources` leaves out.
const MAY_BE_UNSAFE: [&str; 3] = ["memory/arena.rs", "exec/", "simd/"];

#[test]
fn unsafe_code_is_in_three_rooms() {
    let core = Path::new(env!("CARGO_MANIFEST_DIR")).join("core");
    for file in sources(&core) {
        let (name, text) = (
            file.strip_prefix(&core).unwrap(),
            fs::read_to_string(&file).unwrap(),
        );
        let code = |line: &str| {
            line.split("//")
                .next()
                .is_some_and(|code| code.contains("unsafe"))
        };
        let allowed = MAY_BE_UNSAFE
            .iter()
            .any(|room| name.to_str().unwrap().starts_with(room));
        assert!(
            allowed || !text.lines().any(code),
            "{} has unsafe code",
            name.display()
        );
    }
}

#[test]
fn imports_are_found() {
    let text = "use crate::grid::{Grid, Space};\nuse crate::{field, real::Real};\n// crate::solver\nlet x = crate::force::f();\n$crate::simd::level()";
    assert_eq!(imports(text), ["grid", "field", "real", "force", "simd"]);
}
