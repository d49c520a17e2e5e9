//! Ctrl-C: what there is is written, and a second one ends the program.

use crate::support::endless::Endless;
use crate::support::fresh_folder;
use crate::support::verify::verify;
use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Child, Command, Stdio};

/// A run of the program that has printed a line with `seen`, and the lines of JSON that it will yet print.
fn begun(arguments: &[&str], seen: &str) -> (Child, impl Iterator<Item = String> + use<>) {
    let mut program = crate::support::thurible()
        .args(arguments)
        .args(["--json", "--set", "output.frames=false"])
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let mut lines = BufReader::new(program.stdout.take().unwrap())
        .lines()
        .map(Result::unwrap);
    assert!(lines.any(|line| line.contains(seen)), "no {seen} was seen");
    (program, lines)
}

/// A solve that goes on until it is stopped, seen to iterate.
fn endless(folder: &Path) -> (Child, impl Iterator<Item = String>) {
    let sets = [
        "--set",
        "method.iterations=100000",
        "--set",
        "method.admm.density_tolerance=1e-12",
    ];
    let scene = [
        "solve",
        "examples/small_letter.toml",
        "-o",
        folder.to_str().unwrap(),
    ];
    begun(&[&scene[..], &sets].concat(), "\"iteration\"")
}

/// Sends `signals` to `program`, one after the other.
fn signal(program: &Child, signals: &[&str]) {
    let kill: String = signals
        .iter()
        .map(|signal| format!("kill -{signal} {}; ", program.id()))
        .collect();
    assert!(Command::new("sh").args(["-c", &kill]).status().unwrap().success());
}

/// Ctrl-C in the middle: exit code 130, and what there is is written and feasible.
#[test]
fn an_interrupt_writes_what_there_is() {
    let folder = fresh_folder("interrupted").join("out");
    let (mut program, lines) = endless(&folder);
    signal(&program, &["INT"]);
    let rest: Vec<String> = lines.collect();
    assert_eq!(program.wait().unwrap().code(), Some(130));
    assert!(rest.last().unwrap().contains("\"cancelled\""), "{rest:?}");
    let report = verify("interrupted", &folder).report;
    assert_eq!(report["status"], "cancelled");
    assert!(
        report["history"]
            .as_array()
            .unwrap()
            .iter()
            .all(|row| row["total"].as_f64().unwrap() > 0.0),
        "an iteration without numbers"
    );
}

/// A simulation that is stopped says behind which step nothing was simulated.
#[test]
fn an_interrupted_simulation_says_where_it_ends() {
    let folder = fresh_folder("interrupted_simulation").join("out");
    let scene = ["simulate", "examples/small_3d.toml", "--steps", "4000"];
    let more = ["--set", "flow.buoyancy=1e-3", "-o", folder.to_str().unwrap()];
    let (mut program, lines) = begun(&[scene, more].concat(), "\"planned_bytes\"");
    std::thread::sleep(core::time::Duration::from_millis(300));
    signal(&program, &["INT"]);
    lines.for_each(drop);
    assert_eq!(program.wait().unwrap().code(), Some(130));
    let report = verify("interrupted simulation", &folder).report;
    let remarks = report["remarks"].to_string();
    assert!(remarks.contains("It was stopped after step "), "{remarks}");
    assert!(remarks.contains("of 4000"), "{remarks}");
}

/// In windows: the result ends with the one that was stopped, or where that would have begun.
#[test]
fn an_interrupt_among_windows_leaves_a_shorter_result() {
    let folder = fresh_folder("interrupted_windows");
    let scene = folder.join("scene.toml");
    let text = "[grid]\ncells = [24, 20]\n[time]\nsteps = 60\n[source]\ncircle = { center = [0.4, 0.5], radius = 0.2 }\n[[keyframe]]\nstep = 4\n\
                circle = { center = [0.5, 0.5], radius = 0.2 }\n[[keyframe]]\nstep = 60\ncircle = { center = [0.6, 0.5], radius = 0.2 }\n[method]\n\
                window = 8\niterations = 200\ndirect = { tolerance = 1e-12, nested = false }\n[output]\nframes = false\n";
    std::fs::write(&scene, text).unwrap();
    // Stopped in the second window, and in the first, of which one step would be kept.
    for (stride, start) in [("4", 8), ("1", 0)] {
        let name = format!("interrupted_windows_{stride}");
        let out = folder.join(&name);
        let mut command = crate::support::thurible();
        command
            .args(["solve", scene.to_str().unwrap(), "--json", "--set"])
            .args([&format!("method.stride={stride}"), "-o", out.to_str().unwrap()]);
        let its_begin = format!("\"start\":{start}");
        let mut is_inside = false;
        let seen = |line: &str| {
            is_inside |= line.contains("\"window\"") && line.contains(&its_begin);
            is_inside && line.contains("\"event\":\"iteration\"")
        };
        let ended = Endless::seen(&mut command, seen).stop();
        assert_eq!(ended.code, 130, "{}", ended.err);
        assert!(
            ended.out.lines().last().unwrap().contains("\"cancelled\""),
            "{}",
            ended.out
        );
        let outcome = verify(&name, &out);
        let steps = outcome.report["steps"].as_u64().unwrap();
        assert!(
            (8..60).contains(&steps) && outcome.targets.len() == 1,
            "{steps} steps"
        );
        let keyframes = outcome.report["keyframes"].as_array().unwrap();
        assert!(keyframes.len() == 1 && keyframes[0]["step"] == 4, "{keyframes:?}");
        assert!(outcome.report["remarks"][0].as_str().unwrap().contains("of 60"));
    }
}

