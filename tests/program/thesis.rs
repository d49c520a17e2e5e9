//! `thurible thesis` from end to end, at an eighth of its size.

use super::compare::{cell, table};
#[cfg(unix)]
use crate::support::endless::Endless;
use crate::support::{fresh_folder, json, npz, run};
use serde_json::Value;
use std::fs;
use std::path::Path;

/// The rows of a figure in the facts of a page.
fn rows<'a>(facts: &'a Value, name: &str) -> &'a [Value] {
    let figures = facts["figures"].as_array().unwrap();
    let figure = figures.iter().find(|figure| figure["name"] == name);
    figure.unwrap()["rows"].as_array().unwrap()
}

/// The table of a part of the page.
fn table_of<'a>(page: &'a str, heading: &str) -> Vec<Vec<&'a str>> {
    table(page.split_once(&format!("## {heading}")).unwrap().1)
}

fn number(row: &Value, column: &str) -> f64 {
    row["ours"][column]
        .as_f64()
        .unwrap_or_else(|| panic!("{column} is no number in {row}"))
}

fn make(out: &Path, arguments: &[&str]) {
    let out = [
        "--scale",
        "1/8",
        "--threads",
        "1",
        "--quiet",
        "--force",
        "-o",
        out.to_str().unwrap(),
    ];
    let ended = run(&[&["thesis"], arguments, &out].concat());
    assert_eq!(ended.code, 0, "{}", ended.err);
}

#[test]
fn the_list_names_every_figure_of_the_thesis() {
    let ended = run(&["thesis", "--list", "--scale", "1/4"]);
    assert_eq!(ended.code, 0, "{}", ended.err);
    let names = [
        "fig3.7", "fig3.8", "fig3.10", "fig3.12", "fig3.13", "fig4.3", "fig4.8", "fig4.9", "fig4.10",
        "fig4.11", "fig4.12", "speed", "fig5.1", "fig5.2", "fig5.3", "fig5.4", "fig5.5", "fig5.6", "fig5.7",
        "fig5.8", "fig5.9", "fig5.10",
    ];
    for name in names {
        let line = ended
            .out
            .lines()
            .find(|line| line.starts_with(&format!("{name} ")));
        let line = line.unwrap_or_else(|| panic!("{name} is not listed"));
        assert!(line.contains(" about ") && line.ends_with('B'), "{line}");
    }
    let members = |group: &str| {
        let line = ended
            .out
            .lines()
            .find(|line| line.starts_with(&format!("{group} ")));
        let line = line.unwrap_or_else(|| panic!("{group} is not listed"));
        line.split_whitespace()
            .skip(1)
            .map(str::to_owned)
            .collect::<Vec<_>>()
    };
    assert_eq!(members("fig3.9"), ["fig3.8"]);
    for alias in ["fig3.9", "fig3.11", "fig4.4", "fig4.5", "fig4.6", "fig4.7"] {
        assert!(
            members(alias)
                .iter()
                .all(|member| names.contains(&member.as_str()))
        );
    }
    // The word for all of them has them all, or it would be listed as a group as well.
    let whole: Vec<&str> = ended
        .out
        .lines()
        .filter(|line| line.starts_with("all "))
        .collect();
    assert!(
        matches!(whole[..], [line] if line.contains("all of them")),
        "{whole:?}"
    );
    // Every figure is in its chapter.
    assert_eq!(["chapter3", "chapter4", "chapter5"].map(members).concat(), names);
}

#[test]
fn an_unknown_figure_is_refused_with_those_that_there_are() {
    let ended = run(&["thesis", "fig5.11"]);
    assert_eq!(ended.code, 2);
    assert!(
        ended.err.contains("\"fig5.11\"") && ended.err.contains("fig5.10, all, chapter3"),
        "{}",
        ended.err
    );
}

#[test]
fn a_page_of_the_phantom() {
    let folder = fresh_folder("thesis").join("out");
    make(&folder, &["fig3.7", "--no-pictures"]);
    let (facts, page) = (
        json(&folder.join("thesis.json")),
        fs::read_to_string(folder.join("thesis.md")).unwrap(),
    );
    let rows = rows(&facts, "fig3.7");
    let table = table_of(&page, "Figure 3.7");
    let expected = [
        ("sart", "0.104"),
        ("walk", "0.090"),
        ("l2", "0.085"),
        ("tv", "0.085"),
        ("sad", "0.080"),
        ("sad_nonnegative", "\u{2013}"),
    ];
    assert_eq!(rows.len(), expected.len());
    for (index, (row, (run, thesis))) in rows.iter().zip(expected).enumerate() {
        let report = json(&folder.join("phantom").join(run).join("report.json"));
        assert_eq!(row["ours"]["RMS error"], report["rms_error"], "{run}");
        assert_eq!(row["planned_bytes"], report["memory"]["planned_bytes"], "{run}");
        assert_eq!(cell(&table, index, "thesis: RMS error"), thesis);
        assert_eq!(cell(&table, index, "ended"), "done");
        assert!(
            row["failed"].is_null() && (0.01..0.2).contains(&number(row, "RMS error")),
            "{row}"
        );
        assert!(
            !folder.join("phantom").join(run).join("result.npz").exists(),
            "arrays were not asked for"
        );
    }
    assert!(
        number(&rows[4], "RMS error") < number(&rows[1], "RMS error"),
        "a prior helps"
    );
    assert!(page.contains("not for the 1/8 of this run") && page.contains("A row has failed where"));
    assert!(page.contains("thurible thesis fig3.7") && !page.contains(folder.to_str().unwrap()));
    assert!(!page.contains("<img"), "no pictures were asked for");
    make(&folder, &["fig3.9", "--arrays"]);
    let page = fs::read_to_string(folder.join("thesis.md")).unwrap();
    assert!(
        page.contains("## Figures 3.8 and 3.9") && page.contains("<img"),
        "{page}"
    );
    assert!(
        folder.join("tube/sad_16/result.npz").exists(),
        "arrays were asked for"
    );
}

