//! The program from end to end on small scenes; the results are checked by a second, plain program in `support`.
#![cfg(feature = "std")]
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a test says what went wrong by panicking"
)]

mod support;

use serde_json::Value;
use std::fs;
#[cfg(unix)]
use std::io::{BufRead, BufReader};
use std::path::Path;
#[cfg(unix)]
use std::process::{Child, Command, Stdio};
use support::verify::{Outcome, verify};
use support::{fresh_folder, npz, run, solve_example};

fn solved(name: &str, precision: &str) -> Outcome {
    let test = format!("{name}_{precision}");
    verify(&test, &solve_example(name, &test, &["--precision", precision]))
}

#[test]
fn letter_between_walls() {
    // From rest: a nested start leaves the first iteration little to gain.
    let from_rest = ["--set", "method.admm.nested=false"];
    let outcome = verify(
        "small_letter_f32",
        &solve_example("small_letter", "small_letter_f32", &from_rest),
    );
    let history = outcome.report["history"].as_array().unwrap();
    let total = |row: &Value| row["total"].as_f64().unwrap();
    assert!(
        total(history.last().unwrap()) < 0.5 * total(&history[0]),
        "the objective hardly fell"
    );
}

#[test]
fn ball_in_three_dimensions() {
    solved("small_3d", "f32");
    solved("small_3d", "f64");
}

#[test]
fn box_without_walls() {
    solved("small_periodic", "f32");
    solved("small_periodic", "f64");
}

#[test]
fn channel_with_one_periodic_axis() {
    solved("small_mixed", "f32");
}

#[test]
fn three_dimensions_with_one_periodic_axis() {
    let sets = [
        "--set",
        "grid.boundary=[\"wall\",\"periodic\",\"wall\"]",
        "--set",
        "grid.cells=[12,16,14]",
        "--set",
        "method.iterations=4",
    ];
    verify("mixed 3D", &solve_example("small_3d", "mixed_3d", &sets));
}

#[test]
fn box_that_is_not_square() {
    solved("small_nonsquare", "f32");
    solved("small_nonsquare", "f64");
}

#[test]
fn odd_numbers_of_cells() {
    solved("small_odd", "f32");
}

#[test]
fn odd_numbers_of_cells_without_walls() {
    verify(
        "odd periodic",
        &solve_example("small_odd", "odd_periodic", &["--set", "grid.boundary=periodic"]),
    );
}

#[test]
fn two_keyframes() {
    let outcome = solved("small_two_keyframes", "f32");
    assert_eq!(
        outcome.targets.iter().map(|(step, _)| *step).collect::<Vec<_>>(),
        [8, 16]
    );
}

#[test]
fn central_transport() {
    solved("small_central", "f64");
}

#[test]
fn semi_lagrangian_transport() {
    verify(
        "semi_lagrangian",
        &solve_example(
            "small_central",
            "semi_lagrangian",
            &["--set", "advection.scheme=semi_lagrangian"],
        ),
    );
}

#[test]
fn other_colours_of_the_smoother() {
    verify(
        "2^d",
        &solve_example(
            "small_nonsquare",
            "power_of_two",
            &["--set", "method.admm.smoother_colours=2^d"],
        ),
    );
}

/// dt = 1/24 and length = 10 make the same iterates as dt = length = 1 with weights scaled accordingly.
#[test]
fn other_units_make_the_same_iterates() {
    let twin = [
        "--set",
        "grid.length=1",
        "--set",
        "time.dt=1",
        "--set",
        "control.force_weight=1000",
        "--set",
        "flow.viscosity=1e-4",
        "--set",
        "method.admm.penalty=1000",
        "--set",
        "source.circle={center=[0.4,0.45],radius=0.2}",
        "--set",
        "keyframe[0].circle={center=[0.6,0.55],radius=0.2}",
        "--precision",
        "f64",
    ];
    let scaled = verify("scaled twin", &solve_example("small_units", "units_twin", &twin));
    let metric = solved("small_units", "f64");
    let rows = |outcome: &Outcome| outcome.report["history"].as_array().unwrap().clone();
    assert_eq!(
        rows(&scaled).len(),
        rows(&metric).len(),
        "different numbers of iterations"
    );
    for (left, right) in scaled.density.iter().zip(&metric.density) {
        for (left, right) in left.data.iter().zip(&right.data) {
            assert!(
                (left - right).abs() < 1e-7,
                "densities differ: {left} and {right}"
            );
        }
    }
    for (left, right) in scaled
        .velocity
        .iter()
        .flatten()
        .zip(metric.velocity.iter().flatten())
    {
        let size = left.max_abs().max(1e-9);
        for (left, right) in left.data.iter().zip(&right.data) {
            assert!(
                (left - right / 240.0).abs() < 1e-6 * size,
                "velocities differ: {left} and {right} / 240"
            );
        }
    }
}

