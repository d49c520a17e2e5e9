//! The order of the core's modules, which is that of the table in `core/lib.rs`, and no circles between files.
//!
//! A file imports another one if it names something that is defined there. A `pub use` is no import: who names something through
//! it imports from the file that defines it.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a test says what went wrong by panicking"
)]

mod files;
mod tokens;

use files::{Files, circles};
use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

fn project() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).to_owned()
}

/// The modules in the first page's table, those of a row together.
fn table() -> Vec<Vec<String>> {
    let text = fs::read_to_string(project().join("core/lib.rs")).unwrap();
    let rows = text.lines().filter_map(|line| line.strip_prefix("//! |"));
    rows.filter_map(|row| row.split('|').nth(1))
        .map(|cell| {
            cell.split("[`")
                .skip(1)
                .map(|name| name.split('`').next().unwrap().to_owned())
                .collect::<Vec<_>>()
        })
        .filter(|modules| !modules.is_empty())
        .collect()
}

#[test]
fn the_core_imports_only_from_earlier_rows_of_its_table() {
    let (table, core) = (table(), Files::read(&project().join("core"), &["ffi"]));
    let place = |module: &str| table.iter().position(|row| row.iter().any(|name| name == module));
    let mut wrong = BTreeSet::new();
    for (module, imports) in core.imports() {
        let Some(own) = module.first().and_then(|name| place(name)) else {
            continue;
        };
        for import in imports {
            let later = match import.first() {
                Some(name) => place(name).is_some_and(|other| other > own),
                None => true,
            };
            if later {
                wrong.insert(format!(
                    "{} imports from {}",
                    core.path(&module),
                    core.path(&import)
                ));
            }
        }
    }
    assert!(
        wrong.is_empty(),
        "against the order of the table in core/lib.rs:\n{wrong:#?}"
    );
}

#[test]
fn the_table_names_every_module_of_the_core_once() {
    let (table, core) = (table(), Files::read(&project().join("core"), &["ffi"]));
    let listed: Vec<&str> = table.iter().flatten().map(String::as_str).collect();
    let distinct: BTreeSet<&str> = listed.iter().copied().collect();
    assert_eq!(distinct, core.at_the_top());
    assert_eq!(distinct.len(), listed.len(), "a module stands there twice");
}

#[test]
fn no_files_import_each_other_in_a_circle() {
    let crates: [(&str, &[&str]); 7] = [
        ("core", &["ffi"]),
        ("core/ffi", &["tools", "tests", "target"]),
        ("std_runner", &["python", "mpi", "gpu", "main.rs"]),
        ("std_runner/gpu", &["tests"]),
        ("std_runner/python", &["tests", "target"]),
        ("std_runner/mpi", &["main.rs", "target"]),
        ("benches/program", &["main.rs"]),
    ];
    let mut found = Vec::new();
    for (folder, others) in crates {
        let files = Files::read(&project().join(folder), others);
        let imports = files.imports();
        for circle in circles(&imports) {
            let arrows = circle.iter().flat_map(|module| {
                let within = imports[module].iter().filter(|import| circle.contains(*import));
                within.map(|import| format!("{folder}: {} -> {}", files.path(module), files.path(import)))
            });
            found.extend(arrows);
        }
    }
    assert!(
        found.is_empty(),
        "files import each other in a circle:\n{found:#?}"
    );
}