/// The true flow of a capture has no divergence and carries its density, and what rows say of tracks is what these wrote down.
#[test]
fn a_capture_and_its_tracks() {
    let folder = fresh_folder("thesis_capture").join("out");
    make(&folder, &["fig5.4", "fig5.2", "--arrays"]);
    let truth = npz::read(&folder.join("smoke/truth/truth.npz"));
    let (density, u, v, w) = (
        &truth["density"],
        &truth["velocity_x"],
        &truth["velocity_y"],
        &truth["velocity_z"],
    );
    let [frames, nz, ny, nx] = density.shape[..] else {
        panic!("{:?}", density.shape)
    };
    assert_eq!([frames, w.shape[0]], [60, 59]);
    assert_eq!(w.shape[1..], [nz + 1, ny, nx]);
    let (mut largest, mut fastest) = (0.0f64, 0.0f64);
    for cell in 0..nx * ny * nz {
        let (x, y, z) = (cell % nx, cell / nx % ny, cell / (nx * ny));
        let at = |of: &npz::Array, [x, y, z]: [usize; 3]| {
            let [_, _, rows, columns] = of.shape[..] else {
                panic!()
            };
            of.data[30 * of.shape[1] * rows * columns + (z * rows + y) * columns + x]
        };
        let out = [(u, [x + 1, y, z]), (v, [x, y + 1, z]), (w, [x, y, z + 1])];
        let leaving: f64 = out
            .iter()
            .map(|(of, high)| at(of, *high) - at(of, [x, y, z]))
            .sum();
        largest = largest.max(leaving.abs());
        fastest = fastest.max(at(w, [x, y, z]).abs());
    }
    assert!(
        largest < 1e-3 * fastest && fastest > 0.01,
        "{largest} of {fastest}"
    );
    let mass = |frame: usize| {
        density
            .data
            .iter()
            .skip(frame * nx * ny * nz)
            .take(nx * ny * nz)
            .sum::<f64>()
    };
    assert!((mass(59) / mass(0) - 1.0).abs() < 1e-3, "smoke is lost");
    let facts = json(&folder.join("thesis.json"));
    let report = json(&folder.join("smoke/direct/report.json"));
    let history = report["history"].as_array().unwrap();
    assert_eq!(
        rows(&facts, "fig5.4")[3]["ours"]["off at the end"],
        history[58]["readvection_error"]
    );
    let counted = history
        .iter()
        .skip(19)
        .map(|pair| pair["velocity_rms_error"].as_f64().unwrap());
    let mean = counted.sum::<f64>() / 40.0;
    let said = number(&rows(&facts, "fig5.2")[4], "RMS, cells a frame");
    assert!((said - mean).abs() < 1e-9, "{said} for {mean}");
}

#[cfg(unix)]
#[test]
fn an_interrupt_leaves_the_page_of_what_there_is() {
    let folder = fresh_folder("thesis_interrupted").join("out");
    let mut command = crate::support::thurible();
    command.args([
        "thesis",
        "fig4.8",
        "speed",
        "fig5.2",
        "--scale",
        "1/8",
        "--threads",
        "1",
        "--json",
    ]);
    command.args(["-o", folder.to_str().unwrap()]);
    let second = |line: &str| line.contains("\"figure\"") && line.contains("\"speed\"");
    let ended = Endless::seen(&mut command, second).stop();
    assert_eq!(ended.code, 130, "{}", ended.err);
    let facts = json(&folder.join("thesis.json"));
    assert_eq!(rows(&facts, "fig4.8").len(), 2);
    assert_eq!(facts["figures"][1]["whole"], false);
    let page = fs::read_to_string(folder.join("thesis.md")).unwrap();
    let table = table(&page);
    let ended: Vec<&str> = (0..3).map(|row| cell(&table, row, "ended")).collect();
    assert_eq!(ended, ["2 rows", "interrupted after 0 rows", "not run"]);
    assert!(page.contains("Not run: the run was stopped before."));
    assert!(
        fs::read_to_string(folder.join("thesis.html"))
            .unwrap()
            .ends_with("</html>\n")
    );
}
