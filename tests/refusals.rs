//! Every kind of bad input gets its sentence and its exit code; nothing panics and nothing is written.
#![cfg(feature = "std")]
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a test says what went wrong by panicking"
)]

mod support;

use std::fs;
use std::path::Path;
use support::{Ended, fresh_folder, run};

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

const SCENES: &[Spoiled] = &[
    // TOML itself
    spoiled(CELLS, "cells = [8, 8", &["scene.toml:", "not valid TOML"]),
    spoiled(
        CELLS,
        "cells = [8, 8]\ncells = [9, 9]",
        &["scene.toml:3", "duplicate key"],
    ),
    // keys
    spoiled("[grid]", "[gird]", &["scene.toml:1", "`gird`", "`grid`"]),
    spoiled(
        CELLS,
        "cells = [8, 8]\ncell = 3",
        &["scene.toml:3", "`grid.cell`", "`boundary`"],
    ),
    spoiled(
        STEPS,
        "steps = 4\ndT = 1.0",
        &["scene.toml:5", "`time.dT`", "`dt`"],
    ),
    spoiled(
        SOURCE,
        "circle = { centre = [0.5, 0.5], radius = 0.3 }",
        &["scene.toml:6", "centre", "`center`"],
    ),
    spoiled(
        METHOD,
        "iterations = 1\n[method.admm]\nrho = 1.0",
        &["scene.toml:13", "`method.admm.rho`", "`penalty`"],
    ),
    // missing
    spoiled(CELLS, "", &["`grid.cells` is missing", "two or three"]),
    spoiled("[grid]\ncells = [8, 8]\n", "", &["`grid` is missing"]),
    spoiled(STEPS, "", &["scene.toml:3", "`time.steps` is missing"]),
    spoiled(
        "[source]\ncircle = { center = [0.5, 0.5], radius = 0.3 }\n",
        "",
        &["`source` is missing", "shape"],
    ),
    spoiled(
        "[[keyframe]]\nstep = 4\ncircle = { center = [0.5, 0.6], radius = 0.3 }\n",
        "",
        &["`keyframe` is missing"],
    ),
    spoiled(STEP, "", &["scene.toml:7", "`keyframe[0].step` is missing"]),
    spoiled(SOURCE, "", &["scene.toml:5", "circle, sphere, box"]),
    spoiled(
        SOURCE,
        "circle = { center = [0.5, 0.5] }",
        &["scene.toml:6", "source.circle", "radius"],
    ),
    // types
    spoiled(
        CELLS,
        "cells = \"8\"",
        &["scene.toml:2", "`grid.cells`", "string", "list"],
    ),
    spoiled(
        CELLS,
        "cells = [8, \"8\"]",
        &["scene.toml:2", "`grid.cells[1]`", "whole number"],
    ),
    spoiled(
        CELLS,
        "cells = [8.5, 8]",
        &["`grid.cells[0]`", "8.5", "whole number"],
    ),
    spoiled(
        STEPS,
        "steps = 4.0",
        &["scene.toml:4", "`time.steps`", "whole number"],
    ),
    spoiled(
        STEPS,
        "steps = 4\ndt = \"1\"",
        &["scene.toml:5", "`time.dt`", "a number"],
    ),
    spoiled(
        STEP,
        "step = \"4\"\n",
        &["`keyframe[0].step`", "\"4\"", "whole number"],
    ),
    spoiled(OUTPUT, "frames = 1", &["`output.frames`", "boolean"]),
    spoiled(OUTPUT, "folder = 3", &["`output.folder`", "string"]),
    spoiled("[[keyframe]]", "[keyframe]", &["`keyframe`", "[[keyframe]]"]),
    spoiled("[source]", "[[source]]", &["scene.toml:5", "`source`", "table"]),
    // ranges
    spoiled(
        CELLS,
        "cells = [8]",
        &["scene.toml:2", "`grid.cells` has 1", "2 (a plane) or 3"],
    ),
    spoiled(CELLS, "cells = [8, 8, 8, 8]", &["`grid.cells` has 4"]),
    spoiled(CELLS, "cells = [3, 8]", &["`grid.cells[0]` is 3", "4 to 4096"]),
    spoiled(
        CELLS,
        "cells = [8, 4097]",
        &["`grid.cells[1]` is 4097", "4 to 4096"],
    ),
    spoiled(CELLS, "cells = [8, -8]", &["-8", "4 to 4096"]),
    spoiled(
        CELLS,
        "cells = [8, 8]\nlength = 0.0",
        &["scene.toml:3", "`grid.length` is 0", "above 0"],
    ),
    spoiled(CELLS, "cells = [8, 8]\nlength = nan", &["`grid.length` is NaN"]),
    spoiled(CELLS, "cells = [8, 8]\nlength = inf", &["`grid.length` is inf"]),
    spoiled(
        CELLS,
        "cells = [8, 8]\nboundary = \"open\"",
        &["scene.toml:3", "\"open\"", "\"wall\" or \"periodic\""],
    ),
    spoiled(
        CELLS,
        "cells = [8, 8]\nboundary = [\"wall\"]",
        &["`grid.boundary`", "2 such words"],
    ),
    spoiled(
        CELLS,
        "cells = [8, 8]\nboundary = [\"wall\", 3]",
        &["`grid.boundary[1]` is 3"],
    ),
    spoiled(STEPS, "steps = 1", &["`time.steps` is 1", "from 2"]),
    spoiled(STEPS, "steps = -4", &["`time.steps` is -4"]),
    spoiled(STEPS, "steps = 4\ndt = -0.1", &["`time.dt` is -0.1", "above 0"]),
    spoiled(
        STEP,
        "step = 5\n",
        &["scene.toml:8", "`keyframe[0].step` is 5", "2 to 4"],
    ),
    spoiled(STEP, "step = 1\n", &["`keyframe[0].step` is 1", "2 to 4"]),
    spoiled(METHOD, "iterations = 0", &["`method.iterations` is 0"]),
    spoiled(OUTPUT, "folder = \"\"", &["`output.folder` is empty"]),
    spoiled(
        METHOD,
        "[flow]\nviscosity = -1e-3",
        &["`flow.viscosity` is -0.001", "from 0"],
    ),
    spoiled(
        METHOD,
        "[flow]\nviscosity = 1e30",
        &["`flow.viscosity` is 1e30", "smaller"],
    ),
    spoiled(
        OUTPUT,
        "frames = false\n[control]\nforce_weight = -1.0",
        &["scene.toml:15", "`control.force_weight` is -1"],
    ),
    spoiled(
        OUTPUT,
        "frames = false\n[control]\nforce_weight = 0",
        &["`control.force_weight` is 0", "above 0"],
    ),
    spoiled(
        OUTPUT,
        "frames = false\n[control]\nfilters = \"all\"",
        &["`control.filters` is \"all\"", "\"auto\""],
    ),
    spoiled(
        OUTPUT,
        "frames = false\n[control]\nfilters = 99",
        &["`control.filters` is 99", "0 to 12"],
    ),
    spoiled(
        OUTPUT,
        "frames = false\n[control]\ninitial_velocity = \"fast\"",
        &["`control.initial_velocity`", "\"rest\""],
    ),
    spoiled(
        OUTPUT,
        "frames = false\n[control]\ninitial_velocity = { path = \"v\" }",
        &["initial_velocity", "path", "file"],
    ),
    spoiled(
        OUTPUT,
        "frames = false\n[advection]\nscheme = \"upwind\"",
        &["`advection.scheme` is \"upwind\"", "\"quick\""],
    ),
    spoiled(
        OUTPUT,
        "frames = false\n[advection]\ntolerance = 0",
        &["`advection.tolerance` is 0"],
    ),
    spoiled(
        OUTPUT,
        "frames = false\n[method.admm]\npenalty = -3.0",
        &["`method.admm.penalty` is -3"],
    ),
    spoiled(
        OUTPUT,
        "frames = false\n[method.admm]\nrelaxation = 2.5",
        &["`method.admm.relaxation` is 2.5"],
    ),
    spoiled(
        OUTPUT,
        "frames = false\n[method.admm]\nao_momentum = 1.0",
        &["`method.admm.ao_momentum` is 1", "from 0 up to but not 1"],
    ),
    spoiled(
        OUTPUT,
        "frames = false\n[method.admm]\nnso_norm = \"max\"",
        &["`method.admm.nso_norm` is \"max\"", "\"scaled\" or \"plain\""],
    ),
    spoiled(
        OUTPUT,
        "frames = false\n[method.admm]\nao_iterations = 0",
        &["`method.admm.ao_iterations` is 0"],
    ),
    spoiled(
        OUTPUT,
        "frames = false\n[method.admm]\nnso_tolerance = nan",
        &["`method.admm.nso_tolerance` is NaN"],
    ),
    spoiled(
        OUTPUT,
        "frames = false\n[method.admm]\nnso = \"magic\"",
        &["`method.admm.nso` is \"magic\"", "\"stfas\" or \"newton_cg\""],
    ),
    spoiled(
        OUTPUT,
        "frames = false\n[method.direct]\nhistory = 9",
        &["`method.direct.history`", "9", "1 to 8"],
    ),
    spoiled(
        OUTPUT,
        "frames = false\n[method.direct]\nhistory = \"all\"",
        &["`method.direct.history`", "\"auto\""],
    ),
    spoiled(
        OUTPUT,
        "frames = false\n[method.direct]\ntolerance = 0.0",
        &["`method.direct.tolerance`"],
    ),
    spoiled(
        OUTPUT,
        "frames = false\n[method.direct]\nnested = 1",
        &["`method.direct.nested`", "boolean"],
    ),
    spoiled(
        OUTPUT,
        "frames = false\n[method.admm]\nsmoother_colours = \"blue\"",
        &["\"blue\"", "\"red_black\" or \"2^d\""],
    ),
    spoiled(
        OUTPUT,
        "frames = false\n[method.projection]\ntolerance = -1",
        &["`method.projection.tolerance` is -1"],
    ),
    spoiled(
        STEPS,
        "steps = 4\ndt = 1e-200",
        &["`control.force_weight`", "`time.dt`"],
    ),
    // two keyframes at one step
    spoiled(
        "[method]",
        "[[keyframe]]\nstep = 4\ncircle = { center = [0.5, 0.5], radius = 0.3 }\n[method]",
        &["`keyframe[1].step` is 4", "`keyframe[0]`"],
    ),
    // not there yet
    spoiled(
        METHOD,
        "name = \"simulate\"",
        &["`method.name` is \"simulate\"", "\"lbfgs\"", "\"pd\""],
    ),
    spoiled(
        METHOD,
        "[method.lbfgs]\nhistory = 9",
        &["`method.lbfgs.history` is 9", "from 1 to 8"],
    ),
    spoiled(
        METHOD,
        "[method.lbfgs]\ntolerance = 1.0",
        &["`method.lbfgs.tolerance` is 1", "below 1"],
    ),
    spoiled(
        METHOD,
        "[method.pd]\ndrive = -1.0",
        &["`method.pd.drive` is -1", "from 0"],
    ),
    spoiled(
        METHOD,
        "[method.pd]\nattenuation = nan",
        &["`method.pd.attenuation` is NaN", "from 0"],
    ),
    spoiled(
        METHOD,
        "[method.pd]\ngathering = inf",
        &["`method.pd.gathering` is inf", "from 0"],
    ),
    spoiled(
        METHOD,
        "[simulation]\nbuoyancy = inf",
        &["`simulation.buoyancy` is inf", "finite"],
    ),
    spoiled(
        METHOD,
        "[simulation]\ntolerance = 0.0",
        &["`simulation.tolerance` is 0", "above 0"],
    ),
    spoiled(
        METHOD,
        "name = \"newton\"",
        &["`method.name` is \"newton\"", "\"admm\""],
    ),
    spoiled(
        METHOD,
        "[method.direct]\nhistory = 0",
        &["`method.direct.history` is 0", "from 1 to 8"],
    ),
    spoiled(
        TARGET,
        "mesh = \"x.obj\"",
        &["scene.toml:9", "`keyframe[0].mesh`", "not there yet"],
    ),
    spoiled(
        SOURCE,
        "shapes = [{ mesh = \"x.obj\" }]",
        &["scene.toml:6", "`source.shapes[0].mesh`", "not there yet"],
    ),
    spoiled(
        TARGET,
        "file = \"x.vdb\"",
        &["`keyframe[0].file`", "OpenVDB", ".npy"],
    ),
    // shapes
    spoiled(
        SOURCE,
        "circle = { center = [0.5, 0.5], radius = -0.3 }",
        &["scene.toml:6", "circle.radius", "-0.3", "above 0"],
    ),
    spoiled(
        SOURCE,
        "circle = { center = [0.5, nan], radius = 0.3 }",
        &["scene.toml:6", "circle.center", "NaN"],
    ),
    spoiled(
        SOURCE,
        "circle = { center = [0.5, 0.5, 0.5], radius = 0.3 }",
        &["circle.center", "3 numbers", "2D"],
    ),
    spoiled(
        SOURCE,
        "circle = { center = [7.0, 7.0], radius = 0.3 }",
        &["in source", "no smoke"],
    ),
    spoiled(
        SOURCE,
        "density = 0.0\ncircle = { center = [0.5, 0.5], radius = 0.3 }",
        &["density", "above 0"],
    ),
    spoiled(
        SOURCE,
        "density = -1.0\ncircle = { center = [0.5, 0.5], radius = 0.3 }",
        &["density", "-1"],
    ),
    spoiled(SOURCE, "shapes = []", &["shapes", "empty"]),
    spoiled(
        SOURCE,
        "text = \"F\"\ncircle = { center = [0.5, 0.5], radius = 0.3 }",
        &["in source", "two shapes"],
    ),
    spoiled(
        TARGET,
        "box = { min = [0.8, 0.2], max = [0.2, 0.8] }",
        &["scene.toml:9", "keyframe[0]", "box.max"],
    ),
    // files that are not there
    unreadable(
        TARGET,
        "image = \"missing.png\"",
        &["scene.toml:9", "missing.png"],
    ),
    unreadable(TARGET, "file = \"missing.npy\"", &["scene.toml:9", "missing.npy"]),
    unreadable(
        OUTPUT,
        "frames = false\n[control]\ninitial_velocity = { file = \"missing.npz\" }",
        &["scene.toml:15", "missing.npz"],
    ),
    // files that hold something else
    spoiled(TARGET, "file = \"garbage.npy\"", &["scene.toml:9", "garbage.npy"]),
    spoiled(
        TARGET,
        "image = \"garbage.png\"",
        &["scene.toml:9", "garbage.png"],
    ),
    spoiled(TARGET, "file = \"nan.npy\"", &["scene.toml:9", "nan.npy"]),
    spoiled(
        OUTPUT,
        "frames = false\n[control]\ninitial_velocity = { file = \"garbage.npz\" }",
        &["garbage.npz"],
    ),
];

