//! A scene with every value of some keys; and what shells and `man` are told.

use crate::checkpoints::{ended, folder_with, killed};
use crate::support::{fresh_folder, json, run, thurible};
use serde_json::Value;
use std::fs;
use std::process::Stdio;

const SCENE: &str = "\
[grid]
cells = [12, 12]
[time]
steps = 4
[source]
circle = { center = [0.4, 0.5], radius = 0.25 }
[[keyframe]]
step = 4
circle = { center = [0.6, 0.5], radius = 0.25 }
[method]
iterations = 2
";

#[test]
fn every_combination_is_solved_once() {
    let folder = fresh_folder("sweep");
    let (scene, out) = (folder.join("scene.toml"), folder.join("out"));
    fs::write(&scene, SCENE).unwrap();
    let sweep = |more: &[&str]| {
        let vary = [
            "--vary",
            "control.force_weight=1e2,1e4",
            "--vary",
            "method.iterations=1,2",
        ];
        let first = ["sweep", scene.to_str().unwrap(), "-o", out.to_str().unwrap()];
        run(&[&first[..], &vary, more].concat())
    };
    let listed = sweep(&["--list"]);
    assert_eq!(
        (listed.code, listed.out.lines().count()),
        (0, 4),
        "{}",
        listed.err
    );
    let listed = sweep(&["--list", "--json"]);
    let third: Value = serde_json::from_str(listed.out.lines().nth(2).unwrap()).unwrap();
    assert_eq!(third["number"], 3);
    assert_eq!(third["set"][0], "control.force_weight=1e4");
    assert!(!out.exists());
    let one = sweep(&["--only", "2", "--quiet"]);
    assert!(matches!(one.code, 0 | 5), "{}", one.err);
    let second = out.join("002_control.force_weight=1e2_method.iterations=2");
    let modified = || {
        fs::metadata(second.join("result.npz"))
            .unwrap()
            .modified()
            .unwrap()
    };
    let (before, page) = (modified(), out.join("sweep.html"));
    assert!(!page.exists());
    let all = sweep(&[]);
    assert!(matches!(all.code, 0 | 5), "{}", all.err);
    assert_eq!(modified(), before, "what is there was solved again");
    let facts: Value = json(&out.join("sweep.json"));
    let rows = facts["rows"].as_array().unwrap();
    assert_eq!(rows.len(), 4);
    for row in rows {
        let result = out.join(row["folder"].as_str().unwrap()).join("report.json");
        let report: Value = json(&result);
        assert_eq!(report["objective"]["total"], row["objective"]["total"]);
        assert!(
            row["set"][0]
                .as_str()
                .unwrap()
                .starts_with("control.force_weight=")
        );
    }
    let words = fs::read_to_string(page).unwrap();
    assert!(
        words.contains("control.force_weight=1e4 method.iterations=1") && words.contains("The last step")
    );
    for (more, code, words) in [
        (&["--only", "5"][..], 2, "runs from 1 to 4"),
        (&["--vary", "time.steps"], 2, "no `=`"),
        (&["--vary", "time.steps=1,9999"], 2, "time.steps"),
        (&["--precision", "f64"], 4, "of another precision"),
    ] {
        let refused = sweep(more);
        assert!(
            refused.code == code && refused.err.contains(words),
            "{}",
            refused.err
        );
    }
}

/// The page shows no result of another scene as one of this, and why a run came to nothing.
#[test]
fn a_sweeps_page_is_of_its_own_scene() {
    let folder = fresh_folder("sweep_other");
    let (scene, out) = (folder.join("scene.toml"), folder.join("out"));
    let sweep = |text: &str| {
        fs::write(&scene, text).unwrap();
        run(&[
            "sweep",
            scene.to_str().unwrap(),
            "--vary",
            "control.force_weight=1e2,1e4",
            "-o",
            out.to_str().unwrap(),
            "--quiet",
        ])
    };
    let first = sweep(SCENE);
    assert!(matches!(first.code, 0 | 5), "{}", first.err);
    let other = sweep(&SCENE.replace("[0.6, 0.5]", "[0.5, 0.6]"));
    assert_eq!(other.code, 4, "{}", other.err);
    let facts: Value = json(&out.join("sweep.json"));
    for row in facts["rows"].as_array().unwrap() {
        assert!(row["status"].is_null() && row["objective"].is_null(), "{row}");
        assert!(row["why"].as_str().unwrap().contains("of another scene"), "{row}");
    }
    let page = fs::read_to_string(out.join("sweep.md")).unwrap();
    assert!(
        page.contains("| failed |") && page.contains("came to no result: "),
        "{page}"
    );
    assert!(!page.contains("The last step"), "{page}");
}

