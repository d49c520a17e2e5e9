//! What is planned is what is used, and a limit of memory holds.

use crate::support::verify::Outcome;
use crate::support::{fresh_folder, run, solve_example};
use serde_json::Value;

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
    let [full, half] = ["full", "half"].map(plan_is_what_it_uses);
    assert!(half < full, "pairs in half the bytes: {half} of {full}");
}

/// The bytes with the pairs of L-BFGS in this precision.
fn plan_is_what_it_uses(precision: &str) -> u64 {
    let set = format!("method.direct.history_precision={precision}");
    let more = ["--threads", "2", "--set", &set];
    let ended = run(&[&["plan", "examples/small_nonsquare.toml", "--json"], &more[..]].concat());
    let plan: Value = serde_json::from_str(&ended.out).unwrap();
    let folder = solve_example(
        "small_nonsquare",
        &format!("plan_is_used_in_{precision}"),
        &[&more[..], &["--set", "method.iterations=3"]].concat(),
    );
    let report = Outcome::read(&folder).report;
    assert_eq!(report["memory"]["planned_bytes"], plan["planned_bytes"]);
    let planned = plan["planned_bytes"].as_u64().unwrap();
    assert!(report["memory"]["used_bytes"].as_u64().unwrap() <= planned + 8192);
    planned
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
