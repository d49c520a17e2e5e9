//! Small scenes of every kind, solved by the program; a second, plain program in `support` checks the results.

use crate::support::field::Field;
use crate::support::verify::{Outcome, verify};
use crate::support::{fresh_folder, npz, run, solve_example};
use core::ops::Range;
use serde_json::Value;
use std::path::PathBuf;

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

/// Weights that a scene leaves out are 1000 in a box and steps of length 1, whatever its units are.
#[test]
fn weights_that_are_left_out_follow_the_units() {
    let folder = fresh_folder("units_left_out");
    let scene = folder.join("scene.toml");
    let given = std::fs::read_to_string("examples/small_units.toml").unwrap();
    let is_kept = |line: &&str| !line.starts_with("force_weight") && !line.starts_with("penalty");
    let kept: Vec<&str> = given.lines().filter(is_kept).collect();
    std::fs::write(&scene, kept.join("\n")).unwrap();
    for method in ["direct", "admm"] {
        let totals = |scene: &str, name: &str| {
            let out = folder.join(name).to_str().unwrap().to_owned();
            let choices = [
                "--method",
                method,
                "--set",
                "output.frames=false",
                "--set",
                "method.iterations=4",
            ];
            let ended = run(&[
                &["solve", scene, "--quiet", "--precision", "f64", "-o", &out][..],
                &choices,
            ]
            .concat());
            assert!([0, 5].contains(&ended.code), "{}", ended.err);
            let report = crate::support::json(&PathBuf::from(out).join("report.json"));
            let weight = report["force_weight"].as_f64().unwrap();
            assert!(
                (weight / 3.014_081_790_123_456_6e-5 - 1.0).abs() < 1e-12,
                "{weight}"
            );
            let rows = report["history"].as_array().unwrap().iter();
            rows.map(|row| row["total"].as_f64().unwrap())
                .collect::<Vec<f64>>()
        };
        let said = totals("examples/small_units.toml", &format!("{method}_said"));
        let left_out = totals(scene.to_str().unwrap(), &format!("{method}_left_out"));
        assert_eq!(said.len(), left_out.len());
        for (said, left_out) in said.iter().zip(&left_out) {
            assert!(
                (said / left_out - 1.0).abs() < 1e-9,
                "{method}: {said} and {left_out}"
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
fn a_keyframe_is_held() {
    let sets = [
        "--set",
        "time.steps=8",
        "--set",
        "keyframe[0].hold=2",
        "--set",
        "keyframe[0].step=6",
    ];
    let outcome = verify("held", &solve_example("small_letter", "held", &sets));
    let keyframes = outcome.report["keyframes"].as_array().unwrap();
    let steps: Vec<_> = keyframes
        .iter()
        .filter_map(|keyframe| keyframe["step"].as_u64())
        .collect();
    assert_eq!(steps, [6, 7, 8]);
    assert_eq!(outcome.targets.len(), 3);
    assert!(
        outcome
            .targets
            .iter()
            .all(|(_, target)| target.data == outcome.targets[0].1.data)
    );
}

/// A scene of 16 x 16 cells with one keyframe, held from step 2 to its last.
fn long_hold(test: &str, hold: usize) -> PathBuf {
    let scene = fresh_folder(test).join("scene.toml");
    let text = format!(
        "[grid]\ncells = [16, 16]\n[time]\nsteps = {}\n[source]\ncircle = {{ center = [0.5, 0.5], radius = 0.3 }}\n[[keyframe]]\n\
         step = 2\nhold = {hold}\ncircle = {{ center = [0.5, 0.55], radius = 0.3 }}\n[method]\nname = \"pd\"\n[output]\nframes = false\n",
        hold + 2
    );
    std::fs::write(&scene, text).unwrap();
    scene
}

#[test]
fn a_long_hold_is_planned() {
    let scene = long_hold("plan_hold", 99_998);
    let ended = run(&["plan", scene.to_str().unwrap(), "--json"]);
    assert_eq!(ended.code, 0, "{}", ended.err);
    let plan: Value = serde_json::from_str(&ended.out).unwrap();
    let steps = plan["keyframes"].as_array().unwrap();
    assert_eq!(steps.len(), 99_999);
    assert_eq!((&steps[0], &steps[99_998]), (&2.into(), &100_000.into()));
}

#[test]
fn a_held_keyframe_is_shown_and_said_once() {
    let scene = long_hold("long_hold", 1000);
    let folder = scene.with_file_name("out");
    let ended = run(&["solve", scene.to_str().unwrap(), "-o", folder.to_str().unwrap()]);
    assert_eq!(ended.code, 0, "{}", ended.err);
    let said = "keyframe error: steps 2 to 1002 at most ";
    assert!(ended.out.contains(said), "{}", ended.out);
    let page = std::fs::read_to_string(folder.join("report.html")).unwrap();
    assert!(page.len() < 1 << 20, "a page of {} bytes", page.len());
    assert_eq!(page.matches("<article>").count(), 1);
    assert_eq!(page.matches("Steps 2 to 1002: off by at most ").count(), 1);
    let outcome = Outcome::read(&folder);
    assert_eq!(outcome.report["keyframes"].as_array().unwrap().len(), 1001);
    assert_eq!(outcome.targets.len(), 1001);
}

#[test]
fn target_driven_smoke_holds_a_keyframe_gently() {
    let solved = |test: &str, sets: &[&str]| {
        let mut more = vec!["--method", "pd"];
        more.extend(sets.iter().flat_map(|set| ["--set", set]));
        verify(test, &solve_example("small_two_keyframes", test, &more))
    };
    let sets = ["time.steps=24", "keyframe[1].step=24"];
    let once = solved("pd_once", &sets);
    let held = solved("pd_held", &[sets[0], sets[1], "keyframe[0].hold=6"]);
    let force = |outcome: &Outcome, steps: Range<usize>| {
        outcome.force[steps]
            .iter()
            .flatten()
            .map(Field::max_abs)
            .fold(0.0, f64::max)
    };
    // The way to the keyframe is the same, and what holds the smoke there pulls no harder than what brought it.
    assert_eq!(held.density[..=8], once.density[..=8]);
    let [way, stay] = [force(&held, 0..8), force(&held, 8..14)];
    assert!(stay < way, "forces of {stay} where it is held, {way} on the way");
}
