//! Every kind of bad input gets its sentence and its exit code; nothing panics and nothing is written.

mod commands;
mod effects;
mod scenes;
mod templates;
mod values;

use crate::support::{Ended, fresh_folder, run};
use std::fs;
use std::path::Path;

/// A scene that is right, to be spoiled line by line.
const GOOD: &str = "\
[grid]
cells = [8, 8]
[time]
steps = 4
[source]
circle = { center = [0.5, 0.5], radius = 0.3 }
[[keyframe]]
step = 4
circle = { center = [0.5, 0.6], radius = 0.3 }
[method]
iterations = 1
[output]
frames = false
";

/// One wrong scene: `from` in [`GOOD`] becomes `to`; every one of `words` must be in the message.
struct Spoiled {
    from: &'static str,
    to: &'static str,
    code: i32,
    words: &'static [&'static str],
}

const fn spoiled(from: &'static str, to: &'static str, words: &'static [&'static str]) -> Spoiled {
    Spoiled {
        from,
        to,
        code: 2,
        words,
    }
}

const fn unreadable(from: &'static str, to: &'static str, words: &'static [&'static str]) -> Spoiled {
    Spoiled {
        from,
        to,
        code: 4,
        words,
    }
}

const CELLS: &str = "cells = [8, 8]";
const STEPS: &str = "steps = 4";
const STEP: &str = "step = 4\n";
const SOURCE: &str = "circle = { center = [0.5, 0.5], radius = 0.3 }";
const TARGET: &str = "circle = { center = [0.5, 0.6], radius = 0.3 }";
const METHOD: &str = "iterations = 1";
const OUTPUT: &str = "frames = false";

/// What is wrong with how the program refused `what`; empty if nothing is.
fn complaint(what: &str, ended: &Ended, code: i32, words: &[&str]) -> String {
    let missing: Vec<_> = words.iter().filter(|word| !ended.err.contains(**word)).collect();
    if ended.code == code && missing.is_empty() && !ended.err.contains("panicked") {
        return String::new();
    }
    format!(
        "{what}\n    exit code {}, wanted {code}; missing {missing:?}; said: {}\n",
        ended.code,
        ended.err.trim_end()
    )
}

#[test]
fn scene_that_is_not_text_is_refused() {
    let folder = fresh_folder("refused_binary");
    let scene = folder.join("scene.toml");
    fs::write(&scene, [0xff, 0xfe, 0x00, 0x80]).unwrap();
    assert_eq!(
        complaint(
            "binary",
            &run(&["solve", scene.to_str().unwrap()]),
            2,
            &["not UTF-8"]
        ),
        ""
    );
    assert_eq!(
        complaint(
            "folder",
            &run(&["solve", folder.to_str().unwrap()]),
            4,
            &["cannot read"]
        ),
        ""
    );
}

#[test]
fn the_good_scene_is_good() {
    let folder = fresh_folder("not_refused");
    let scene = folder.join("scene.toml");
    fs::write(&scene, GOOD).unwrap();
    let ended = run(&["plan", scene.to_str().unwrap()]);
    assert_eq!(ended.code, 0, "{}", ended.err);
    assert!(ended.err.is_empty(), "{}", ended.err);
    assert!(!Path::new(&folder.join("out")).exists());
}
