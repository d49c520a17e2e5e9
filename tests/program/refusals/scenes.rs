//! Scenes that are refused: their keys, types, shapes and files.

use super::effects::EFFECTS;
use super::templates::TEMPLATES;
use super::values::VALUES;
use super::{
    CELLS, GOOD, METHOD, OUTPUT, SOURCE, STEP, STEPS, Spoiled, TARGET, complaint, spoiled, unreadable,
};
use crate::support::{fresh_folder, run};
use std::fs;

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
    // two keyframes at one step
    spoiled(
        "[method]",
        "[[keyframe]]\nstep = 4\ncircle = { center = [0.5, 0.5], radius = 0.3 }\n[method]",
        &["`keyframe[1].step` is 4", "`keyframe[0]`"],
    ),
    spoiled(
        "[method]",
        "[[keyframe]]\nstep = 4\ncircle = { center = [0.5, 0.5], radius = 0.3 }\n[[keyframe]]\nstep = 2\n\
         circle = { center = [0.5, 0.5], radius = 0.3 }\n[method]",
        &[
            "`keyframe[1].step` is 4",
            "`keyframe[0]` stands at that step already",
        ],
    ),
    // a hold beyond the end
    spoiled(
        STEP,
        "step = 4\nhold = 1\n",
        &[
            "scene.toml:9",
            "`keyframe[0].hold` is 1",
            "from step 4 beyond the end",
            "the scene ends at step 4",
            "raise `time.steps`, or lower it to at most 0",
        ],
    ),
    spoiled(
        STEP,
        "step = 2\nhold = 9223372036854775807\n",
        &[
            "`keyframe[0].hold` is 9223372036854775807",
            "ends at step 4",
            "lower it to at most 2",
        ],
    ),
    // a keyframe where another is held, before or after it in the file
    spoiled(
        STEP,
        "step = 3\nhold = 1\ncircle = { center = [0.5, 0.5], radius = 0.3 }\n[[keyframe]]\nstep = 4\n",
        &[
            "scene.toml:12",
            "`keyframe[1].step` is 4",
            "`keyframe[0].hold` keeps `keyframe[0]` there, from step 3 to step 4; give",
        ],
    ),
    spoiled(
        STEP,
        "step = 3\nhold = 1\ncircle = { center = [0.5, 0.5], radius = 0.3 }\n[[keyframe]]\nstep = 3\n",
        &["`keyframe[1].step` is 3", "`keyframe[0].hold`"],
    ),
    spoiled(
        "[method]",
        "[[keyframe]]\nstep = 2\nhold = 2\ncircle = { center = [0.5, 0.5], radius = 0.3 }\n[method]",
        &[
            "scene.toml:12",
            "`keyframe[1].hold` is 2",
            "from step 2 to step 4",
            "`keyframe[0]` stands at step 4",
            "lower it to at most 1",
        ],
    ),
    // a hold that is no whole number from 0 on, or of another name
    spoiled(
        STEP,
        "step = 2\nhold = \"long\"\n",
        &[
            "`keyframe[0].hold` is \"long\"",
            "whole number from 0 to 2 is allowed",
        ],
    ),
    spoiled(
        STEP,
        "step = 2\nhold = 1.0\n",
        &["`keyframe[0].hold` is 1.0", "whole number from 0 to 2"],
    ),
    spoiled(
        STEP,
        "step = 2\nhold = -1\n",
        &["`keyframe[0].hold` is -1", "whole number from 0 to 2"],
    ),
    spoiled(
        STEP,
        "step = 2\nholds = 1\n",
        &[
            "scene.toml:9",
            "`keyframe[0].holds`",
            "no key `holds` here",
            "`step`, `steps`, `files`, `hold`, `region`, `circle`",
            "`fit`",
        ],
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
        "[simulation]\nbuoyancy = 1e-3",
        &[
            "scene.toml:12: `simulation.buoyancy`",
            "its place is `flow.buoyancy`",
            "write it under [flow]",
        ],
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
        &["in source", "puts nothing into the box"],
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

#[test]
fn wrong_scenes_are_refused_with_their_place() {
    let folder = fresh_folder("refused_scenes");
    fs::write(folder.join("garbage.npy"), "this is no array").unwrap();
    fs::write(folder.join("garbage.npz"), "this is no archive").unwrap();
    fs::write(folder.join("garbage.png"), "this is no picture").unwrap();
    fs::write(folder.join("nan.npy"), nan_file()).unwrap();
    let (scene, out) = (folder.join("scene.toml"), folder.join("out"));
    let mut complaints = String::new();
    for case in SCENES.iter().chain(VALUES).chain(EFFECTS).chain(TEMPLATES) {
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
