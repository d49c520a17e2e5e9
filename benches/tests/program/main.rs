//! `thurible-bench`: the memory table against sums and formulas of its own, the tables of speed in small, and the pages.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a test says what went wrong by panicking"
)]

mod memory;

use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// The exit code and what was printed on stdout and stderr.
struct Ended {
    code: i32,
    out: String,
    err: String,
}

/// Runs the program with all words of `arguments`.
fn run(arguments: &[&[&str]]) -> Ended {
    let mut command = Command::new(env!("CARGO_BIN_EXE_thurible-bench"));
    let output = command.args(arguments.concat()).output().unwrap();
    Ended {
        code: output.status.code().unwrap_or(-1),
        out: String::from_utf8_lossy(&output.stdout).into_owned(),
        err: String::from_utf8_lossy(&output.stderr).into_owned(),
    }
}

/// A fresh, empty folder for the test `name`.
fn fresh_folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    if folder.exists() {
        fs::remove_dir_all(&folder).unwrap();
    }
    fs::create_dir_all(&folder).unwrap();
    folder
}

fn number(row: &Value, name: &str) -> u64 {
    row[name].as_u64().unwrap_or_else(|| panic!("{name} of {row}"))
}

#[test]
fn bench_refuses_what_it_does_not_know() {
    for words in [
        &["speed"][..],
        &["memory", "--row", "99"],
        &["--threads", "0"],
        &["--quiet", "--json"],
        &["roofline", "--only", "cycle,4,1"],
    ] {
        assert_eq!(run(&[words]).code, 2, "{words:?}");
    }
    let ended = run(&[&["roofline", "--quick", "--flops", "no/such/file"]]);
    assert_eq!(ended.code, 4, "{}", ended.err);
    assert!(
        ended.err.contains("no/such/file") && ended.err.contains("benches/flops.py") && ended.out.is_empty(),
        "{}",
        ended.err
    );
}

/// The rows that a command prints in small, after what the machine can do.
fn rows(words: &[&str]) -> Vec<Value> {
    let ended = run(&[words, &["--quick", "--json"]]);
    assert_eq!(ended.code, 0, "{}", ended.err);
    let lines: Vec<Value> = ended
        .out
        .lines()
        .map(|line| serde_json::from_str(line).unwrap())
        .collect();
    let machine = &lines[0]["machine"];
    assert!(
        ["triad", "triad_on_one", "flops", "flops_on_one"]
            .iter()
            .all(|name| positive(&machine[*name])),
        "{machine}"
    );
    assert!(
        machine["handover"].is_null() || positive(&machine["handover"]),
        "{machine}"
    );
    lines.iter().filter_map(|line| line.get("row")).cloned().collect()
}

fn positive(value: &Value) -> bool {
    value
        .as_f64()
        .is_some_and(|value| value > 0.0 && value.is_finite())
}

#[test]
fn the_speed_table_has_its_rows() {
    let folder = fresh_folder("bench_speed");
    fs::write(
        folder.join("performance.md"),
        "# By hand\n\n<!-- begin speed -->\nold\n<!-- end speed -->\n\nBelow.\n",
    )
    .unwrap();
    let rows = rows(&["--out", folder.to_str().unwrap(), "--threads", "1"]);
    let page = fs::read_to_string(folder.join("performance.md")).unwrap();
    assert!(
        page.starts_with("# By hand\n\n<!-- begin speed -->\n")
            && page.ends_with("<!-- end speed -->\n\nBelow.\n")
            && !page.contains("old"),
        "{page}"
    );
    assert_eq!(rows.len(), 9);
    for row in &rows {
        let name = row["name"].as_str().unwrap();
        let solve = name.contains("to 1 %");
        assert!(page.contains(&format!("| {name} | ")), "{name} is not in {page}");
        assert!(solve || positive(&row["seconds"]), "{row}");
        assert!(
            solve || positive(&row["least_bytes"]) && positive(&row["floor_seconds"]),
            "{row}"
        );
        assert!(
            row["target_seconds"].is_null(),
            "targets are not for tiny sizes: {row}"
        );
        assert!(
            positive(&row["triad"]) && positive(&row["flops"]),
            "what the machine did beside {row}"
        );
        assert!(row["handover"].is_null(), "one thread hands nothing over: {row}");
    }
    // Forward transport reads density and velocity and writes density: 5 values in 3D.
    let forward = rows
        .iter()
        .find(|row| row["name"] == "forward transport")
        .unwrap();
    let cells: u64 = forward["cells"]
        .as_array()
        .unwrap()
        .iter()
        .map(|side| side.as_u64().unwrap())
        .product();
    assert_eq!(
        forward["least_bytes"].as_f64().unwrap(),
        (4 * 5 * cells * number(forward, "steps")) as f64
    );
    assert!(
        page.contains("Triad") && page.contains("Peak resident memory"),
        "{page}"
    );
}

