//! Command lines that are refused.

use super::{GOOD, complaint};
use crate::support::{fresh_folder, run};
use std::fs;

/// Command lines over [`GOOD`], which stands at SCENE.
const COMMANDS: &[(&[&str], i32, &[&str])] = &[
    (&[], 2, &["Usage"]),
    (&["dance"], 2, &["dance"]),
    (&["solve"], 2, &["SCENE"]),
    (
        &["solve", "no_such_scene.toml"],
        4,
        &["no_such_scene.toml", "thurible new"],
    ),
    (&["plan", "no_such_scene.toml"], 4, &["no_such_scene.toml"]),
    (&["solve", "SCENE", "--threads", "0"], 2, &["--threads", "from 1"]),
    (
        &["solve", "SCENE", "--threads", "many"],
        2,
        &["--threads", "many"],
    ),
    // The program of these tests is built without cards.
    (
        &["solve", "SCENE", "--device", "gpu"],
        2,
        &["--device gpu", "--features gpu"],
    ),
    (&["plan", "SCENE", "--device", "gpu"], 2, &["--features gpu"]),
    (&["devices"], 2, &["--features gpu"]),
    (
        &["solve", "SCENE", "--device-memory", "lots"],
        2,
        &["--device-memory", "lots", "GiB"],
    ),
    (
        &["solve", "SCENE", "--precision", "f16"],
        2,
        &["f16", "f32", "f64"],
    ),
    (
        &["solve", "SCENE", "--method", "simulate"],
        2,
        &["--method simulate", "admm"],
    ),
    (
        &["solve", "SCENE", "--method", "magic"],
        2,
        &["--method magic", "\"magic\"", "admm"],
    ),
    (
        &["simulate", "SCENE", "--method", "admm"],
        2,
        &["unexpected argument '--method'"],
    ),
    (
        &["simulate", "SCENE", "--from", "no_such_folder"],
        4,
        &["--from no_such_folder", "result.npz"],
    ),
    (
        &["simulate", "SCENE", "--steps", "1"],
        2,
        &["--set time.steps=1", "`time.steps` is 1", "from 2"],
    ),
    (
        &["solve", "SCENE", "--memory-limit", "lots"],
        2,
        &["--memory-limit", "lots", "GiB"],
    ),
    (
        &["solve", "SCENE", "--memory-limit", "4KiB"],
        3,
        &["--memory-limit", "4,096", "fewer steps"],
    ),
    (
        &[
            "solve",
            "SCENE",
            "--set",
            "grid.cells=[64,64]",
            "--memory-limit",
            "400KiB",
        ],
        3,
        &["409,600", "`grid.cells`", "the largest grid"],
    ),
    (
        &[
            "plan",
            "SCENE",
            "--set",
            "grid.cells=[64,64]",
            "--memory-limit",
            "400KB",
            "--precision",
            "f64",
        ],
        3,
        &["400,000", "`grid.cells`"],
    ),
    (
        &["plan", "SCENE", "--memory-limit", "1 byte"],
        3,
        &["--memory-limit", "1 byte"],
    ),
    (
        &["solve", "SCENE", "--quiet", "--json"],
        2,
        &["--quiet", "--json"],
    ),
    (
        &["solve", "SCENE", "--set", "grid.cells"],
        2,
        &["--set grid.cells", "="],
    ),
    (
        &["solve", "SCENE", "--set", "grid..cells=3"],
        2,
        &["--set grid..cells=3", "empty part"],
    ),
    (
        &["solve", "SCENE", "--set", "grid.cells=[2,2]"],
        2,
        &["--set grid.cells=[2,2]", "4 to 4096"],
    ),
    (
        &["solve", "SCENE", "--set", "grid.cells.x=3"],
        2,
        &["--set grid.cells.x=3", "list"],
    ),
    (
        &["solve", "SCENE", "--set", "time.steps.x=3"],
        2,
        &["--set time.steps.x=3", "`steps`"],
    ),
    (
        &["solve", "SCENE", "--set", "keyframe[0].step=9"],
        2,
        &["--set keyframe[0].step=9", "2 to 4"],
    ),
    (
        &["solve", "SCENE", "--set", "keyframe.0.step=9"],
        2,
        &["--set keyframe.0.step=9", "2 to 4"],
    ),
    (
        &["solve", "SCENE", "--set", "keyframe[5].step=9"],
        2,
        &["--set keyframe[5].step=9", "no entry 5"],
    ),
    (&["solve", "SCENE", "--set", "[0]=9"], 2, &["--set [0]=9"]),
    (
        &["solve", "SCENE", "--set", "smoke.colour=blue"],
        2,
        &["--set smoke.colour=blue", "`smoke`", "`grid`"],
    ),
    (
        &["solve", "SCENE", "--set", "source.text=F"],
        2,
        &["--set source.text=F", "two shapes"],
    ),
    (&["solve", "SCENE", "-o", "SCENE"], 4, &["is a file", "-o DIR"]),
    (&["solve", "SCENE", "-o", "SCENE/below"], 4, &["-o DIR"]),
    (
        &["solve", "SCENE", "-o", "FULL"],
        4,
        &["not overwritten", "-o DIR"],
    ),
    (&["new", ".."], 2, &["name"]),
    (&["new", "SCENE"], 4, &["not overwritten"]),
    (
        &["new", "no/such/folder/scene"],
        4,
        &["cannot write", "no/such/folder/scene.toml"],
    ),
];

#[test]
fn wrong_command_lines_are_refused() {
    let folder = fresh_folder("refused_commands");
    let (scene, full) = (folder.join("good.toml"), folder.join("full"));
    fs::write(&scene, GOOD).unwrap();
    fs::create_dir(&full).unwrap();
    fs::write(full.join("thesis.txt"), "years of work").unwrap();
    let mut complaints = String::new();
    for (arguments, code, words) in COMMANDS {
        let place = |text: &str| {
            text.replace("SCENE", scene.to_str().unwrap())
                .replace("FULL", full.to_str().unwrap())
        };
        let arguments: Vec<String> = arguments.iter().map(|text| place(text)).collect();
        let ended = run(&arguments.iter().map(String::as_str).collect::<Vec<_>>());
        complaints += &complaint(&arguments.join(" "), &ended, *code, words);
    }
    assert!(complaints.is_empty(), "\n{complaints}");
    assert_eq!(
        fs::read_to_string(full.join("thesis.txt")).unwrap(),
        "years of work"
    );
    assert_eq!(fs::read_to_string(&scene).unwrap(), GOOD);
    let left: Vec<_> = fs::read_dir(&folder)
        .unwrap()
        .map(|entry| entry.unwrap().file_name())
        .collect();
    assert_eq!(left.len(), 2, "something was written: {left:?}");
}