#[test]
fn any_number_of_threads_makes_the_same_bits() {
    let result = |threads: &str| {
        let test = format!("threads_{threads}");
        npz::read(
            &solve_example(
                "small_nonsquare",
                &test,
                &["--threads", threads, "--set", "method.iterations=3"],
            )
            .join("result.npz"),
        )
    };
    let one = result("1");
    assert_eq!(one, result("2"));
    assert_eq!(one, result("3"));
}

#[test]
fn a_new_scene_solves_as_it_is() {
    let folder = fresh_folder("new_scene");
    let name = folder.join("my smoke");
    let ended = run(&["new", name.to_str().unwrap()]);
    assert_eq!((ended.code, ended.err.as_str()), (0, ""));
    let scene = folder.join("my smoke.toml");
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

/// The direct method begins on coarser grids, and the report says on which.
#[test]
fn the_direct_method_names_its_grids() {
    let folder = solve_example(
        "small_central",
        "direct_levels",
        &["--method", "direct", "--set", "method.iterations=2"],
    );
    let report = verify("direct levels", &folder).report;
    let history = report["history"].as_array().unwrap();
    assert_eq!(history.last().unwrap()["level"], report["cells"]);
    assert_ne!(history[0]["level"], report["cells"]);
    assert!(
        history
            .iter()
            .all(|row| row.get("kkt").is_none() && row["evaluations"].as_u64().unwrap() > 0)
    );
}

/// The objective goes in steps where transport is cut early. Cut a hundred times earlier on the coarser grids, the search took one of
/// them for its end and came to 33.6 here, not 31.0.
#[test]
fn the_early_cut_of_the_search_does_not_end_it_on_coarser_grids() {
    let ends_at = |cut: &str| {
        let sets = [
            "--method",
            "direct",
            "--set",
            "grid.cells=[64, 64]",
            "--set",
            "control.force_weight=1e5",
            "--set",
            cut,
        ];
        let folder = solve_example("letter_f", "early_cut", &sets);
        let report: Value =
            serde_json::from_str(&fs::read_to_string(folder.join("report.json")).unwrap()).unwrap();
        report["objective"]["total"].as_f64().unwrap()
    };
    let (as_usual, exact) = (
        ends_at("advection.tolerance=1e-5"),
        ends_at("advection.tolerance=1e-7"),
    );
    assert!(as_usual < 1.02 * exact, "J = {as_usual}, with less cut {exact}");
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
fn plan_adds_up_and_allocates_nothing() {
    let ended = run(&[
        "plan",
        "examples/moving_sphere.toml",
        "--json",
        "--threads",
        "2",
        "--method",
        "admm",
    ]);
    assert_eq!(ended.code, 0, "{}", ended.err);
    let plan: Value = serde_json::from_str(&ended.out).unwrap();
    let ledger = plan["ledger"].as_array().unwrap();
    let top: u64 = ledger
        .iter()
        .filter(|entry| entry["depth"] == 0)
        .map(|entry| entry["bytes"].as_u64().unwrap())
        .sum();
    assert_eq!(top, plan["planned_bytes"].as_u64().unwrap());
    assert_eq!(plan["paper_bound_bytes"], 1_150_437_668_u64);
    let phases = plan["phases"].as_array().unwrap();
    assert_eq!(
        phases.iter().map(|phase| phase["bytes"].as_u64().unwrap()).max(),
        plan["planned_bytes"].as_u64()
    );
    assert!(
        phases
            .iter()
            .any(|phase| phase["name"] == "advection problem (AO): projection"),
        "{phases:?}"
    );
    assert!(plan["method_bytes"].as_u64().unwrap() <= 1_150_437_668);
    let human = run(&[
        "plan",
        "examples/moving_sphere.toml",
        "--set",
        "grid.cells=[4096,4096,4096]",
        "--set",
        "time.steps=1000",
    ]);
    assert!(human.code == 0 || human.code == 3, "{}", human.err);
}

#[test]
fn plan_is_what_solve_uses() {
    let ended = run(&[
        "plan",
        "examples/small_nonsquare.toml",
        "--json",
        "--threads",
        "2",
    ]);
    let plan: Value = serde_json::from_str(&ended.out).unwrap();
    let folder = solve_example(
        "small_nonsquare",
        "plan_is_used",
        &["--threads", "2", "--set", "method.iterations=1"],
    );
    let report = Outcome::read(&folder).report;
    assert_eq!(report["memory"]["planned_bytes"], plan["planned_bytes"]);
    assert!(
        report["memory"]["used_bytes"].as_u64().unwrap() <= plan["planned_bytes"].as_u64().unwrap() + 8192
    );
}

#[test]
fn memory_limit_that_is_asked_for_is_enough_and_one_byte_less_is_not() {
    let solve = |limit: &str| {
        let folder = fresh_folder("memory_limit").join("out");
        let scene = [
            "solve",
            "examples/small_nonsquare.toml",
            "--quiet",
            "--threads",
            "1",
            "-o",
            folder.to_str().unwrap(),
        ];
        let sets = [
            "--set",
            "output.frames=false",
            "--set",
            "method.iterations=1",
            "--memory-limit",
            limit,
        ];
        run(&[scene.as_slice(), sets.as_slice()].concat())
    };
    let refused = solve("1 byte");
    assert_eq!(refused.code, 3);
    let asked = refused
        .err
        .split("raise --memory-limit to ")
        .nth(1)
        .unwrap()
        .split(' ')
        .next()
        .unwrap();
    let needed: u64 = asked.replace(',', "").parse().unwrap();
    assert_eq!(solve(&needed.to_string()).code, 0);
    let short = solve(&(needed - 1).to_string());
    assert_eq!(short.code, 3);
    assert!(short.err.contains("`grid.cells`"), "{}", short.err);
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

#[test]
fn the_methods_to_compare_with() {
    verify(
        "lbfgs",
        &solve_example(
            "small_letter",
            "lbfgs",
            &["--method", "lbfgs", "--set", "method.iterations=4"],
        ),
    );
    let outcome = verify("pd", &solve_example("small_letter", "pd", &["--method", "pd"]));
    assert_eq!(
        (
            outcome.report["method"].as_str(),
            outcome.report["history"].as_array().unwrap().len()
        ),
        (Some("pd"), 1)
    );
}

/// Runs `simulate` into a fresh folder.
fn simulated(test: &str, more: &[&str]) -> std::path::PathBuf {
    let folder = fresh_folder(test).join("out");
    let mut arguments = vec![
        "simulate",
        "examples/small_central.toml",
        "--quiet",
        "--set",
        "output.frames=false",
        "-o",
        folder.to_str().unwrap(),
    ];
    arguments.extend(more);
    let ended = run(&arguments);
    assert_eq!(ended.code, 0, "{test}: {}", ended.err);
    folder
}

/// A controlled result goes on freely: from its last density and velocity, with next to no force.
#[test]
fn a_result_is_continued_freely() {
    let controlled = solve_example("small_central", "to_continue", &["--set", "method.iterations=3"]);
    let before = Outcome::read(&controlled);
    let after = verify(
        "continued",
        &simulated(
            "continued",
            &["--from", controlled.to_str().unwrap(), "--steps", "7"],
        ),
    );
    assert_eq!(
        (after.density.len(), after.velocity.len(), after.targets.len()),
        (8, 7, 0)
    );
    let (end, start) = (before.density.last().unwrap(), &after.density[0]);
    assert!(
        end.data
            .iter()
            .zip(&start.data)
            .all(|(x, y)| (x.max(0.0) - y).abs() < 1e-6),
        "the density does not go on"
    );
    let (end, start) = (before.velocity.last().unwrap(), &after.velocity[0]);
    let fastest = end.iter().map(support::field::Field::max_abs).fold(0.0, f64::max);
    assert!(
        fastest > 0.0
            && end.iter().zip(start).all(|(x, y)| x
                .data
                .iter()
                .zip(&y.data)
                .all(|(x, y)| (x - y).abs() < 1e-4 * fastest))
    );
    assert!(
        after
            .force
            .iter()
            .flatten()
            .all(|field| field.max_abs() < 1e-4 * fastest)
    );
}

#[test]
fn smoke_rises_without_control() {
    let outcome = verify(
        "buoyant",
        &simulated(
            "buoyant",
            &[
                "--set",
                "simulation.buoyancy=1e-3",
                "--set",
                "flow.viscosity=1e-3",
            ],
        ),
    );
    assert_eq!(outcome.report["viscosity"].as_f64(), Some(1e-3));
    assert_eq!(
        (
            outcome.report["method"].as_str(),
            outcome.report["status"].as_str()
        ),
        (Some("simulate"), Some("converged"))
    );
    assert!(outcome.velocity.last().unwrap()[1].max_abs() > 1e-4);
}

/// Ctrl-C in the middle: exit code 130, and what there is is written and feasible.
/// A solve that goes on until it is stopped, seen to iterate; and the lines of JSON that it will yet print.
#[cfg(unix)]
fn endless(folder: &Path) -> (Child, impl Iterator<Item = String>) {
    let mut program = support::thurible()
        .args([
            "solve",
            "examples/small_letter.toml",
            "--json",
            "--set",
            "method.iterations=100000",
            "--set",
            "output.frames=false",
        ])
        .args([
            "--set",
            "method.admm.density_tolerance=1e-12",
            "-o",
            folder.to_str().unwrap(),
        ])
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let mut lines = BufReader::new(program.stdout.take().unwrap())
        .lines()
        .map(Result::unwrap);
    assert!(
        lines.any(|line| line.contains("\"iteration\"")),
        "no iteration was seen"
    );
    (program, lines)
}

/// Sends `signals` to `program`, one after the other.
#[cfg(unix)]
fn signal(program: &Child, signals: &[&str]) {
    let kill: String = signals
        .iter()
        .map(|signal| format!("kill -{signal} {}; ", program.id()))
        .collect();
    assert!(Command::new("sh").args(["-c", &kill]).status().unwrap().success());
}

/// Ctrl-C in the middle: exit code 130, and what there is is written and feasible.
#[cfg(unix)]
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

/// Two signals while the program sleeps, so that it hears both at once.
#[cfg(unix)]
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
