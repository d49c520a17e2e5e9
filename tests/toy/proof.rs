//! A method that is a folder and a line of the registry is planned, solved, saved, restored, reported, written and plotted.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a test says what went wrong by panicking"
)]

#[allow(dead_code, reason = "only the reader is needed")]
#[path = "../program/support/npz.rs"]
mod npz;

use core::mem::MaybeUninit;
use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use thurible_core::{
    Boundary, D2, D3, Method, Named, Params, Plan, Problem, Real, Serial, Silent, Solver, SolverError, Space,
    Status,
};

const CELLS: [usize; 3] = [9, 8, 6];
const WALLS: [Boundary; 3] = [Boundary::Wall, Boundary::Periodic, Boundary::Wall];
const STEPS: usize = 6;

fn toy() -> Params {
    Params {
        method: Method::from_name("toy").unwrap(),
        iterations: 4,
        ..Params::default()
    }
}

/// `bytes` bytes of a block, which begin as a plan asks for.
struct Block {
    bytes: Vec<MaybeUninit<u8>>,
    count: usize,
}

impl Block {
    fn new(count: usize) -> Self {
        let bytes = vec![MaybeUninit::uninit(); count + Plan::ALIGN];
        Self { bytes, count }
    }

    fn get(&mut self) -> &mut [MaybeUninit<u8>] {
        let start = self.bytes.as_ptr().align_offset(Plan::ALIGN);
        &mut self.bytes[start..start + self.count]
    }
}

fn blob<T: Real>(cells: &[usize], middle: f64) -> Vec<T> {
    let smoke = |index: usize| {
        let (x, y) = (index % cells[0], index / cells[0] % cells[1]);
        (2.5 - (x as f64 - middle).hypot(y as f64 - 3.5)).max(0.0)
    };
    (0..cells.iter().product())
        .map(|index| T::from_f64(smoke(index)))
        .collect()
}

/// All that the method gives, by name.
fn outputs<T: Real, S: Space>(solver: &Solver<'_, T, S>) -> Vec<(&'static str, Vec<T>)> {
    let all = |output: &thurible_core::Output| {
        let mut values = Vec::new();
        for step in 0..output.count(STEPS) {
            for axis in 0..output.components(S::DIM) {
                let mut part = vec![T::ZERO; solver.elements(output, axis)];
                solver.read(output, step, axis, &mut part);
                values.extend(part);
            }
        }
        (output.name, values)
    };
    solver.outputs().iter().map(all).collect()
}

fn is_planned_and_goes_on<T: Real, S: Space>() {
    let cells = &CELLS[..S::DIM];
    let problem = Problem::new(cells, &WALLS[..S::DIM], &[STEPS]);
    let plan = Plan::new::<T, S>(&problem, &toy()).unwrap();
    let (mut whole, mut half) = (Block::new(plan.bytes()), Block::new(plan.bytes()));
    let short = Block::new(plan.bytes() - 1).get().len();
    assert!(matches!(
        Solver::<T, S>::new(&problem, &toy(), Block::new(short).get()),
        Err(SolverError::TooSmall { .. })
    ));
    assert!(plan.entries().iter().any(|entry| entry.name == "blend"));

    let mut solver = Solver::<T, S>::new(&problem, &toy(), whole.get()).unwrap();
    solver.set_source(&blob(cells, 3.0)).unwrap();
    solver.set_keyframe(0, &blob(cells, 5.0)).unwrap();
    let mut saved = vec![0; plan.saved_bytes()];
    for step in 1..=2 {
        let progress = solver.step(&Serial, &mut Silent);
        assert_eq!((progress.iteration, progress.status), (step, None));
        assert!(progress.report.get("change").unwrap() > 0.0);
    }
    solver.save(&mut saved).unwrap();
    let status = solver.solve(&Serial, &mut Silent, &mut |_| {});
    assert_eq!(status, Status::MaxIterations);
    let found = outputs(&solver);
    assert_eq!(
        found.iter().map(|(name, _)| *name).collect::<Vec<_>>(),
        ["density", "velocity", "blend"]
    );

    let mut other = Solver::<T, S>::new(&problem, &toy(), half.get()).unwrap();
    other.restore(&saved).unwrap();
    assert_eq!(other.solve(&Serial, &mut Silent, &mut |_| {}), status);
    assert_eq!(other.objective(), solver.objective());
    assert!(outputs(&other) == found, "other bits");
    let [density, _, blend] = [0, 1, 2].map(|index| &found[index].1);
    assert!(density != blend, "nothing was blurred");
}