/// Two signals while the program sleeps, so that it hears both at once.
#[test]
fn a_second_interrupt_ends_at_once() {
    let folder = fresh_folder("interrupted_twice").join("out");
    let (mut program, lines) = endless(&folder);
    signal(&program, &["STOP", "INT", "TERM", "CONT"]);
    let rest: Vec<String> = lines.collect();
    assert_eq!(program.wait().unwrap().code(), Some(130));
    assert!(
        !rest.iter().any(|line| line.contains("\"result\"")) && !folder.exists(),
        "{rest:?}"
    );
}

/// Ctrl-C while a film on finer cells is made: exit code 130, and the film has the pictures so far.
#[test]
fn an_interrupted_film_has_the_pictures_so_far() {
    let scene = crate::lines::FLOW.replace("steps = 6\n", "steps = 90\n");
    let result = crate::render::solved(
        "interrupted_film",
        &scene.replace("iterations = 10", "iterations = 1"),
    );
    let folder = result.with_file_name("film");
    let mut program = crate::support::thurible()
        .args(["render", result.to_str().unwrap(), "-o", folder.to_str().unwrap()])
        .args(["--scale", "8", "--format", "webp", "--json"])
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let mut lines = BufReader::new(program.stdout.take().unwrap())
        .lines()
        .map(Result::unwrap);
    assert!(
        lines.any(|line| line.contains("\"frame\"")),
        "no picture was seen"
    );
    signal(&program, &["INT"]);
    let rest: Vec<String> = lines.collect();
    assert_eq!(program.wait().unwrap().code(), Some(130));
    let frames = 1 + rest.iter().filter(|line| line.contains("\"frame\"")).count();
    let film = BufReader::new(std::fs::File::open(folder.join("render.webp")).unwrap());
    let decoder = image_webp::WebPDecoder::new(film).unwrap();
    assert_eq!(decoder.num_frames() as usize, frames);
    assert!(frames < 91, "all of them");
}

/// A solve that is stopped while its flow becomes too fast behind the release: nothing can be written, and its last state stays.
#[test]
fn an_interrupt_without_a_flow_keeps_the_state() {
    let folder = fresh_folder("interrupted_without_a_flow");
    let (scene, out) = (folder.join("scene.toml"), folder.join("out"));
    let text = "[grid]\ncells = [40, 40]\n[time]\nsteps = 60\n[source]\ncircle = { center = [0.4, 0.3], radius = 0.15 }\n[[keyframe]]\nstep = 20\n\
                circle = { center = [0.6, 0.6], radius = 0.15 }\n[[release]]\nfrom = 21\n[flow]\nbuoyancy = 8.0\n[method]\niterations = 200\n\
                direct = { nested = false }\n[output]\nframes = false\n";
    std::fs::write(&scene, text).unwrap();
    let mut command = crate::support::thurible();
    command.args(["solve", scene.to_str().unwrap(), "--json"]).args([
        "--checkpoint",
        "every=1",
        "-o",
        out.to_str().unwrap(),
    ]);
    let mut seen = 0;
    let ended = Endless::seen(&mut command, |line| {
        seen += usize::from(line.contains("\"event\":\"iteration\""));
        seen == 35
    })
    .stop();
    assert_eq!(ended.code, 1, "{}{}", ended.out, ended.err);
    assert!(ended.err.contains("thurible resume"), "{}", ended.err);
    assert!(!out.exists());
    assert!(
        folder.join("out.checkpoint/state.0").is_file() || folder.join("out.checkpoint/state.1").is_file()
    );
}

/// A window that is only simulated is stopped: the steps behind the stop are not taken for simulated ones.
#[test]
fn an_interrupted_window_of_a_simulation_says_where_it_ends() {
    let folder = fresh_folder("interrupted_simulated_window").join("out");
    let scene = ["simulate", "examples/small_3d.toml", "--steps", "4000"];
    let more = [
        "--set",
        "flow.buoyancy=1e-3",
        "--set",
        "method.window=3000",
        "-o",
        folder.to_str().unwrap(),
    ];
    let (mut program, lines) = begun(&[&scene[..], &more].concat(), "\"window\"");
    std::thread::sleep(core::time::Duration::from_millis(300));
    signal(&program, &["INT"]);
    lines.for_each(drop);
    assert_eq!(program.wait().unwrap().code(), Some(130));
    let report = verify("interrupted window", &folder).report;
    let simulated = report["simulated_steps"].as_u64().unwrap();
    assert!(simulated < 3000, "{simulated}");
    let remarks = report["remarks"].to_string();
    assert!(remarks.contains("It was stopped after step "), "{remarks}");
}