#[test]
fn the_scaling_table_has_its_rows_and_curves() {
    let folder = fresh_folder("bench_scaling");
    let rows = rows(&["scaling", "--out", folder.to_str().unwrap()]);
    assert_eq!(rows.len(), 4);
    for row in &rows {
        let pair = |name: &str| {
            row[name]
                .as_array()
                .unwrap()
                .iter()
                .filter(|value| positive(value))
                .count()
        };
        assert!(
            pair("direct_ns") == 2 && pair("cycle_ns") == 2 && positive(&row["evaluations"]),
            "{row}"
        );
    }
    let page = fs::read_to_string(folder.join("performance.md")).unwrap();
    for dims in [2, 3] {
        let figure = fs::read_to_string(folder.join(format!("scaling_{dims}d.svg"))).unwrap();
        assert!(
            (1..=4).all(|colour| figure.contains(&format!("class=\"c{colour}\"")))
                && page.contains(&format!("(scaling_{dims}d.svg)")),
            "{page}"
        );
    }
}

#[test]
fn the_roofline_takes_counted_operations() {
    let folder = fresh_folder("bench_roofline");
    let counts = folder.join("flops.json");
    fs::write(&counts, r#"{"forward": {"3": 100.0}}"#).unwrap();
    let rows = rows(&["roofline", "--flops", counts.to_str().unwrap()]);
    assert_eq!(rows.len(), 10, "five kernels in 2D and 3D");
    for row in &rows {
        let counted = row["kernel"] == "forward transport" && row["cells"].as_array().unwrap().len() == 3;
        assert_eq!(
            counted,
            positive(&row["flops"]) && positive(&row["of_arithmetic"]),
            "{row}"
        );
        assert!(
            positive(&row["seconds"]) && positive(&row["least_bytes"]) && positive(&row["of_memory"]),
            "{row}"
        );
        if counted {
            let cells: u64 = row["cells"]
                .as_array()
                .unwrap()
                .iter()
                .map(|side| side.as_u64().unwrap())
                .product();
            assert_eq!(
                row["flops"].as_f64().unwrap(),
                (100 * cells * (number(row, "steps") - 1)) as f64
            );
        }
    }
}

#[test]
fn the_circles_are_timed_in_both_precisions() {
    let rows = rows(&["circles"]);
    let precisions: Vec<&str> = rows
        .iter()
        .map(|row| row["precision"].as_str().unwrap())
        .collect();
    assert_eq!(precisions, ["f32", "f64", "f32", "f64"]);
    assert!(
        rows.iter()
            .all(|row| positive(&row["iteration_seconds"]) && positive(&row["evaluations"])),
        "{rows:?}"
    );
}

#[test]
fn a_page_that_cannot_be_written_is_refused_before_anything_is_measured() {
    let file = fresh_folder("bench_page").join("file");
    fs::write(&file, "mine").unwrap();
    for words in [&["memory"][..], &[], &["scaling"], &["roofline"], &["circles"]] {
        let ended = run(&[words, &["--quick", "--out", file.to_str().unwrap()]]);
        assert_eq!(ended.code, 4, "{words:?}: {}", ended.err);
        assert!(
            ended.err.contains("--out") && ended.out.is_empty(),
            "{words:?}: {}{}",
            ended.out,
            ended.err
        );
    }
    assert_eq!(fs::read_to_string(file).unwrap(), "mine");
}