/// A run that was not finished goes on where the sweep is now, and not where its state says that it was; the state of other settings stays.
#[test]
fn what_was_not_finished_goes_on_in_a_sweep() {
    let folder = folder_with(
        "sweep_killed",
        &SCENE.replace("iterations = 2", "iterations = 60"),
    );
    let run = "001_control.force_weight=1e2";
    let solve = |out: &str, set: &[&str]| {
        let first = ["solve", "scene.toml", "--checkpoint", "every=1", "-o"];
        let set = set.iter().flat_map(|set| ["--set", *set]);
        first
            .into_iter()
            .chain([out])
            .chain(set)
            .map(str::to_owned)
            .collect::<Vec<_>>()
    };
    let endless = ["method.direct.tolerance=1e-12", "control.force_weight=1e2"];
    let begun = |out: &str, set: &[&str]| {
        let solve = solve(out, set);
        killed(&folder, &solve.iter().map(String::as_str).collect::<Vec<_>>(), 3);
    };
    let sweep = |out: &str, more: &[&str]| {
        let sweep = [
            "sweep",
            "scene.toml",
            "--set",
            endless[0],
            "--vary",
            "control.force_weight=1e2,1e3",
            "-o",
            out,
        ];
        ended(&folder, &[&sweep[..], &["--quiet"], more].concat())
    };
    let second = sweep("before", &["--only", "2"]);
    assert!(matches!(second.code, 0 | 5), "{}", second.err);
    begun(&format!("before/{run}"), &endless);
    fs::rename(folder.join("before"), folder.join("moved")).unwrap();
    let moved = sweep("moved", &[]);
    assert!(matches!(moved.code, 0 | 5), "{}", moved.err);
    assert!(folder.join("moved").join(run).join("result.npz").is_file() && !folder.join("before").exists());
    assert_eq!(
        json(&folder.join("moved/sweep.json"))["rows"]
            .as_array()
            .unwrap()
            .len(),
        2
    );
    assert!(matches!(sweep("other", &["--only", "2"]).code, 0 | 5));
    begun(&format!("other/{run}"), &[endless[0], "control.force_weight=1e4"]);
    let refused = sweep("other", &[]);
    assert!(
        refused.code == 4
            && refused
                .err
                .contains("holds the state of another scene, of other settings"),
        "{}",
        refused.err
    );
    assert!(folder.join("other").join(format!("{run}.checkpoint")).exists());
}

#[test]
fn any_solver_is_swept_and_what_was_interrupted_begins_again() {
    let folder = fresh_folder("sweep_fluids");
    let (scene, out) = (folder.join("scene.toml"), folder.join("out"));
    fs::write(&scene, SCENE).unwrap();
    let arguments = [
        "sweep",
        scene.to_str().unwrap(),
        "-o",
        out.to_str().unwrap(),
        "--vary",
        "method.name=direct,stable_fluids",
        "--set",
        "method.stable_fluids.control=[\"forces\"]",
        "--quiet",
    ];
    let first = run(&arguments);
    assert!(matches!(first.code, 0 | 5), "{}", first.err);
    let report = out.join("002_method.name=stable_fluids/report.json");
    assert_eq!(json(&report)["method"], "stable_fluids");
    let interrupted = fs::read_to_string(&report)
        .unwrap()
        .replace("\"status\": \"", "\"status\": \"cancelled\", \"was\": \"");
    fs::write(&report, interrupted).unwrap();
    assert_eq!(json(&report)["status"], "cancelled");
    let second = run(&arguments);
    assert!(matches!(second.code, 0 | 5), "{}", second.err);
    assert_ne!(json(&report)["status"], "cancelled");
}

#[test]
fn shells_and_man_are_told_of_all_commands() {
    for shell in ["bash", "zsh", "fish", "powershell", "elvish"] {
        let script = run(&["completions", shell]);
        assert!(script.code == 0 && script.out.contains("name-by-time"), "{shell}");
        // Words that an option takes are offered too, where the shell's script has any: of methods, presets, figures.
        let words = [
            "horn_schunck",
            "richardson_lucy",
            "buckle_3d",
            "stable_fluids",
            "fig3.10",
        ];
        // fish completes what options take, and nothing that stands alone.
        let offered = match shell {
            "bash" | "zsh" => 5,
            "fish" => 4,
            _ => 0,
        };
        let missing = words[..offered].iter().find(|word| !script.out.contains(**word));
        assert_eq!(missing, None, "{shell}");
    }
    // A reader that has seen enough.
    let mut program = thurible()
        .args(["completions", "bash"])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    drop(program.stdout.take());
    let ended = program.wait_with_output().unwrap();
    assert!(ended.status.success() && ended.stderr.is_empty());
    let folder = fresh_folder("man");
    assert_eq!(run(&["man", folder.to_str().unwrap()]).code, 0);
    let page = fs::read_to_string(folder.join("thurible-resume.1")).unwrap();
    assert!(page.contains("Go on with a solve") && page.contains("memory\\-limit"));
    assert!(folder.join("thurible.1").is_file());
}
