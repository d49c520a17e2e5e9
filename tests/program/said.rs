//! What the program says of results that a status alone would praise, or lose.

use crate::support::verify::verify;
use crate::support::{Ended, fresh_folder, run};
use serde_json::Value;
use std::fs;
use std::path::PathBuf;

/// A box of ten metres and 24 frames a second, with the weights of a box and steps of length 1.
const METRES: &str = "[grid]\ncells = [24, 24]\nlength = 10.0\n[time]\nsteps = 12\ndt = 0.0416667\n\
    [source]\ncircle = { center = [5.0, 5.0], radius = 2.0 }\n[[keyframe]]\nstep = 12\ntext = \"F\"\n\
    [method]\niterations = 60\n[output]\nframes = false\n[method.admm]\npenalty = 1e3\n[control]\nforce_weight = 1e3\n";
/// Two steps, in which a circle is to cross the box, at hardly any price.
const VIOLENT: &str = "[grid]\ncells = [48, 48]\n[time]\nsteps = 2\n\
    [source]\ncircle = { center = [0.2, 0.2], radius = 0.12 }\n[[keyframe]]\nstep = 2\ncircle = { center = [0.8, 0.8], radius = 0.12 }\n\
    [method]\niterations = 60\n[control]\nforce_weight = 1e-3\n[output]\nframes = false\n";

/// Solves a scene: how the program ended, the result folder, and what report.json says.
fn solve(test: &str, scene: &str, more: &[&str]) -> (Ended, PathBuf, Value) {
    let folder = fresh_folder(test);
    let (path, out) = (folder.join("scene.toml"), folder.join("out"));
    fs::write(&path, scene).unwrap();
    let mut arguments = vec![
        "solve",
        path.to_str().unwrap(),
        "--threads",
        "1",
        "-o",
        out.to_str().unwrap(),
    ];
    arguments.extend(more);
    let ended = run(&arguments);
    let report = fs::read(out.join("report.json"))
        .unwrap_or_else(|error| panic!("{test}: {error}; {}{}", ended.out, ended.err));
    (ended, out, serde_json::from_slice(&report).unwrap())
}

/// Largest keyframe error before and after.
fn errors(report: &Value) -> [f64; 2] {
    ["relative_l2_before", "relative_l2"].map(|name| {
        let keyframes = report["keyframes"].as_array().unwrap();
        keyframes
            .iter()
            .map(|keyframe| keyframe[name].as_f64().unwrap())
            .fold(0.0, f64::max)
    })
}

