//! A solve that is killed goes on from its last state, bit for bit, and nothing is written over that somebody may want.

use crate::support::endless::Endless;
use crate::support::{Ended, fresh_folder, json, run, thurible};
use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use thurible_core::checkpoint::Mix;

pub const PLAIN: &str = "\
[grid]
cells = [32, 24]
[time]
steps = 10
[source]
file = \"source.npy\"
[[keyframe]]
step = 10
circle = { center = [0.65, 0.5], radius = 0.2 }
[method]
iterations = 60
direct = { tolerance = 1e-12, nested = false }
admm = { density_tolerance = 1e-12 }
stable_fluids = { tolerance = 1e-12, control = [\"forces\", \"initial_velocity\"] }
[output]
frames = false
";

pub const WINDOWS: &str = "\
[grid]
cells = [20, 16]
[time]
steps = 30
[source]
circle = { center = [0.3, 0.4], radius = 0.2 }
[[emitter]]
from = 0
to = 20
rate = 0.05
circle = { center = [0.3, 0.4], radius = 0.15 }
[[obstacle]]
box = { min = [0.7, 0.0], max = [0.8, 0.3] }
[[keyframe]]
step = 5
circle = { center = [0.5, 0.4], radius = 0.25 }
[[keyframe]]
step = 24
circle = { center = [0.5, 0.7], radius = 0.25 }
[[release]]
from = 25
[method]
iterations = 6
window = 9
stride = 5
direct = { tolerance = 1e-12 }
[output]
frames = false
";

/// A fresh folder with a scene in it.
pub fn folder_with(name: &str, scene: &str) -> PathBuf {
    let folder = fresh_folder(name);
    fs::write(folder.join("scene.toml"), scene).unwrap();
    let cells: Vec<f64> = (0..24 * 32)
        .map(|cell| f64::from(u8::from((cell % 32) / 8 == 1 && cell / 32 > 8)))
        .collect();
    fs::write(
        folder.join("source.npy"),
        crate::support::npz::npy(&[24, 32], &cells),
    )
    .unwrap();
    folder
}

pub fn command(folder: &Path, arguments: &[&str]) -> Command {
    let mut command = thurible();
    command.current_dir(folder).args(arguments);
    command
}

pub fn ended(folder: &Path, arguments: &[&str]) -> Ended {
    command(folder, arguments).output().unwrap().into()
}

/// Runs `arguments`, which keep the state, and kills the program when it has told of `lines` iterations.
pub fn killed(folder: &Path, arguments: &[&str], lines: usize) {
    let mut seen = 0;
    let running = Endless::seen(&mut command(folder, &[arguments, &["--json"]].concat()), |line| {
        seen += usize::from(line.contains("\"event\":\"iteration\""));
        seen == lines
    });
    running.kill();
}

pub fn arrays(folder: &Path) -> Vec<u8> {
    fs::read(folder.join("out/result.npz")).unwrap()
}

fn report(folder: &Path) -> Value {
    json(&folder.join("out/report.json"))
}

/// Everything of a report but seconds, threads and the command line.
fn facts(folder: &Path) -> Value {
    let mut report = report(folder);
    for key in ["seconds", "threads", "command", "memory"] {
        report[key] = Value::Null;
    }
    for list in ["history", "windows"] {
        for row in report[list].as_array_mut().into_iter().flatten() {
            row["seconds"] = Value::Null;
            row["seconds_left"] = Value::Null;
        }
    }
    report
}

/// Kills the solve after some iterations and goes on, with other threads and another ceiling.
fn goes_on(test: &str, scene: &str, solve: &[&str], kills: &[usize]) {
    let folder = folder_with(test, scene);
    let solve = [solve, &["scene.toml", "-o", "out", "--threads", "1"]].concat();
    let whole = ended(&folder, &[&solve[..], &["--quiet"]].concat());
    assert!(matches!(whole.code, 0 | 5), "{test}: {}", whole.err);
    let (expected, said) = (arrays(&folder), facts(&folder));
    fs::remove_dir_all(folder.join("out")).unwrap();
    let kept = ["--checkpoint", "every=1"];
    killed(&folder, &[&solve[..], &kept].concat(), kills[0]);
    let on = ["resume", "out", "--threads", "2", "--memory-limit", "100MiB"];
    for &more in &kills[1..] {
        killed(&folder, &[&on[..], &kept].concat(), more);
    }
    // What is there is gone on from where no more of it is kept, too.
    let ended = ended(&folder, &[&on[..], &["--checkpoint", "off"]].concat());
    assert!(matches!(ended.code, 0 | 5), "{test}: {}", ended.err);
    assert!(ended.err.contains("going on from"), "{}", ended.err);
    assert!(arrays(&folder) == expected, "{test}: another result");
    assert_eq!(facts(&folder), said, "{test}");
    let names: Vec<_> = fs::read_dir(&folder)
        .unwrap()
        .map(|entry| entry.unwrap().file_name())
        .collect();
    assert_eq!(names.len(), 3, "{test}: left behind: {names:?}");
}

#[test]
fn a_killed_solve_goes_on_bit_for_bit() {
    goes_on("killed_direct", PLAIN, &["solve"], &[9, 4]);
    goes_on("killed_admm", PLAIN, &["solve", "--method", "admm"], &[5]);
    goes_on(
        "killed_f64",
        PLAIN,
        &["solve", "--method", "lbfgs", "--precision", "f64"],
        &[6],
    );
    goes_on(
        "killed_fluids",
        PLAIN,
        &["solve", "--method", "stable_fluids"],
        &[9, 4],
    );
    goes_on(
        "killed_fluids_f64",
        PLAIN,
        &[
            "solve",
            "--method",
            "stable_fluids",
            "--precision",
            "f64",
            "--set",
            "method.stable_fluids.slots=3",
        ],
        &[6],
    );
    goes_on("killed_capped", PLAIN, &["solve", "--memory-limit", "1MiB"], &[7]);
}

/// Within a window, between windows, after the release, and of a flow alone.
#[test]
fn a_solve_in_windows_goes_on_bit_for_bit() {
    goes_on("killed_windows", WINDOWS, &["solve"], &[3, 10, 8]);
    goes_on("killed_windows_late", WINDOWS, &["solve"], &[27]);
    goes_on("killed_flow", WINDOWS, &["simulate"], &[2]);
}

/// The result that a flow began with is one of its inputs.
#[test]
fn a_result_that_was_changed_since_is_refused_by_name() {
    let folder = folder_with("changed_result", WINDOWS);
    let first = ["simulate", "scene.toml", "--quiet", "-o", "first"];
    assert_eq!(ended(&folder, &first).code, 0);
    let from = [
        "simulate",
        "scene.toml",
        "--from",
        "first",
        "-o",
        "out",
        "--checkpoint",
        "every=1",
    ];
    killed(&folder, &from, 2);
    let archive = folder.join("first/result.npz");
    let mut bytes = fs::read(&archive).unwrap();
    *bytes.last_mut().unwrap() ^= 1;
    fs::write(&archive, &bytes).unwrap();
    let refused = ended(&folder, &["resume", "out"]);
    assert!(
        refused.code != 0 && refused.err.contains("first/result.npz"),
        "{}",
        refused.err
    );
    *bytes.last_mut().unwrap() ^= 1;
    fs::write(&archive, &bytes).unwrap();
    assert_eq!(ended(&folder, &["resume", "out", "--quiet"]).code, 0);
}

/// States come as often as they are asked for, and nothing is left where none are.
#[test]
fn no_state_is_kept_unasked() {
    let folder = folder_with("rarely", PLAIN);
    let solve = ["solve", "scene.toml", "-o", "out", "--checkpoint"];
    let states = || ["state.0", "state.1"].map(|state| folder.join("out.checkpoint").join(state).exists());
    killed(&folder, &[&solve[..], &["every=1000000"]].concat(), 6);
    assert_eq!(states(), [false; 2]);
    killed(&folder, &[&solve[..], &["every=1"]].concat(), 6);
    assert_eq!(states(), [true; 2]);
    // One that is solved anew throws them away, also where it keeps none.
    let anew = ["off", "--force", "--set", "method.iterations=1", "--quiet"];
    assert!(matches!(
        ended(&folder, &[&solve[..], &anew].concat()).code,
        0 | 5
    ));
    assert!(folder.join("out/result.npz").exists() && !folder.join("out.checkpoint").exists());
    // Windows that are over are kept beside states, and not without.
    let folder = folder_with("rarely_windows", WINDOWS);
    killed(&folder, &[&solve[..], &["off"]].concat(), 20);
    assert!(!folder.join("out.checkpoint").exists());
}

/// What a solve began with is what it goes on with.
#[test]
fn what_was_changed_since_is_refused_by_name() {
    let folder = folder_with("changed_since", PLAIN);
    let solve = ["solve", "scene.toml", "-o", "out", "--checkpoint", "every=1"];
    killed(&folder, &solve, 4);
    let refused = |words: &[&str], code: i32| {
        let ended = ended(&folder, &["resume", "out"]);
        assert!(
            ended.code == code && ended.err.lines().count() == 1,
            "{}",
            ended.err
        );
        assert!(words.iter().all(|word| ended.err.contains(word)), "{}", ended.err);
    };
    let scene = folder.join("scene.toml");
    fs::write(&scene, PLAIN.replace("0.65", "0.66")).unwrap();
    refused(&["scene.toml was changed since", "put it back", "solve anew"], 2);
    fs::write(&scene, PLAIN).unwrap();
    let source = folder.join("source.npy");
    let bytes = fs::read(&source).unwrap();
    let mut other = bytes.clone();
    *other.last_mut().unwrap() ^= 1;
    fs::write(&source, other).unwrap();
    refused(&["source.npy was changed since", "put it back"], 2);
    fs::remove_file(&source).unwrap();
    refused(&["source.npy", "put it back"], 4);
    fs::write(&source, bytes).unwrap();
    // No other keys, nor another precision, are proposed to a solve that goes on.
    let low = ended(
        &folder,
        &["resume", "out", "--threads", "2", "--memory-limit", "9KiB"],
    );
    assert!(
        low.code == 3 && low.err.contains("raise --memory-limit") && !low.err.contains("`grid"),
        "{}",
        low.err
    );
    // A new solve neither throws the state away unasked, nor can it be shared.
    let anew = ended(&folder, &["solve", "scene.toml", "-o", "out"]);
    assert_eq!(anew.code, 4);
    assert!(
        anew.err.contains("`thurible resume out`") && anew.err.contains("--force"),
        "{}",
        anew.err
    );
    // Elsewhere there is another result.
    let other = [
        "solve",
        "scene.toml",
        "-o",
        "elsewhere",
        "--set",
        "method.iterations=1",
        "--quiet",
    ];
    assert!(matches!(ended(&folder, &other).code, 0 | 5));
    let there = fs::read(folder.join("elsewhere/result.npz")).unwrap();
    let elsewhere = ["resume", "out.checkpoint", "-o", "elsewhere", "--quiet"];
    let kept = ended(&folder, &elsewhere);
    assert!(
        kept.code == 4 && kept.err.contains("holds a result already") && kept.err.contains("--force"),
        "{}",
        kept.err
    );
    assert_eq!(fs::read(folder.join("elsewhere/result.npz")).unwrap(), there);
    // The text of the scene is with the state, its file is not needed.
    fs::remove_file(&scene).unwrap();
    let on = ended(&folder, &[&elsewhere[..], &["--force"]].concat());
    assert!(matches!(on.code, 0 | 5), "{}", on.err);
    assert_ne!(fs::read(folder.join("elsewhere/result.npz")).unwrap(), there);
    assert!(folder.join("elsewhere/result.npz").is_file() && !folder.join("out.checkpoint").exists());
    let nothing = ended(&folder, &["resume", "out"]);
    assert!(
        nothing.code == 4 && nothing.err.contains("no state of a solve"),
        "{}",
        nothing.err
    );
}

/// A result that came to the place of the solve's own meanwhile stays, and a folder that was moved keeps what is found in it.
#[test]
fn another_result_in_its_place_stays() {
    let folder = folder_with("moved", PLAIN);
    let solve = ["solve", "scene.toml", "-o", "shot/out"];
    killed(&folder, &[&solve[..], &["--checkpoint", "every=1"]].concat(), 5);
    // Beside the state there is the result of another solve, of another limit or of another precision.
    let mut there = Vec::new();
    for other in [["--set", "method.iterations=1"], ["--precision", "f64"]] {
        let _ = fs::remove_dir_all(folder.join("shot/out"));
        let solve = ["solve", "scene.toml", "-o", "shot/other", "--quiet"];
        let solved = ended(&folder, &[&solve[..], &other].concat());
        assert!(matches!(solved.code, 0 | 5), "{}", solved.err);
        fs::rename(folder.join("shot/other"), folder.join("shot/out")).unwrap();
        there = fs::read(folder.join("shot/out/result.npz")).unwrap();
        let refused = ended(&folder, &["resume", "shot/out"]);
        assert!(
            refused.code == 4 && refused.err.contains("shot/out holds a result already"),
            "{}",
            refused.err
        );
        assert_eq!(fs::read(folder.join("shot/out/result.npz")).unwrap(), there);
    }
    // Where the folder is moved the result follows, and what comes to its old place is nothing to it.
    fs::rename(folder.join("shot/out"), folder.join("other")).unwrap();
    fs::rename(folder.join("shot"), folder.join("moved")).unwrap();
    fs::create_dir(folder.join("shot")).unwrap();
    fs::rename(folder.join("other"), folder.join("shot/out")).unwrap();
    // One of the states stands for them.
    let on = ended(&folder, &["resume", "moved/out.checkpoint/state.1", "--quiet"]);
    assert!(matches!(on.code, 0 | 5), "{}", on.err);
    assert!(folder.join("moved/out/report.html").is_file() && !folder.join("moved/out.checkpoint").exists());
    assert_eq!(fs::read(folder.join("shot/out/result.npz")).unwrap(), there);
}

/// One state is held by one run.
#[test]
fn a_state_that_is_being_written_is_left_alone() {
    let folder = folder_with("held", PLAIN);
    let endless = ["--set", "method.iterations=100000"];
    let solve = [
        "solve",
        "scene.toml",
        "--method",
        "admm",
        "-o",
        "out",
        "--checkpoint",
        "every=1",
        "--json",
    ];
    let mut seen = 0;
    let running = Endless::seen(&mut command(&folder, &[&solve[..], &endless].concat()), |line| {
        seen += usize::from(line.contains("\"event\":\"iteration\""));
        seen == 3
    });
    for arguments in [
        &["resume", "out"][..],
        &["solve", "scene.toml", "-o", "out", "--force"],
    ] {
        let ended = ended(&folder, arguments);
        assert!(
            ended.code == 4 && ended.err.contains("another run"),
            "{}",
            ended.err
        );
    }
    // Interrupted, it says how it goes on; what it has written so far may then be replaced.
    let stopped = running.stop();
    assert_eq!(stopped.code, 130);
    let kept = stopped.out.lines().last().unwrap();
    assert!(
        kept.contains("\"event\":\"kept\"") && kept.contains("out.checkpoint"),
        "{kept}"
    );
    assert!(folder.join("out/result.npz").is_file() && folder.join("out.checkpoint/state.0").is_file());
}

#[test]
fn a_result_is_not_written_over_unasked() {
    let folder = folder_with("not_over", PLAIN);
    let solve = [
        "solve",
        "scene.toml",
        "--set",
        "method.iterations=1",
        "--quiet",
        "-o",
        "out",
    ];
    assert!(matches!(ended(&folder, &solve).code, 0 | 5));
    let before = arrays(&folder);
    let again = ended(&folder, &[&solve[..], &["--set", "flow.buoyancy=1e-3"]].concat());
    assert_eq!(again.code, 4);
    let words = [
        "out holds a result already",
        "-o DIR",
        "--name-by-time",
        "--force",
    ];
    assert!(words.iter().all(|word| again.err.contains(word)), "{}", again.err);
    assert!(arrays(&folder) == before);
    let timed = ended(&folder, &[&solve[..], &["--name-by-time"]].concat());
    assert!(matches!(timed.code, 0 | 5), "{}", timed.err);
    let named = fs::read_dir(&folder).unwrap().filter(|entry| {
        let name = entry.as_ref().unwrap().file_name().into_string().unwrap();
        name.starts_with("out_20") && name.len() == "out_2026-11-26_213045".len()
    });
    assert_eq!(named.count(), 1);
    let forced = ended(
        &folder,
        &[&solve[..], &["--force", "--set", "flow.buoyancy=1e-3"]].concat(),
    );
    assert!(matches!(forced.code, 0 | 5) && arrays(&folder) != before);
}

/// What killed runs leave behind is found by the next run, and what was under way is brought to an end.
#[test]
fn leftovers_of_killed_runs_are_removed() {
    let folder = folder_with("leftovers", PLAIN);
    let solve = [
        "solve",
        "scene.toml",
        "--set",
        "method.iterations=1",
        "--quiet",
        "-o",
        "out",
        "--force",
    ];
    assert!(matches!(ended(&folder, &solve).code, 0 | 5));
    let before = arrays(&folder);
    // Killed when some files of the earlier result had gone, and one of the new one had come.
    let hidden = folder.join("out/.thurible-new-1");
    for below in ["new", "old"] {
        fs::create_dir_all(hidden.join(below)).unwrap();
    }
    let names = ["manifest.json", "report.html", "report.json", "result.npz"];
    let new = ["report.json", "report.html", "result.npz", "manifest.json"];
    for name in names {
        let path = folder.join("out").join(name);
        let bytes = fs::read(&path).unwrap();
        fs::rename(&path, hidden.join("old").join(name)).unwrap();
        fs::write(hidden.join("new").join(name), bytes).unwrap();
    }
    fs::rename(hidden.join("new/report.json"), folder.join("out/report.json")).unwrap();
    fs::write(
        hidden.join("moves.json"),
        serde_json::json!({ "gone": names, "new": new }).to_string(),
    )
    .unwrap();
    fs::write(hidden.join("lock"), "").unwrap();
    let beside = folder.join(".out.thurible-growing-1");
    fs::create_dir(&beside).unwrap();
    fs::write(beside.join("lock"), "").unwrap();
    fs::write(beside.join("density"), [0; 100]).unwrap();
    // Killed before it was locked, or after its lock had gone.
    let empty = folder.join("out/.thurible-probe-1");
    fs::create_dir(&empty).unwrap();
    // Killed when it looked at a folder of an export.
    let below = folder.join("out/volumes/.thurible-probe-999999");
    fs::create_dir_all(&below).unwrap();
    fs::write(below.join("lock"), "").unwrap();
    // Killed when the states had gone, and files that they need had not.
    let stateless = folder.join("out.checkpoint");
    fs::create_dir(&stateless).unwrap();
    fs::write(stateless.join("lock"), "").unwrap();
    fs::write(stateless.join("velocity_x"), [0; 100]).unwrap();
    let refused = ended(&folder, &solve[..solve.len() - 1]);
    assert!(refused.err.contains("holds a result already"), "{}", refused.err);
    assert!(arrays(&folder) == before);
    for left in [hidden, beside, empty, below, stateless] {
        assert!(!left.exists(), "{} is left behind", left.display());
    }
    fs::remove_dir(folder.join("out/volumes")).unwrap();
    let mut found: Vec<_> = fs::read_dir(folder.join("out"))
        .unwrap()
        .map(|entry| entry.unwrap().file_name())
        .collect();
    found.sort();
    assert_eq!(found, names);
}

#[test]
fn what_is_no_state_is_refused() {
    let folder = folder_with("no_state", PLAIN);
    let states = folder.join("out.checkpoint");
    fs::create_dir(&states).unwrap();
    fs::write(states.join("mine"), "mine").unwrap();
    let ended_ = ended(&folder, &["solve", "scene.toml", "-o", "out", "--quiet"]);
    assert!(
        ended_.code == 4 && ended_.err.contains("was not made by thurible"),
        "{}",
        ended_.err
    );
    fs::write(states.join("state.0"), "no state").unwrap();
    let refused = ended(&folder, &["resume", "out"]);
    assert!(
        refused.code == 4 && refused.err.contains("state.0 is not whole"),
        "{}",
        refused.err
    );
    let often = run(&["solve", "examples/small_letter.toml", "--checkpoint", "often"]);
    assert!(
        often.code == 2 && often.err.contains("every=60s"),
        "{}",
        often.err
    );
}

/// A state with its checksum made right again after a change.
fn sealed(mut state: Vec<u8>) -> Vec<u8> {
    const PIECE: usize = 1 << 16;
    let (all, place) = state.split_last_chunk_mut::<8>().unwrap();
    let mut sum = Mix::new();
    all.chunks(PIECE).for_each(|piece| sum.bytes(piece));
    *place = sum.finish().to_le_bytes();
    state
}

/// Counts that no solve of the scene has, in a state whose checksum is right.
#[test]
fn counts_that_cannot_be_are_refused() {
    let folder = folder_with("odd_counts", WINDOWS);
    let solve = ["solve", "scene.toml", "-o", "out", "--threads", "1"];
    killed(&folder, &[&solve[..], &["--checkpoint", "every=1"]].concat(), 20);
    let states = folder.join("out.checkpoint");
    let slots = ["state.0", "state.1"].map(|slot| states.join(slot));
    let word = |state: &[u8], at: usize| u64::from_le_bytes(state[at..at + 8].try_into().unwrap());
    let after = |state: &[u8], at: usize| at + 8 + usize::try_from(word(state, at)).unwrap();
    // Behind name and head: the number of the window, seconds, a status, two flags, and the window under way.
    let number = |state: &[u8]| after(state, 16) + 8;
    let inside = |state: &[u8]| after(state, number(state) + 16) + 16;
    let kept = slots.iter().filter_map(|slot| fs::read(slot).ok());
    let good = { kept }
        .find(|state| word(state, inside(state) - 8) == 1)
        .expect("a state within a window");
    let iteration = inside(&good) + 24;
    for place in [number(&good), iteration] {
        for odd in [word(&good, place) + 1000, 1 << 40, 1 << 60, u64::MAX] {
            let mut changed = good.clone();
            changed[place..place + 8].copy_from_slice(&odd.to_le_bytes());
            for slot in &slots {
                fs::write(slot, sealed(changed.clone())).unwrap();
            }
            let refused = ended(&folder, &["resume", "out", "--quiet"]);
            assert!(
                refused.code == 4 && refused.err.contains("is damaged"),
                "{odd} at {place}: {} {}",
                refused.code,
                refused.err
            );
        }
    }
    fs::write(&slots[0], sealed(good)).unwrap();
    fs::remove_file(&slots[1]).unwrap();
    let on = ended(&folder, &["resume", "out", "--quiet"]);
    assert!(matches!(on.code, 0 | 5), "{}", on.err);
}
