//! Scenes that Stable Fluids solve, plan, compare and simulate, and those that it refuses.

use crate::support::npz::{Array, npy, read, write};
use crate::support::{Ended, fresh_folder, json, run};
use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};

const SCENE: &str = "\
[grid]
cells = [20, 16]
length = 2.0
[time]
steps = 6
dt = 0.5
[source]
circle = { center = [0.6, 0.7], radius = 0.3 }
[[keyframe]]
step = 1
weight = 0.5
circle = { center = [0.65, 0.7], radius = 0.3 }
[[keyframe]]
step = 6
circle = { center = [1.2, 0.8], radius = 0.3 }
[flow]
viscosity = 1e-4
buoyancy = 0.01
[control]
force_weight = 0.5
[method]
name = \"stable_fluids\"
iterations = 6
[method.stable_fluids]
control = [\"initial_velocity\", \"templates\"]
[[template]]
kind = \"wind\"
center = [0.6, 0.6]
radius = 0.4
interval = 2
[[template]]
kind = \"vortex\"
center = [1.0, 0.8]
radius = 0.3
from = 1
move = true
amplitude = 0.05
[output]
frames = false
";

/// Writes the scene into a fresh folder and runs a command on it, which writes into `out` there.
fn ran(test: &str, scene: &str, command: &str, more: &[&str]) -> (PathBuf, Ended) {
    let folder = fresh_folder(test);
    let (path, out) = (folder.join("scene.toml"), folder.join("out"));
    fs::write(&path, scene).unwrap();
    let written = ["-o", out.to_str().unwrap()];
    let arguments = [command, path.to_str().unwrap()];
    let written: &[&str] = if command == "plan" { &[] } else { &written };
    let ended = run(&[&arguments[..], written, more].concat());
    (out, ended)
}

fn solved(test: &str, scene: &str, command: &str, more: &[&str]) -> (PathBuf, Value) {
    let (out, ended) = ran(test, scene, command, &[more, &["--quiet"]].concat());
    assert!(
        matches!(ended.code, 0 | 5),
        "{test}: {}, {}",
        ended.code,
        ended.err
    );
    let report = fs::read_to_string(out.join("report.json")).unwrap();
    (out, serde_json::from_str(&report).unwrap())
}

fn shape(array: &Array) -> &[usize] {
    &array.shape
}

#[test]
fn a_result_is_not_written_over_unasked() {
    let (out, _) = solved("stable_fluids_twice", SCENE, "solve", &[]);
    let scene = out.with_file_name("scene.toml");
    let again = [
        "solve",
        scene.to_str().unwrap(),
        "-o",
        out.to_str().unwrap(),
        "--quiet",
    ];
    let refused = run(&again);
    assert!(
        refused.code == 4 && refused.err.contains("--force"),
        "{}",
        refused.err
    );
    let forced = run(&[&again[..], &["--force"]].concat());
    assert!(matches!(forced.code, 0 | 5), "{}", forced.err);
}

#[test]
fn a_result_has_what_the_chapter_says() {
    let (out, report) = solved("stable_fluids_result", SCENE, "solve", &["--precision", "f64"]);
    let arrays = read(&out.join("result.npz"));
    assert_eq!(shape(&arrays["density"]), [7, 16, 20]);
    assert_eq!(shape(&arrays["velocity_x"]), [7, 16, 20]);
    assert_eq!(shape(&arrays["velocity_y"]), [7, 16, 20]);
    assert_eq!(shape(&arrays["force_y"]), [6, 16, 20]);
    assert_eq!(shape(&arrays["template_0_amplitude"]), [3, 2]);
    assert_eq!(shape(&arrays["template_1_amplitude"]), [1, 1]);
    assert_eq!(shape(&arrays["template_1_center"]), [2]);
    assert_eq!(shape(&arrays["template_1_radius"]), [0; 0]);
    assert!(!arrays.contains_key("velocity_z"));

    assert_eq!(report["method"], "stable_fluids");
    assert_eq!(report["velocity_location"], "center");
    assert_eq!(report["slots"], 0);
    assert_eq!(report["recomputed_steps"], 0);
    let chosen = &report["stable_fluids"];
    assert_eq!(
        chosen["control"],
        serde_json::json!(["initial_velocity", "templates"])
    );
    for (key, value) in [
        ("pressure", serde_json::json!("gauss_seidel")),
        ("sweeps", serde_json::json!(20)),
        ("cg_iterations", serde_json::json!(200)),
        ("cg_tolerance", serde_json::json!(1e-5)),
        ("adjoint", serde_json::json!("exact")),
        ("diffusion", serde_json::json!(0.0)),
        ("initial_weight", serde_json::json!(10.0)),
        ("slots", serde_json::json!(0)),
        ("history", serde_json::json!(5)),
        ("tolerance", serde_json::json!(1e-4)),
    ] {
        assert_eq!(chosen[key], value, "{key}");
    }
    let objective = &report["objective"];
    let part = |key: &str| objective[key].as_f64().unwrap();
    assert!(part("initial") > 0.0);
    let sum = part("data") + part("force") + part("initial");
    assert!((sum - part("total")).abs() < 1e-12 * sum);
    let history = report["history"].as_array().unwrap();
    for key in [
        "iteration",
        "seconds",
        "data",
        "force",
        "initial",
        "total",
        "evaluations",
        "recomputed_steps",
    ] {
        assert!(!history[0][key].is_null(), "{key}");
    }
    let total = |row: &Value| row["total"].as_f64().unwrap();
    assert!(total(history.last().unwrap()) < total(&history[0]));
    let keyframes = report["keyframes"].as_array().unwrap();
    assert_eq!(keyframes.len(), 2);
    assert!(
        keyframes
            .iter()
            .all(|keyframe| keyframe["mass_factor"].as_f64().unwrap() > 0.0)
    );
    // The price of the force, from the arrays: r/2 sum of f^2 in units of dt and length, with the whole force.
    let squares: f64 = ["force_x", "force_y"]
        .iter()
        .flat_map(|name| &arrays[*name].data)
        .map(|f| f * f)
        .sum();
    assert!(
        (0.25 * squares - part("force")).abs() < 1e-9 * part("force"),
        "{squares} {}",
        part("force")
    );
    // The mass at each keyframe's step, over that of the source.
    let mass = |step: usize| arrays["density"].data[320 * step..][..320].iter().sum::<f64>();
    for keyframe in keyframes {
        let expected = mass(keyframe["step"].as_u64().unwrap() as usize) / mass(0);
        let found = keyframe["mass_ratio"].as_f64().unwrap();
        assert!((found - expected).abs() < 1e-12, "{found}, not {expected}");
    }
    let page = fs::read_to_string(out.join("report.html")).unwrap();
    assert!(page.contains("stable_fluids"));
    let ratio = keyframes[1]["mass_ratio"].as_f64().unwrap();
    let said = format!(
        "The smoke has {} % of the mass of the source.",
        (1000.0 * ratio).round() / 10.0
    );
    assert!(page.contains(&said), "{said}");
}

/// The flow of a result, from its own velocity at the start and its templates, is the flow that is simulated.
#[test]
fn a_simulation_goes_where_the_result_went() {
    let only = SCENE
        .replace("\"initial_velocity\", \"templates\"", "\"initial_velocity\"")
        .replace("move = true\n", "");
    let (out, _) = solved("stable_fluids_found", &only, "solve", &["--precision", "f64"]);
    let found = read(&out.join("result.npz"));
    let start = out.with_file_name("v0.npz");
    let first = |name| (name, npy(&[16, 20], &found[name].data[..320]));
    write(&start, &["velocity_x", "velocity_y"].map(first));
    let given = format!("control.initial_velocity={{ file = \"{}\" }}", start.display());
    let kept = fs::read(&start).unwrap();
    let folder = fresh_folder("stable_fluids_free");
    fs::write(folder.join("v0.npz"), kept).unwrap();
    fs::write(folder.join("scene.toml"), &only).unwrap();
    let given = given.replace(start.to_str().unwrap(), "v0.npz");
    let (scene, result) = (folder.join("scene.toml"), folder.join("out"));
    let ended = run(&[
        "simulate",
        scene.to_str().unwrap(),
        "--solver",
        "stable_fluids",
        "--quiet",
        "-o",
        result.to_str().unwrap(),
        "--set",
        &given,
    ]);
    assert_eq!(ended.code, 0, "{}", ended.err);
    let free = read(&result.join("result.npz"));
    assert_eq!(free["density"].shape, found["density"].shape);
    let gap = free["density"]
        .data
        .iter()
        .zip(&found["density"].data)
        .fold(0.0, |most: f64, (a, b)| most.max((a - b).abs()));
    assert!(gap < 1e-9, "{gap:e}");
    let report: Value =
        serde_json::from_str(&fs::read_to_string(result.join("report.json")).unwrap()).unwrap();
    assert_eq!(report["status"], "converged");
    assert_eq!(report["stable_fluids"]["control"], serde_json::json!([]));
}

#[test]
fn any_ceiling_gives_the_same_arrays() {
    let (out, report) = solved("stable_fluids_all", SCENE, "solve", &[]);
    let bytes = report["memory"]["planned_bytes"].as_u64().unwrap();
    let slots = |test: &str, more: &[&str]| solved(test, SCENE, "solve", more);
    let (three, kept) = slots("stable_fluids_three", &["--set", "method.stable_fluids.slots=3"]);
    assert_eq!(
        (&kept["slots"], &kept["recomputed_steps"]),
        (&Value::from(3), &Value::from(7))
    );
    let limit = format!("{}B", bytes + 15);
    let limit = limit.trim_end_matches('B');
    let (less, fewer) = slots("stable_fluids_less", &["--memory-limit", limit]);
    assert!(fewer["slots"].as_u64().unwrap() > 0, "{}", fewer["slots"]);
    let array = |folder: &Path| fs::read(folder.join("result.npz")).unwrap();
    assert!(array(&out) == array(&three) && array(&out) == array(&less));
    let short = kept["memory"]["planned_bytes"].as_u64().unwrap() - 1;
    let limit = ["--memory-limit", &short.to_string()];
    let more = [&["--set", "method.stable_fluids.slots=3"], &limit[..]].concat();
    let (_, ended) = ran("stable_fluids_too_many", SCENE, "solve", &more);
    assert_eq!(ended.code, 3, "{}", ended.err);
    let said = "or set `method.stable_fluids.slots` to \"auto\"";
    assert!(ended.err.contains(said), "{}", ended.err);
    let (_, ended) = ran("stable_fluids_none", SCENE, "solve", &["--memory-limit", "64KiB"]);
    assert_eq!(ended.code, 3);
    assert!(
        ended.err.contains("stable_fluids needs") && ended.err.contains("--memory-limit"),
        "{}",
        ended.err
    );
}

#[test]
fn a_plan_names_slots_and_the_next_ceiling() {
    let (_, ended) = ran(
        "stable_fluids_plan",
        SCENE,
        "plan",
        &["--set", "method.stable_fluids.slots=3"],
    );
    assert_eq!(ended.code, 0, "{}", ended.err);
    for words in [
        "method stable_fluids",
        "states that are kept",
        "slots 3: a gradient repeats 7 steps",
        "is the ceiling of the next: slots 4",
    ] {
        assert!(ended.out.contains(words), "{words}: {}", ended.out);
    }
    let exact = SCENE.replace("control = [", "pressure = \"cg\"\nslots = 1\ncontrol = [");
    let (_, ended) = ran("stable_fluids_plan_cg", &exact, "plan", &[]);
    assert!(ended.out.contains("second_solve"), "{}", ended.out);
    let forces = SCENE.replace("\"initial_velocity\", \"templates\"", "\"forces\"");
    let (_, ended) = ran(
        "stable_fluids_plan_forces",
        &forces,
        "plan",
        &["--set", "method.stable_fluids.slots=1"],
    );
    assert!(ended.out.contains("vectors of the search"), "{}", ended.out);
}

#[test]
fn it_is_compared_with_the_others() {
    let scene = SCENE.replace("step = 1\n", "step = 2\n");
    let scene = scene
        .split("[[template]]")
        .next()
        .unwrap()
        .replace(", \"templates\"", "");
    let (out, ended) = ran(
        "stable_fluids_compare",
        &format!("{scene}[output]\nframes = false\n"),
        "compare",
        &[
            "--methods",
            "direct,stable_fluids",
            "--quiet",
            "--set",
            "method.iterations=3",
        ],
    );
    assert_eq!(ended.code, 0, "{}", ended.err);
    let facts: Value = serde_json::from_str(&fs::read_to_string(out.join("compare.json")).unwrap()).unwrap();
    let methods: Vec<&str> = facts["rows"]
        .as_array()
        .unwrap()
        .iter()
        .map(|row| row["method"].as_str().unwrap())
        .collect();
    assert_eq!(methods, ["direct", "stable_fluids"]);
    assert!(out.join("stable_fluids/result.npz").exists());
    // Its J in the table is that of its flow on the grid of the others; its own stands beside it.
    let number = |value: &Value| value.as_f64().unwrap();
    let [direct, row] = [0, 1].map(|row| &facts["rows"][row]);
    let [of_direct, report] =
        ["direct", "stable_fluids"].map(|method| json(&out.join(method).join("report.json")));
    let (there, own) = (&row["objective"], &report["objective"]);
    assert_eq!(&row["own_objective"], own);
    assert_ne!(there["total"], own["total"]);
    assert!(
        number(&there["force"]) > 0.0 && own["force"] == 0.0,
        "{there} {own}"
    );
    assert!(
        number(&own["initial"]) > 0.0 && there["initial"].is_null(),
        "{there} {own}"
    );
    let parts = number(&there["data"]) + number(&there["force"]);
    assert!((number(&there["total"]) - parts).abs() < 1e-12 * parts, "{there}");
    assert_eq!(
        (&direct["objective"], direct["own_objective"].is_null()),
        (&of_direct["objective"], true)
    );
    // The staggered grid keeps the mass, and does not speak of it.
    assert!(of_direct["keyframes"][0]["mass_ratio"].is_null());
}

/// What cannot be brought to the grid of the others is refused before anything is solved, and all are priced alike.
#[test]
fn what_is_compared_is_the_same_problem() {
    let plain = |step: &str| {
        let scene = SCENE.replace("step = 1\n", step);
        let scene = scene
            .split("[[template]]")
            .next()
            .unwrap()
            .replace(", \"templates\"", "");
        format!("{scene}[output]\nframes = false\n")
    };
    let by = |test: &str, step: &str, methods: &str| {
        let options = ["--methods", methods, "--quiet", "--set", "method.iterations=2"];
        ran(test, &plain(step), "compare", &options)
    };
    let (out, early) = by("stable_fluids_early", "step = 1\n", "stable_fluids");
    assert_eq!(early.code, 2, "{}", early.err);
    assert!(!out.join("stable_fluids").exists());
    let (out, ended) = by("stable_fluids_priced", "step = 2\n", "admm,stable_fluids");
    assert!(matches!(ended.code, 0 | 5), "{}", ended.err);
    let facts = json(&out.join("compare.json"));
    assert!(
        facts["note"]
            .as_str()
            .unwrap()
            .contains("admm cannot price curls"),
        "{facts}"
    );
    let row = &facts["rows"][1]["objective"];
    assert_eq!(
        row["force"], row["force_plain"],
        "no price of curls is in it: {row}"
    );
}

/// The paper's scenes by Stable Fluids, whose arrays are there as long as they are needed.
#[test]
fn a_scene_of_the_paper_by_stable_fluids() {
    let folder = fresh_folder("stable_fluids_paper").join("out");
    let ended = run(&[
        "paper",
        "fluid",
        "--scale",
        "1/8",
        "--methods",
        "stable_fluids",
        "--set",
        "method.iterations=1",
        "--quiet",
        "--no-pictures",
        "-o",
        folder.to_str().unwrap(),
    ]);
    assert!(matches!(ended.code, 0 | 5), "{}", ended.err);
    let facts = json(&folder.join("paper.json"));
    let scene = &facts["scenes"][0];
    assert_eq!(scene["rows"][0]["method"], "stable_fluids");
    let result = folder.join(scene["name"].as_str().unwrap()).join("stable_fluids");
    assert!(result.join("report.json").exists() && !result.join("result.npz").exists());
}

#[test]
fn what_is_refused_is_named() {
    let cases: &[(&str, &str, &[&str])] = &[
        (
            "control = [\"initial_velocity\", \"templates\"]",
            "control = [\"winds\"]",
            &["`method.stable_fluids.control[0]` is \"winds\"", "\"forces\""],
        ),
        (
            "control = [\"initial_velocity\", \"templates\"]",
            "control = []",
            &["`method.stable_fluids.control` is empty"],
        ),
        (
            "control = [\"initial_velocity\", \"templates\"]",
            "slots = 7",
            &["`method.stable_fluids.slots` is 7", "6 steps"],
        ),
        (
            "control = [\"initial_velocity\", \"templates\"]",
            "slots = \"many\"",
            &["`method.stable_fluids.slots` is \"many\"", "\"auto\""],
        ),
        (
            "control = [\"initial_velocity\", \"templates\"]",
            "adjoint = \"second_solve\"",
            &["`method.stable_fluids.adjoint` is second_solve", "\"cg\""],
        ),
        (
            "control = [\"initial_velocity\", \"templates\"]",
            "sweep = 3",
            &["no key `sweep`"],
        ),
        (
            "control = [\"initial_velocity\", \"templates\"]",
            "pressure = \"sor\"",
            &[
                "`method.stable_fluids.pressure` is \"sor\"",
                "\"gauss_seidel\" or \"cg\"",
            ],
        ),
        ("radius = 0.4\n", "radius = 0.0\n", &["`template[0].radius` is 0"]),
        ("interval = 2", "interval = 0", &["`template[0].interval` is 0"]),
        (
            "center = [0.6, 0.6]",
            "center = [0.6, 2.6]",
            &["`template[0].center[1]` is 2.6", "outside the box"],
        ),
        ("from = 1\n", "from = 1\nto = 1\n", &["`template[1].to` is 1"]),
        (
            "kind = \"wind\"",
            "kind = \"attract\"",
            &["`template[0].kind`", "\"wind\" or \"vortex\""],
        ),
        ("step = 1\n", "step = 0\n", &["`keyframe[0].step` is 0", "1 to 6"]),
        ("step = 6\n", "step = 7\n", &["`keyframe[1].step` is 7", "1 to 6"]),
        (
            "[flow]",
            "[[obstacle]]\nbox = { min = [0.0, 0.0], max = [0.3, 0.3] }\n[flow]",
            &["`obstacle`", "stable_fluids"],
        ),
        (
            "[flow]",
            "[[emitter]]\nrate = 0.1\nbox = { min = [0.0, 0.0], max = [0.3, 0.3] }\n[flow]",
            &["`emitter`", "stable_fluids"],
        ),
        (
            "length = 2.0",
            "length = 2.0\nboundary = [\"open\", \"wall\"]",
            &["`grid.boundary`", "stable_fluids"],
        ),
        (
            "iterations = 6",
            "iterations = 6\nwindow = 4",
            &["`method.window`", "stable_fluids"],
        ),
    ];
    for (index, (from, to, said)) in cases.iter().enumerate() {
        let scene = SCENE.replacen(from, to, 1);
        assert_ne!(scene, SCENE, "{from}");
        let (_, ended) = ran(
            &format!("stable_fluids_refused_{index}"),
            &scene,
            "solve",
            &["--set", "control.match_mass=false"],
        );
        assert_eq!(ended.code, 2, "{to}: {} {}", ended.out, ended.err);
        for words in *said {
            assert!(ended.err.contains(words), "{to}: {words}: {}", ended.err);
        }
    }
    let bare = SCENE.split("[[template]]").next().unwrap().to_owned();
    let (_, ended) = ran("stable_fluids_refused_bare", &bare, "solve", &[]);
    assert!(ended.err.contains("no [[template]]"), "{}", ended.err);
}
