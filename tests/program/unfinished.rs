//! What becomes of solves that were not finished, and of results that were half moved: where they are looked for, what refuses to go on,
//! what is never thrown away.

use crate::checkpoints::{PLAIN, WINDOWS, arrays, command, ended, folder_with, killed};
use crate::support::endless::Endless;
use crate::support::{Ended, json, npz};
use std::fs;
use std::path::Path;

const SOLVE: [&str; 4] = ["solve", "scene.toml", "--checkpoint", "every=1"];

fn is_well(ended: &Ended) -> bool {
    matches!(ended.code, 0 | 5)
}

/// Refused by this code, in one sentence that has these words.
fn refused(ended: &Ended, code: i32, words: &[&str]) {
    assert!(
        ended.code == code && ended.err.lines().count() == 1,
        "{}: {}",
        ended.code,
        ended.err
    );
    assert!(words.iter().all(|word| ended.err.contains(word)), "{}", ended.err);
}

/// Counts the iterations that a solve tells of.
fn iterations(mut each: impl FnMut(usize) -> bool) -> impl FnMut(&str) -> bool {
    let mut seen = 0;
    move |line| {
        let is_one = line.contains("\"event\":\"iteration\"");
        seen += usize::from(is_one);
        is_one && each(seen)
    }
}

/// What could not be moved stays until it can, and nothing is written over it.
#[test]
fn a_half_moved_result_stays_until_it_can_be_moved() {
    let folder = folder_with("half_moved", PLAIN);
    let solve = [
        "solve",
        "scene.toml",
        "-o",
        "out",
        "--set",
        "method.iterations=1",
        "--quiet",
    ];
    assert!(is_well(&ended(&folder, &solve)));
    let before = arrays(&folder);
    let (out, hidden) = (folder.join("out"), folder.join("out/.thurible-new-1"));
    fs::create_dir_all(hidden.join("new")).unwrap();
    let names = ["manifest.json", "report.html", "report.json", "result.npz"];
    for name in names {
        fs::copy(out.join(name), hidden.join("new").join(name)).unwrap();
    }
    let plan = serde_json::json!({ "gone": names, "new": names });
    fs::write(hidden.join("moves.json"), plan.to_string()).unwrap();
    fs::write(hidden.join("lock"), "").unwrap();
    // The folder that the earlier result is moved to cannot be made.
    fs::write(hidden.join("old"), "").unwrap();
    let forced = [&solve[..], &["--force"]].concat();
    refused(
        &ended(&folder, &forced),
        4,
        &["cannot be moved", ".thurible-new-1", "make the folder writable"],
    );
    for name in names {
        assert!(
            hidden.join("new").join(name).is_file() && out.join(name).is_file(),
            "{name} is lost"
        );
    }
    fs::remove_file(hidden.join("old")).unwrap();
    refused(&ended(&folder, &solve), 4, &["holds a result already"]);
    assert!(arrays(&folder) == before && !hidden.exists());
}

/// The states are beside where a link leads, and so is what looks for them.
#[test]
#[cfg(unix)]
fn the_state_of_a_linked_folder_is_found() {
    let folder = folder_with("linked", PLAIN);
    fs::create_dir(folder.join("real")).unwrap();
    std::os::unix::fs::symlink("real", folder.join("link")).unwrap();
    killed(&folder, &[&SOLVE[..], &["-o", "link"]].concat(), 4);
    assert!(folder.join("real.checkpoint/state.0").is_file());
    let anew = [&SOLVE[..], &["-o", "link", "--set", "flow.buoyancy=1e-3"]].concat();
    refused(
        &ended(&folder, &anew),
        4,
        &["was not finished", "`thurible resume link`"],
    );
    let on = ended(&folder, &["resume", "link"]);
    assert!(is_well(&on) && on.err.contains("going on from"), "{}", on.err);
    assert!(folder.join("real/result.npz").is_file() && !folder.join("real.checkpoint").exists());
}

