//! The other methods by the program, and results that go on.

use crate::small::refused;
use crate::support::verify::{Outcome, verify};
use crate::support::{fresh_folder, run, solve_example};
use serde_json::Value;
use std::fs;

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
    assert!(history.iter().all(|row| row.get("kkt").is_none()
        && row["evaluations"].as_u64().unwrap() > 0
        && row["gradient_norm"].as_f64().unwrap() > 0.0));
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
            "method.direct={}",
            "--set",
            "method.iterations=50",
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
    // The last density has no flow yet that carries it on: it comes again.
    let last = before.velocity.len() - 1;
    let (end, start) = (&before.density[last], &after.density[0]);
    assert!(
        end.data
            .iter()
            .zip(&start.data)
            .all(|(x, y)| (x.max(0.0) - y).abs() < 1e-6),
        "the density does not go on"
    );
    let (end, start) = (before.velocity.last().unwrap(), &after.velocity[0]);
    let fastest = end
        .iter()
        .map(crate::support::field::Field::max_abs)
        .fold(0.0, f64::max);
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
    let folder = simulated(
        "buoyant",
        &["--set", "flow.buoyancy=1e-3", "--set", "flow.viscosity=1e-3"],
    );
    let outcome = verify("buoyant", &folder);
    let page = fs::read_to_string(folder.join("report.html")).unwrap();
    assert!(
        page.contains("Simulated in one pass") && !page.contains("Converged"),
        "{page}"
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

#[test]
fn admm_prices_no_curls() {
    let example = "examples/small_letter.toml";
    let command = [
        "solve",
        example,
        "--method",
        "admm",
        "--quiet",
        "--set",
        "control.smoothness=1.5",
    ];
    let words = [
        "--set control.smoothness=1.5: `control.smoothness` is more than",
        "the method admm",
        "0 or \"auto\"",
        "another method",
    ];
    refused(&run(&command), &words);
}
