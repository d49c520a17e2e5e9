//! Small scenes of every kind, solved by the program; a second, plain program in `support` checks the results.

use crate::support::verify::{Outcome, verify};
use crate::support::{npz, solve_example};
use serde_json::Value;

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