#[test]
fn a_solve_in_which_nothing_moved_says_so_and_names_a_weight_that_moves_it() {
    for (method, precision) in [
        ("direct", "f32"),
        ("direct", "f64"),
        ("lbfgs", "f64"),
        ("admm", "f32"),
    ] {
        let test = format!("metres_{method}_{precision}");
        let chosen = ["--method", method, "--precision", precision];
        let (ended, folder, report) = solve(&test, METRES, &chosen);
        let [before, after] = errors(&report);
        assert!(after > 0.95 * before, "{test}");
        let remark = report["remarks"][0].as_str().unwrap();
        assert!(
            remark.starts_with("the smoke came no nearer to its keyframes: the largest keyframe error is"),
            "{remark}"
        );
        assert!(remark.contains("`control.force_weight` is 3.3e10"), "{remark}");
        assert!(ended.out.contains("keyframe error: step 12 "), "{}", ended.out);
        assert!(ended.out.contains(&format!("note: {remark}")), "{}", ended.out);
        let page = fs::read_to_string(folder.join("report.html")).unwrap();
        assert!(
            page.contains("Note: the smoke came no nearer") && page.contains("with the source held still")
        );
        // With what is to be tried the smoke moves.
        let weights: Vec<&str> = remark
            .split("try ")
            .skip(1)
            .map(|rest| rest.split([',', ' ']).next().unwrap())
            .collect();
        let mut sets = vec!["--set".to_owned(), format!("control.force_weight={}", weights[0])];
        if let Some(penalty) = weights.get(1) {
            sets.extend(["--set".to_owned(), format!("method.admm.penalty={penalty}")]);
        }
        let more: Vec<&str> = chosen
            .into_iter()
            .chain(sets.iter().map(String::as_str))
            .collect();
        let (_, folder, report) = solve(&format!("{test}_again"), METRES, &more);
        let [before, after] = errors(&report);
        assert!(after < 0.8 * before, "{test}: {before} to {after}");
        // Nothing, but that it stops short of the keyframe where it does, or before its gradient is small.
        let converged = report["status"] == "converged";
        let norms = report["history"].as_array().unwrap().iter();
        let on_finest = |row: &&Value| row["level"].as_array().is_none_or(|cells| cells[0] == 24);
        let norms: Vec<f64> = norms
            .filter(on_finest)
            .filter_map(|row| row["gradient_norm"].as_f64())
            .collect();
        let largest = norms.iter().copied().fold(0.0, f64::max);
        let falls = norms.last().is_some_and(|last| last / largest > 0.01);
        let expected = match (converged, after > 0.2, falls) {
            (true, true, _) => Some("it converged, but a keyframe is missed by"),
            (true, false, true) => Some("it converged by its tolerance, but the gradient is still"),
            _ => None,
        };
        let remarks = report["remarks"].as_array().unwrap();
        assert_eq!(remarks.len(), usize::from(expected.is_some()), "{remarks:?}");
        for (remark, expected) in remarks.iter().zip(expected) {
            assert!(remark.as_str().unwrap().starts_with(expected), "{remark}");
        }
        verify(&test, &folder);
    }
}

/// Weights that are left out are those that move the smoke, whatever the units.
#[test]
fn in_metres_the_smoke_moves_by_itself() {
    let weights = "[method.admm]\npenalty = 1e3\n[control]\nforce_weight = 1e3\n";
    let plain = METRES.replace(weights, "");
    assert_ne!(plain, METRES);
    for method in ["direct", "admm"] {
        let (_, _, report) = solve(&format!("metres_plain_{method}"), &plain, &["--method", method]);
        let [before, after] = errors(&report);
        assert!(after < 0.5 * before, "{method}: {before} to {after}");
    }
}

#[test]
fn a_step_that_is_not_finite_leaves_the_last_good_flow() {
    for method in ["direct", "lbfgs", "pd"] {
        for precision in ["f32", "f64"] {
            let test = format!("violent_{method}_{precision}");
            let (ended, folder, report) =
                solve(&test, VIOLENT, &["--method", method, "--precision", precision]);
            assert!([0, 5].contains(&ended.code), "{test}: {}", ended.err);
            let [before, after] = errors(&report);
            assert!(before > 1.0 && after.is_finite(), "{test}");
            verify(&test, &folder);
        }
    }
}

#[test]
fn a_comparison_says_so_too() {
    let folder = fresh_folder("compare_metres");
    let (path, out) = (folder.join("scene.toml"), folder.join("out"));
    fs::write(&path, METRES).unwrap();
    let ended = run(&[
        "compare",
        path.to_str().unwrap(),
        "--methods",
        "direct,pd",
        "-o",
        out.to_str().unwrap(),
    ]);
    assert_eq!(ended.code, 0, "{}", ended.err);
    let page = fs::read_to_string(out.join("compare.md")).unwrap();
    assert!(page.contains("direct: the smoke came no nearer"), "{page}");
    let facts: Value = serde_json::from_slice(&fs::read(out.join("compare.json")).unwrap()).unwrap();
    let [direct, pd] = [0, 1].map(|row| &facts["rows"][row]);
    assert_eq!(direct["keyframe_error_before"], pd["keyframe_error_before"]);
    assert_eq!(direct["remarks"].as_array().unwrap().len(), 1);
    assert_eq!(pd["remarks"].as_array().unwrap().len(), 0);
}