#[test]
fn the_toy_is_planned_to_the_byte_and_goes_on_from_what_was_saved() {
    is_planned_and_goes_on::<f32, D2>();
    is_planned_and_goes_on::<f64, D3>();
}

fn run(arguments: &[&str]) -> Output {
    let mut program = Command::new(env!("CARGO_BIN_EXE_thurible"));
    let ended = program
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .args(arguments)
        .output()
        .unwrap();
    assert!(
        ended.status.success(),
        "{}",
        String::from_utf8_lossy(&ended.stderr)
    );
    ended
}

fn folder() -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("toy");
    let _ = fs::remove_dir_all(&folder);
    folder
}

#[test]
fn the_program_solves_reports_writes_and_plots_it() {
    let scene = "examples/small_odd.toml";
    let planned = run(&["plan", scene, "--method", "toy", "--json"]);
    let planned: Value = serde_json::from_slice(&planned.stdout).unwrap();
    assert_eq!(planned["method"], "toy");

    let folder = folder();
    let ended = run(&[
        "solve",
        scene,
        "--method",
        "toy",
        "--json",
        "-o",
        folder.to_str().unwrap(),
    ]);
    let said = String::from_utf8(ended.stdout).unwrap();
    let lines = said
        .lines()
        .map(|line| serde_json::from_str::<Value>(line).unwrap());
    let iterations: Vec<Value> = lines.filter(|line| line["event"] == "iteration").collect();
    assert!(iterations.len() == 10 && iterations.iter().all(|line| line["change"].is_number()));

    let report: Value = serde_json::from_slice(&fs::read(folder.join("report.json")).unwrap()).unwrap();
    assert_eq!(
        (&report["method"], &report["status"]),
        (&"toy".into(), &"max_iterations".into())
    );
    assert_eq!(report["memory"]["planned_bytes"], planned["planned_bytes"]);
    assert_eq!(report["history"].as_array().unwrap().len(), iterations.len());
    assert!(report["history"][0]["change"].is_number());

    let arrays = npz::read(&folder.join("result.npz"));
    assert_eq!(
        arrays.keys().map(String::as_str).collect::<Vec<_>>(),
        [
            "blend",
            "density",
            "keyframe_density",
            "keyframe_step",
            "velocity_x",
            "velocity_y"
        ]
    );
    let (blend, density) = (&arrays["blend"], &arrays["density"]);
    assert_eq!(
        (&blend.shape, &density.shape),
        (&vec![11, 27, 33], &vec![11, 27, 33])
    );
    let cells = 27 * 33;
    assert_eq!(blend.data[..cells], density.data[..cells]);
    assert_ne!(blend.data, density.data);
    for cell in 0..cells {
        let [first, middle, last] = [0, 5, 10].map(|step| blend.data[step * cells + cell]);
        assert!((middle - 0.75 * first - 0.25 * last).abs() < 1e-6, "cell {cell}");
    }

    let page = fs::read_to_string(folder.join("report.html")).unwrap();
    let chart = page.split("<h3>Blur</h3>").nth(1).unwrap();
    let chart = chart.split("</figure>").next().unwrap();
    assert!(
        chart.contains("largest change of a density")
            && chart.contains("<svg")
            && chart.contains("<polyline")
    );
}
