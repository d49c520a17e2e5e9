//! What is planned is what is used, and a limit of memory holds.

use crate::support::verify::Outcome;
use crate::support::{bytes_after, fresh_folder, run, solve_example};
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
    let needed = bytes_after(&refused.err, "raise --memory-limit to ");
    assert_eq!(solve(&needed.to_string()).code, 0);
    let short = solve(&(needed - 1).to_string());
    assert_eq!(short.code, 3);
    assert!(short.err.contains("`grid.cells`"), "{}", short.err);
}

/// Of ranks the one that needs most says how much.
#[test]
fn the_largest_rank_is_what_a_ceiling_is_for() {
    let plan = |more: &[&str]| run(&[&["plan", "examples/small_3d.toml", "--ranks", "4"], more].concat());
    let refused = plan(&["--memory-limit", "1MiB"]);
    assert!(
        refused.code == 3 && refused.err.contains("rank "),
        "{}",
        refused.err
    );
    let asked = bytes_after(&refused.err, "raise --memory-limit to ").to_string();
    assert_eq!(plan(&["--memory-limit", &asked]).code, 0);
    assert_eq!(plan(&["--device", "cpu"]).code, 0);
    assert!(plan(&["--device", "gpu"]).err.contains("--device gpu: ranks"));
    // One rank is a program with all threads.
    let bytes = |more: &[&str]| {
        let ended = run(&[&["plan", "examples/small_3d.toml", "--json"], more].concat());
        let said: Value = serde_json::from_str(ended.out.trim()).unwrap();
        said["block_bytes"].as_u64().unwrap()
    };
    assert_eq!(bytes(&["--ranks", "1"]), bytes(&[]));
    let alone = run(&["plan", "examples/small_3d.toml", "--device-memory", "1GiB"]);
    assert!(
        alone.code == 2 && alone.err.contains("--device-memory is that of a device"),
        "{}",
        alone.err
    );
}

/// What does not fit is refused with the ways out that there are, and with no others.
#[test]
fn what_does_not_fit_is_told_what_would() {
    let refused = |more: &[&str]| {
        let scene = [
            "plan",
            "examples/letter_f.toml",
            "--set",
            "method.direct.history=5",
        ];
        let ended = run(&[&scene[..], more].concat());
        assert_eq!(ended.code, 3, "{}", ended.err);
        ended.err
    };
    let ways = [
        "--precision f32, which fits",
        "more ranks",
        "in parts by `method.window`",
    ];
    let cases: [(&[&str], [bool; 3]); 6] = [
        (
            &["--precision", "f64", "--memory-limit", "100MiB"],
            [true, false, true],
        ),
        (
            &["--precision", "f64", "--memory-limit", "60MiB"],
            [false, false, true],
        ),
        (
            &["--precision", "f32", "--memory-limit", "60MiB"],
            [false, false, true],
        ),
        (
            &["--memory-limit", "3MiB", "--set", "method.window=20"],
            [false, false, false],
        ),
        (&["--memory-limit", "3MiB", "--ranks", "2"], [false, true, true]),
        (
            &["--memory-limit", "3MiB", "--threads", "1"],
            [false, false, true],
        ),
    ];
    for (more, expected) in cases {
        let said = refused(more);
        let found = ways.map(|way| said.contains(way));
        assert_eq!(found, expected, "{more:?}: {said}");
    }
    // The largest grid of that shape fits, and the next one does not.
    let said = refused(&["--memory-limit", "60MiB"]);
    let (_, rest) = said.split_once("set `grid.cells` to [").unwrap();
    let side: usize = rest.split([',', ']']).next().unwrap().parse().unwrap();
    let with = |side: usize| {
        let cells = format!("grid.cells=[{side},{side}]");
        run(&[
            "plan",
            "examples/letter_f.toml",
            "--set",
            "method.direct.history=5",
            "--memory-limit",
            "60MiB",
            "--set",
            &cells,
        ])
        .code
    };
    assert_eq!((with(side), with(side + 8)), (0, 3), "{said}");
}