#[test]
fn the_state_of_the_folder_itself_is_found() {
    let folder = folder_with("of_itself", PLAIN);
    let inside = folder.join("inside");
    fs::create_dir(&inside).unwrap();
    let solve = ["solve", "../scene.toml", "--checkpoint", "every=1", "-o", "."];
    killed(&inside, &solve, 4);
    assert!(folder.join("inside.checkpoint/state.0").is_file());
    refused(&ended(&inside, &solve), 4, &["was not finished"]);
    let on = ended(&inside, &["resume", "."]);
    assert!(is_well(&on) && on.err.contains("going on from"), "{}", on.err);
    assert!(inside.join("result.npz").is_file() && !folder.join("inside.checkpoint").exists());
}

/// Takes all names that a program which runs in `folder` has for hidden folders beside `NAME.1`.
#[cfg(target_os = "linux")]
fn take_hidden_names(folder: &Path, name: &str) {
    let runs_here =
        |process: &fs::DirEntry| fs::read_link(process.path().join("cwd")).is_ok_and(|at| at == folder);
    let mut processes = fs::read_dir("/proc").unwrap().flatten();
    let process = processes.find(runs_here).unwrap().file_name();
    let hidden = format!(".{name}.1.thurible-new-{}", process.to_str().unwrap());
    fs::create_dir(folder.join(&hidden)).unwrap();
    for attempt in 1..100 {
        fs::create_dir(folder.join(format!("{hidden}.{attempt}"))).unwrap();
    }
}

/// Ctrl-C where the result finds no place: the solve goes on from its state, whether one was kept before or not.
#[test]
#[cfg(target_os = "linux")]
fn what_was_interrupted_and_found_no_room_goes_on() {
    let folder = folder_with("no_room", PLAIN);
    for kept in ["every=1", "off"] {
        let name = kept.get(..3).unwrap().to_owned();
        let out = folder.join(&name);
        fs::create_dir(&out).unwrap();
        let solve = [
            "solve",
            "scene.toml",
            "--method",
            "admm",
            "--json",
            "-o",
            &name,
            "--checkpoint",
            kept,
        ];
        let mut solving = command(&folder, &solve);
        solving
            .args(["--set", "method.iterations=400"])
            .env("TMPDIR", folder.join("nowhere"));
        let running = Endless::seen(
            &mut solving,
            iterations(|number| {
                if number == 3 {
                    fs::write(out.join("result.npz"), "mine").unwrap();
                    take_hidden_names(&folder, &name);
                }
                number == 3
            }),
        );
        let stopped = running.stop();
        refused(&stopped, 4, &["is kept in", "`thurible resume"]);
        fs::remove_file(out.join("result.npz")).unwrap();
        let on = ended(&folder, &["resume", &name]);
        assert!(
            is_well(&on) && on.err.contains("going on from"),
            "{kept}: {}",
            on.err
        );
        let report = json(&out.join("report.json"));
        let done = report["history"].as_array().unwrap().len();
        assert!(
            report["status"] != "cancelled" && done > 100,
            "{kept}: {done} iterations"
        );
    }
}

/// `--force` throws a state away when the new solve begins, not when it is refused.
#[test]
fn a_refused_solve_throws_no_state_away() {
    let folder = folder_with("forced", PLAIN);
    let solve = [&SOLVE[..], &["-o", "out"]].concat();
    killed(&folder, &solve, 4);
    let forced = |more: &[&str]| ended(&folder, &[&solve[..], &["--force", "--quiet"], more].concat());
    let state = folder.join("out.checkpoint/state.0");
    refused(&forced(&["--memory-limit", "1KiB"]), 3, &[]);
    assert!(state.is_file(), "refused for its memory");
    refused(&forced(&["--set", "source.file=\"none.npy\""]), 4, &["none.npy"]);
    assert!(state.is_file(), "refused for an input");
    fs::create_dir(folder.join("out")).unwrap();
    fs::write(folder.join("out/mine"), "mine").unwrap();
    refused(&forced(&[]), 4, &["not empty"]);
    assert!(state.is_file(), "refused for what is in its folder");
    fs::remove_file(folder.join("out/mine")).unwrap();
    assert!(is_well(&forced(&[])) && !folder.join("out.checkpoint").exists());
}

