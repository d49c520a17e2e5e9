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

/// A font whose ligature asks for a second letter by a list that is not there, at which the library that shapes text panics.
fn damaged_font() -> Vec<u8> {
    let font = dejavu::sans::bold();
    let face = rustybuzz::Face::from_slice(font, 0).unwrap();
    let first = face.glyph_index('f').unwrap().0;
    #[rustfmt::skip]
    let substitutions = [
        1, 0, 10, 30, 44,                        // version, scripts, features, lookups
        1, 0x4446, 0x4c54, 8, 4, 0, 0, 0xffff, 1, 0, // DFLT, its default language, feature 0
        1, 0x6c69, 0x6761, 8, 0, 1, 0,           // liga, lookup 0
        1, 4, 6, 0, 1, 8,                        // a lookup by what stands around, with one table
        3, 0, 2, 14, 0, 0, 0,                    // two letters: one listed at 14, the other at 0, nowhere
        1, 1, first,                             // a list of one letter
    ];
    let table: Vec<u8> = substitutions.into_iter().flat_map(u16::to_be_bytes).collect();
    let mut bytes = font.to_vec();
    let entry = bytes.windows(4).position(|tag| tag == b"GSUB").unwrap();
    let place = [bytes.len() as u32, table.len() as u32].map(u32::to_be_bytes);
    bytes[entry + 8..entry + 16].copy_from_slice(place.as_flattened());
    bytes.extend(table);
    bytes
}

#[test]
fn a_font_at_which_its_library_panics_is_refused() {
    let folder = fresh_folder("refused_font");
    fs::write(folder.join("odd.ttf"), damaged_font()).unwrap();
    let [scene, out] = ["scene.toml", "out"].map(|name| folder.join(name));
    for (text, code) in [("ffi", 2), ("A", 0)] {
        let target = format!("text = \"{text}\"\nheight = 0.5\nfont = \"odd.ttf\"");
        fs::write(&scene, GOOD.replace(TARGET, &target)).unwrap();
        let ended = run(&["solve", scene.to_str().unwrap(), "-o", out.to_str().unwrap()]);
        let words: &[&str] = if code == 0 {
            &[]
        } else {
            &["scene.toml", "odd.ttf", "is damaged"]
        };
        let complaint = complaint(text, &ended, code, words);
        assert!(complaint.is_empty(), "{complaint}");
    }
}