/// A file of two by two doubles, the last of them NaN.
fn nan_file() -> Vec<u8> {
    let mut header = String::from("{'descr': '<f8', 'fortran_order': False, 'shape': (2, 2), }");
    while (10 + header.len() + 1) % 64 != 0 {
        header.push(' ');
    }
    header.push('\n');
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend(u16::try_from(header.len()).unwrap().to_le_bytes());
    bytes.extend(header.as_bytes());
    [1.0, 1.0, 1.0, f64::NAN]
        .iter()
        .for_each(|value: &f64| bytes.extend(value.to_le_bytes()));
    bytes
}

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
fn wrong_scenes_are_refused_with_their_place() {
    let folder = fresh_folder("refused_scenes");
    fs::write(folder.join("garbage.npy"), "this is no array").unwrap();
    fs::write(folder.join("garbage.npz"), "this is no archive").unwrap();
    fs::write(folder.join("garbage.png"), "this is no picture").unwrap();
    fs::write(folder.join("nan.npy"), nan_file()).unwrap();
    let (scene, out) = (folder.join("scene.toml"), folder.join("out"));
    let mut complaints = String::new();
    for case in SCENES {
        assert!(GOOD.contains(case.from), "{}", case.from);
        fs::write(&scene, GOOD.replacen(case.from, case.to, 1)).unwrap();
        let ended = run(&["solve", scene.to_str().unwrap()]);
        complaints += &complaint(case.to, &ended, case.code, case.words);
        if ended.err.trim_end().lines().count() != 1 || out.exists() {
            complaints += &format!(
                "{}\n    more than one line, or something was written: {}\n",
                case.to, ended.err
            );
        }
    }
    assert!(complaints.is_empty(), "\n{complaints}");
}

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
