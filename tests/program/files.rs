//! New scenes, files that are read, and what a solve says and writes.

use crate::support::verify::{Outcome, verify};
use crate::support::{fresh_folder, npz, run, solve_example};
use serde_json::Value;
use std::fs;
use std::path::Path;

#[test]
fn a_new_scene_solves_as_it_is() {
    let folder = fresh_folder("new_scene");
    let name = folder.join("my smoke");
    let ended = run(&["new", name.to_str().unwrap()]);
    assert_eq!((ended.code, ended.err.as_str()), (0, ""));
    let scene = folder.join("my smoke.toml");
    let schema: Value = crate::support::json(&folder.join("thurible.schema.json"));
    assert_eq!(schema["title"], "A scene for thurible");
    assert!(
        fs::read_to_string(&scene)
            .unwrap()
            .starts_with("#:schema ./thurible.schema.json\n")
    );
    let ended = run(&[
        "solve",
        scene.to_str().unwrap(),
        "--quiet",
        "--set",
        "method.iterations=3",
    ]);
    assert_eq!((ended.code, ended.out.as_str(), ended.err.as_str()), (0, "", ""));
    let out = folder.join("out/my smoke");
    verify("new", &out);
    assert!(out.join("report.html").exists());
    assert!(fs::read_dir(out.join("frames")).unwrap().count() >= 17);
}

/// An initial velocity of its own: a whirl, taken from the result of an earlier solve.
#[test]
fn initial_velocity_from_a_file() {
    let first = solve_example(
        "small_central",
        "initial_velocity_first",
        &["--set", "method.iterations=2"],
    );
    let arrays = npz::read(&first.join("result.npz"));
    let file = fresh_folder("initial_velocity_file").join("v0.npz");
    let mut zip = zip::ZipWriter::new(fs::File::create(&file).unwrap());
    for name in ["velocity_x", "velocity_y"] {
        let array = &arrays[name];
        let (size, shape) = (array.shape[1] * array.shape[2], &array.shape[1..]);
        let mut header = format!(
            "{{'descr': '<f8', 'fortran_order': False, 'shape': ({}, {}), }}",
            shape[0], shape[1]
        );
        header.push_str(&" ".repeat(63 - (10 + header.len()) % 64));
        header.push('\n');
        zip.start_file(format!("{name}.npy"), zip::write::SimpleFileOptions::default())
            .unwrap();
        let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
        bytes.extend(u16::try_from(header.len()).unwrap().to_le_bytes());
        bytes.extend(header.as_bytes());
        array.data[4 * size..5 * size]
            .iter()
            .for_each(|value| bytes.extend(value.to_le_bytes()));
        std::io::Write::write_all(&mut zip, &bytes).unwrap();
    }
    zip.finish().unwrap();
    let setting = format!("control.initial_velocity={{file={:?}}}", file.to_str().unwrap());
    let outcome = verify(
        "initial velocity",
        &solve_example(
            "small_central",
            "initial_velocity",
            &["--set", &setting, "--set", "method.iterations=3"],
        ),
    );
    assert!(
        outcome.velocity[0].iter().any(|field| field.max_abs() > 0.0),
        "v_0 is 0"
    );
}

#[test]
fn json_lines_tell_the_whole_story() {
    let folder = fresh_folder("json_lines").join("out");
    let ended = run(&[
        "solve",
        "examples/small_central.toml",
        "--json",
        "--method",
        "admm",
        "--set",
        "method.iterations=3",
        "--set",
        "output.frames=false",
        "-o",
        folder.to_str().unwrap(),
    ]);
    assert!(ended.err.is_empty(), "{}", ended.err);
    let lines: Vec<Value> = ended
        .out
        .lines()
        .map(|line| serde_json::from_str(line).unwrap())
        .collect();
    let of = |event: &str| {
        lines
            .iter()
            .filter(|line| line["event"] == event)
            .collect::<Vec<_>>()
    };
    assert_eq!(of("plan").len(), 1);
    assert_eq!(of("iteration").len(), 3);
    let result = of("result")[0];
    assert_eq!(result["exit_code"], ended.code);
    assert_eq!(result["status"], "max_iterations");
    assert_eq!(Path::new(result["folder"].as_str().unwrap()), folder);
    assert_eq!(lines.last().unwrap()["event"], "result");
    assert_eq!(
        of("iteration")[2]["total"],
        Outcome::read(&folder).report["history"][2]["total"]
    );
}

#[test]
fn a_result_is_replaced_and_the_users_own_files_stay() {
    let folder = solve_example("small_central", "replaced", &["--set", "method.iterations=1"]);
    fs::write(folder.join("notes.txt"), "mine").unwrap();
    let before = fs::read(folder.join("result.npz")).unwrap();
    let ended = run(&[
        "solve",
        "examples/small_central.toml",
        "--quiet",
        "--force",
        "--set",
        "method.iterations=2",
        "--set",
        "output.frames=false",
        "-o",
        folder.to_str().unwrap(),
    ]);
    assert_eq!(ended.code, 0, "{}", ended.err);
    assert_ne!(before, fs::read(folder.join("result.npz")).unwrap());
    assert_eq!(fs::read_to_string(folder.join("notes.txt")).unwrap(), "mine");
    let hidden = fs::read_dir(&folder).unwrap().filter(|entry| {
        entry
            .as_ref()
            .unwrap()
            .file_name()
            .to_string_lossy()
            .starts_with('.')
    });
    assert_eq!(hidden.count(), 0);
}
