//! What people install says the same of itself: version, licence, authors, description.

use super::root;
use std::fs;
use toml::{Table, Value};

fn table(path: &str) -> Table {
    fs::read_to_string(root().join(path)).unwrap().parse().unwrap()
}

/// A key of `[package]`, that of the workspace where it says so.
fn said(workspace: &Table, package: &Table, key: &str) -> Value {
    let found = package["package"].get(key).unwrap_or_else(|| panic!("no {key}"));
    match found.get("workspace") {
        Some(_) => workspace["workspace"]["package"][key].clone(),
        None => found.clone(),
    }
}

#[test]
fn every_package_says_the_same_of_itself() {
    let workspace = table("Cargo.toml");
    let shared = &workspace["workspace"]["package"];
    for path in [
        "Cargo.toml",
        "core/Cargo.toml",
        "core/ffi/Cargo.toml",
        "std_runner/python/Cargo.toml",
        "std_runner/mpi/Cargo.toml",
    ] {
        let package = table(path);
        for key in ["version", "license", "authors", "edition", "rust-version"] {
            assert_eq!(said(&workspace, &package, key), shared[key], "{path}: {key}");
        }
        assert!(
            !said(&workspace, &package, "description")
                .as_str()
                .unwrap()
                .is_empty()
        );
    }
    for path in ["Cargo.toml", "core/Cargo.toml"] {
        let package = table(path);
        for key in ["readme", "keywords", "categories", "repository"] {
            said(&workspace, &package, key);
        }
        assert!(
            said(&workspace, &package, "keywords").as_array().unwrap().len() <= 5,
            "{path}"
        );
    }
    let dependency = &workspace["dependencies"]["thurible-core"]["version"];
    assert_eq!(
        dependency, &shared["version"],
        "the program asks for the core of its version"
    );
}

#[test]
fn the_wheel_and_the_extension_say_so_too() {
    let workspace = table("Cargo.toml");
    let shared = &workspace["workspace"]["package"];
    let wheel = table("std_runner/python/pyproject.toml");
    let project = &wheel["project"];
    assert_eq!(project["name"].as_str(), Some("thurible-smoke"));
    assert_eq!(project["license"], shared["license"]);
    assert_eq!(project["authors"][0]["name"], shared["authors"][0]);
    for file in project["license-files"].as_array().unwrap() {
        let own = fs::read(root().join("std_runner/python").join(file.as_str().unwrap())).unwrap();
        assert_eq!(
            own,
            fs::read(root().join(file.as_str().unwrap())).unwrap(),
            "{file}"
        );
    }
    assert!(
        root()
            .join("std_runner/python")
            .join(project["readme"].as_str().unwrap())
            .exists()
    );
    let extension = table("std_runner/blender/blender_manifest.toml");
    assert_eq!(extension["version"], shared["version"]);
    assert_eq!(extension["maintainer"], shared["authors"][0]);
    // It imports Blender, which is under the GPL.
    assert_eq!(extension["license"][0].as_str(), Some("SPDX:GPL-3.0-or-later"));
}

#[test]
fn the_crates_carry_the_licences() {
    for name in ["LICENSE-MIT", "LICENSE-APACHE"] {
        let own = fs::read(root().join("core").join(name)).unwrap();
        assert_eq!(own, fs::read(root().join(name)).unwrap(), "{name}");
    }
}