/// A scene in windows that is refused, before the first or within it.
#[test]
fn a_refused_scene_leaves_no_folder_of_states() {
    let wall = "[[obstacle]]\nbox = { min = [0.6, 0.0], max = [0.7, 1.0] }\n[[keyframe]]\nstep = 9\ncircle = { center = [0.9, 0.6], radius = 0.05 }\n";
    let mask = "[control]\nmask = { image = \"none.png\" }\n";
    for (name, more, words) in [("walled", wall, "keyframe"), ("unmasked", mask, "none.png")] {
        let folder = folder_with(name, &format!("{WINDOWS}{more}"));
        let refused = ended(&folder, &[&SOLVE[..], &["-o", "out", "--quiet"]].concat());
        assert!(
            matches!(refused.code, 2 | 4) && refused.err.contains(words),
            "{}",
            refused.err
        );
        assert!(!folder.join("out.checkpoint").exists(), "{name}: left behind");
    }
}

/// Files are those that the solve began with, however late the first state is kept.
#[test]
fn an_input_that_changes_before_the_first_state_is_refused() {
    let folder = folder_with("changed_early", PLAIN);
    let source = folder.join("source.npy");
    let solve = [
        "solve",
        "scene.toml",
        "-o",
        "out",
        "--checkpoint",
        "every=8",
        "--json",
    ];
    let running = Endless::seen(
        &mut command(&folder, &solve),
        iterations(|number| {
            if number == 2 {
                fs::write(&source, npz::npy(&[24, 32], &[0.5; 24 * 32])).unwrap();
            }
            number == 12
        }),
    );
    running.kill();
    assert!(states(&folder) > 0);
    refused(
        &ended(&folder, &["resume", "out"]),
        2,
        &["source.npy was changed since"],
    );
}

fn states(folder: &Path) -> usize {
    let there = ["state.0", "state.1"].map(|slot| folder.join("out.checkpoint").join(slot).is_file());
    there.into_iter().filter(|is_there| *is_there).count()
}

/// What is told of a damaged state is told to programs too.
#[test]
fn a_damaged_state_is_told_of_in_json() {
    let folder = folder_with("damaged_json", PLAIN);
    killed(&folder, &[&SOLVE[..], &["-o", "out"]].concat(), 6);
    assert_eq!(states(&folder), 2);
    let state = folder.join("out.checkpoint/state.0");
    let bytes = fs::read(&state).unwrap();
    fs::write(&state, &bytes[..bytes.len() / 2]).unwrap();
    let on = ended(&folder, &["resume", "out", "--json"]);
    assert!(is_well(&on), "{}", on.err);
    let warned = on
        .out
        .lines()
        .find(|line| line.contains("\"event\":\"warning\""))
        .unwrap_or("");
    assert!(
        warned.contains("state.0 is not whole, so the other state is gone on from"),
        "{}",
        on.out
    );
}

/// Who asked for states has their folder from the start.
#[test]
fn a_second_run_is_refused_before_the_first_state() {
    let folder = folder_with("one_run", PLAIN);
    let solve = [
        "solve",
        "scene.toml",
        "-o",
        "out",
        "--method",
        "admm",
        "--checkpoint",
        "every=1h",
    ];
    let endless = [&solve[..], &["--set", "method.iterations=100000", "--json"]].concat();
    let running = Endless::seen(&mut command(&folder, &endless), iterations(|_| true));
    refused(&ended(&folder, &solve), 4, &["another run"]);
    running.kill();
    let after = ended(&folder, &[&solve[..], &["--set", "method.iterations=1"]].concat());
    assert!(
        is_well(&after) && !folder.join("out.checkpoint").exists(),
        "{}",
        after.err
    );
}

/// `--force` throws no state away before every file has been read.
#[test]
fn states_stay_where_a_new_solve_is_refused() {
    let folder = folder_with("refused_by_force", WINDOWS);
    let solve = [&SOLVE[..], &["-o", "out"]].concat();
    killed(&folder, &solve, 3);
    let states = folder.join("out.checkpoint");
    assert!(states.is_dir(), "no states were kept");
    let bad = WINDOWS.replace(
        "[[keyframe]]\nstep = 5",
        "[[emitter]]\nfrom = 20\nto = 22\nrate = 0.05\nimage = \"gone.png\"\n[[keyframe]]\nstep = 5",
    );
    fs::write(folder.join("scene.toml"), bad).unwrap();
    let again = ended(&folder, &[&solve[..], &["--force"]].concat());
    assert!(again.code != 0 && again.err.contains("gone.png"), "{}", again.err);
    assert!(states.join("state.0").is_file() || states.join("state.1").is_file());
}
