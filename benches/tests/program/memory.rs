//! The memory table against sums and formulas of its own.

use super::{fresh_folder, number, run};
use serde_json::Value;
use std::fs;
use thurible::bytes::grouped;
use thurible::phases::phases;
use thurible::problem::{OwnedProblem, Precision};
use thurible_core::{Method, Params};

/// Bytes of 4 (1 + d) N prod(n) / (1 - 2^-d) values.
fn bound(cells: u64, dims: u32, steps: u64, bytes: u64) -> u64 {
    4 * (1 + u64::from(dims)) * steps * cells * bytes * 2_u64.pow(dims) / (2_u64.pow(dims) - 1)
}

#[test]
fn the_memory_table_adds_up() {
    let folder = fresh_folder("bench_memory").join("docs");
    let ended = run(&[&["memory", "--quick", "--json", "--out", folder.to_str().unwrap()]]);
    assert_eq!(ended.code, 0, "{}", ended.err);
    let rows: Vec<Value> = ended
        .out
        .lines()
        .map(|line| serde_json::from_str(line).unwrap())
        .collect();
    assert_eq!(rows.len(), 16, "two sizes, four methods, two precisions");
    let page = fs::read_to_string(folder.join("memory.md")).unwrap();
    for row in &rows {
        let sides: Vec<u64> = row["cells"]
            .as_array()
            .unwrap()
            .iter()
            .map(|side| side.as_u64().unwrap())
            .collect();
        let (dims, steps, cells) = (
            u32::try_from(sides.len()).unwrap(),
            number(row, "steps"),
            sides.iter().product::<u64>(),
        );
        let bytes = if row["precision"] == "f64" { 8 } else { 4 };
        let planned = number(row, "planned_bytes");
        assert_eq!(
            number(row, "paper_bound_bytes"),
            bound(cells, dims, steps, bytes),
            "{row}"
        );
        // The keyframe and its step, each on whole cache lines.
        assert_eq!(planned - number(row, "method_bytes"), cells * bytes + 64, "{row}");
        assert!(
            (row["bytes_per_cell_and_step"].as_f64().unwrap() * (cells * steps) as f64 - planned as f64)
                .abs()
                < 1.0,
            "{row}"
        );
        let phases: Vec<u64> = row["phases"]
            .as_array()
            .unwrap()
            .iter()
            .map(|phase| number(phase, "bytes"))
            .collect();
        assert!(
            phases.len() > 1 && phases.iter().max() == Some(&planned) && phases.iter().min() < Some(&planned),
            "{row}"
        );
        if cfg!(target_os = "linux") {
            let touched = number(row, "touched_bytes");
            assert!(
                (planned..planned + (5 << 20)).contains(&touched),
                "{touched} touched of {row}"
            );
        }
        let shown = format!(
            "| {} | {} |",
            row["method"].as_str().unwrap(),
            row["precision"].as_str().unwrap()
        );
        assert!(
            page.lines()
                .any(|line| line.contains(&shown)
                    && line.contains(&grouped(usize::try_from(planned).unwrap()))),
            "{row}"
        );
    }
    for dims in [2, 3] {
        let figure = fs::read_to_string(folder.join(format!("memory_{dims}d.svg"))).unwrap();
        assert!(figure.starts_with("<svg") && figure.trim_end().ends_with("</svg>"));
        assert!(
            (1..=5).all(|colour| figure.contains(&format!("class=\"c{colour}\""))),
            "a curve is missing"
        );
        assert!(page.contains(&format!("(memory_{dims}d.svg)")));
    }
}

/// The rows are those that a plan knows.
#[test]
fn the_memory_table_is_that_of_plan() {
    let problem = OwnedProblem::new(vec![64, 64], vec![20]);
    let params = Params {
        method: Method::Admm,
        ..Params::default()
    };
    let plan = problem.plan(&params, Precision::F64).unwrap();
    let ended = run(&[&["memory", "--quick"]]);
    let planned = grouped(plan.bytes());
    assert!(
        ended
            .out
            .lines()
            .any(|line| line.contains("64 x 64") && line.contains("admm") && line.contains(&planned)),
        "{planned}: {}",
        ended.out
    );
    for phase in phases(plan.entries(), plan.bytes()) {
        assert!(ended.out.contains(&phase.name), "{phase:?}: {}", ended.out);
    }
}
