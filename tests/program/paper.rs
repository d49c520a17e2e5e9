//! `thurible paper` from end to end, at an eighth of its size.

use super::compare::{cell, check_row, table};
use crate::support::verify::verify;
use crate::support::{fresh_folder, json, run};
use serde_json::{Value, json as value};
use std::fs;

#[test]
fn every_scene_of_the_paper_parses_and_plans() {
    for (scale, size) in [
        ("1", "128 x 128, 40 steps"),
        ("1/2", "64 x 64, 40 steps"),
        ("1/8", "16 x 16, 40 steps"),
    ] {
        // A list takes no memory, whatever the scenes take.
        let ended = run(&["paper", "--list", "--scale", scale, "--memory-limit", "1MiB"]);
        assert_eq!(ended.code, 0, "{}", ended.err);
        let line = |name: &str| {
            ended
                .out
                .lines()
                .find(|line| line.trim_start().starts_with(name))
                .unwrap_or_else(|| panic!("{name} is not listed"))
                .to_owned()
        };
        assert!(line("fluid_f ").contains(size), "{}", line("fluid_f "));
        assert!(line("optimality ").ends_with("by admm") && line("figure ").contains("punches"));
        assert!(line("pd_gathering ").ends_with("only by pd"));
    }
    let listed = run(&["paper", "--list", "--scale", "1/8", "--json"]);
    let scenes: Vec<Value> = listed
        .out
        .lines()
        .map(|line| serde_json::from_str(line).unwrap())
        .collect();
    let fluid = scenes.iter().find(|scene| scene["name"] == "fluid_f").unwrap();
    assert_eq!(
        (&fluid["steps"], &fluid["cells"]),
        (&value!(40), &value!([16, 16]))
    );
    assert!(fluid["bytes"].as_u64().unwrap() > 0);
}

#[test]
fn a_page_of_the_papers_scenes() {
    let folder = fresh_folder("paper").join("out");
    let out = folder.to_str().unwrap();
    let arguments = [
        "paper",
        "abc",
        "fig7",
        "genus",
        "--scale",
        "1/8",
        "--threads",
        "1",
        "--quiet",
        "--no-pictures",
        "--set",
        "method.iterations=3",
        "-o",
        out,
    ];
    let ended = run(&arguments);
    assert_eq!(ended.code, 0, "{}", ended.err);
    let (facts, page) = (
        json(&folder.join("paper.json")),
        fs::read_to_string(folder.join("paper.md")).unwrap(),
    );
    let scenes = facts["scenes"].as_array().unwrap();
    assert_eq!(
        scenes
            .iter()
            .map(|scene| scene["name"].as_str().unwrap())
            .collect::<Vec<_>>(),
        ["abc", "genus", "optimality"]
    );
    assert_eq!(
        scenes[2]["rows"].as_array().unwrap().len(),
        1,
        "figure 7 is about admm alone"
    );
    for scene in scenes {
        let name = scene["name"].as_str().unwrap();
        for row in scene["rows"].as_array().unwrap() {
            let method = folder.join(name).join(row["method"].as_str().unwrap());
            check_row(row, &json(&method.join("report.json")));
            assert!(!method.join("result.npz").exists(), "arrays were not asked for");
        }
    }
    let table = table(&page);
    assert_eq!(table.len(), 1 + 5);
    let rows = scenes.iter().flat_map(|scene| scene["rows"].as_array().unwrap());
    for (index, row) in rows.enumerate() {
        let said = cell(&table, index, "ended").strip_prefix("failed: ");
        assert_eq!(said, row["failed"].as_str());
        let missed = row["keyframe_error"].as_f64().unwrap() > 0.2;
        assert_eq!(
            said.is_some_and(|why| why.contains("missed by")),
            missed,
            "{said:?}"
        );
    }
    assert!(
        scenes[0]["rows"][1]["failed"]
            .as_str()
            .unwrap()
            .ends_with("at its limit"),
        "three iterations are no convergence of admm"
    );
    assert!(page.contains("A row has failed where"));
    assert_eq!(cell(&table, 0, "size"), "16 \u{d7} 16, 60 steps");
    assert!(
        page.contains("not for the 1/8 of this run") && page.contains("0.67 GB"),
        "the paper's own figures are not set apart"
    );
    assert!(
        page.contains("thurible paper abc fig7 genus") && !page.contains(out),
        "the page shows a path of this machine"
    );
    assert!(
        !page.contains("<img") && !folder.join("paper_pictures").exists(),
        "no pictures were asked for"
    );
    let again = run(&[
        "paper",
        "abc",
        "--methods",
        "direct",
        "--scale",
        "1/8",
        "--arrays",
        "--quiet",
        "--set",
        "method.iterations=1",
        "--force",
        "-o",
        out,
    ]);
    assert_eq!(again.code, 0, "{}", again.err);
    verify("abc", &folder.join("abc/direct"));
}

/// LBFGS ends by the paper's rule, and the iterations that it took stand beside those of the paper, whose figures stand by their methods.
#[test]
fn lbfgs_ends_as_in_the_paper() {
    let folder = fresh_folder("paper_lbfgs").join("out");
    let ended = run(&[
        "paper",
        "fluid",
        "--scale",
        "1/8",
        "--methods",
        "lbfgs,admm",
        "--quiet",
        "--no-pictures",
        "-o",
        folder.to_str().unwrap(),
    ]);
    assert_eq!(ended.code, 0, "{}", ended.err);
    let facts = json(&folder.join("paper.json"));
    let page = fs::read_to_string(folder.join("paper.md")).unwrap();
    let beside = page.split_once("Beside the paper's Table 2").unwrap().1;
    let beside = table(beside);
    for (index, scene) in facts["scenes"].as_array().unwrap().iter().enumerate() {
        let row = &scene["rows"][0];
        let iterations = row["iterations"].as_u64().unwrap();
        assert_eq!(row["status"], "converged");
        assert!((2..500).contains(&iterations), "{iterations}");
        let [lbfgs, admm] = [2 * index, 2 * index + 1];
        assert_eq!(cell(&beside, lbfgs, "iterations"), iterations.to_string());
        assert_eq!(cell(&beside, lbfgs, "paper: iterations of LBFGS"), "71");
        assert_eq!(cell(&beside, lbfgs, "paper: iterations"), "");
        assert_eq!(cell(&beside, admm, "paper: iterations"), "13");
        assert_eq!(cell(&beside, admm, "paper: iterations of LBFGS"), "");
    }
}
