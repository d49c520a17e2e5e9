//! Every method, precision and dimension keeps what is promised, and a page less than the plan is refused.

use super::{BESIDE, DRAWING, MIB, ended, limited, own_peak, run, size_at_start, words};
use serde_json::Value;
use std::fs;
use std::path::Path;
use thurible::address_space::of_threads;

/// A solve of the table.
struct Row {
    cells: &'static [usize],
    steps: usize,
    method: &'static str,
    precision: &'static str,
    threads: usize,
    /// More for the scene, as `--set` takes it.
    set: &'static str,
}

const fn row(
    cells: &'static [usize],
    steps: usize,
    method: &'static str,
    precision: &'static str,
    threads: usize,
) -> Row {
    Row {
        cells,
        steps,
        method,
        precision,
        threads,
        set: "grid.boundary=wall",
    }
}

const TABLE: [Row; 20] = [
    row(&[96, 96], 24, "direct", "f32", 1),
    row(&[64, 48], 16, "direct", "f64", 2),
    row(&[64, 48], 24, "admm", "f32", 2),
    row(&[64, 48], 16, "admm", "f64", 1),
    row(&[48, 48], 16, "lbfgs", "f32", 1),
    row(&[40, 40], 12, "lbfgs", "f64", 2),
    row(&[128, 96], 16, "pd", "f32", 2),
    row(&[96, 96], 16, "pd", "f64", 1),
    row(&[20, 18, 16], 8, "direct", "f32", 2),
    row(&[16, 14, 12], 8, "direct", "f64", 1),
    row(&[20, 18, 16], 8, "admm", "f32", 1),
    row(&[16, 14, 12], 8, "admm", "f64", 2),
    row(&[16, 14, 12], 8, "lbfgs", "f32", 2),
    row(&[12, 14, 12], 6, "lbfgs", "f64", 1),
    row(&[24, 24, 24], 8, "pd", "f32", 1),
    row(&[20, 20, 20], 8, "pd", "f64", 2),
    Row {
        set: "grid.boundary=periodic",
        ..row(&[61, 77], 20, "direct", "f32", 2)
    },
    Row {
        set: "grid.boundary=periodic",
        ..row(&[61, 77], 20, "admm", "f64", 1)
    },
    Row {
        set: "method.direct.history=1",
        ..row(&[19, 17, 23], 8, "direct", "f64", 2)
    },
    Row {
        set: "method.admm.nso=newton_cg",
        ..row(&[16, 16, 16], 8, "admm", "f32", 2)
    },
];

impl Row {
    /// A ball, or a disc, that moves.
    fn scene(&self) -> String {
        let (shape, rest) = if self.cells.len() == 2 {
            ("circle", "0.5]")
        } else {
            ("sphere", "0.5, 0.5]")
        };
        let Self { cells, steps, .. } = self;
        format!(
            "[grid]\ncells = {cells:?}\n[time]\nsteps = {steps}\n[source]\n{shape} = {{ center = [0.4, {rest}, radius = 0.2 }}\n\
             [[keyframe]]\nstep = {steps}\n{shape} = {{ center = [0.6, {rest}, radius = 0.2 }}\n[method]\niterations = 1\n[output]\nframes = false\n"
        )
    }

    fn arguments<'a>(&'a self, command: &'a str, threads: &'a str) -> Vec<&'a str> {
        vec![
            command,
            "scene.toml",
            "--method",
            self.method,
            "--precision",
            self.precision,
            "--threads",
            threads,
            "--set",
            self.set,
        ]
    }
}

#[test]
fn every_method_keeps_what_is_promised() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("ceiling_table");
    let _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder).unwrap();
    let start = size_at_start(&folder);
    for row in &TABLE {
        let Row {
            cells,
            method,
            precision,
            threads,
            set,
            ..
        } = row;
        let name = format!("{cells:?} by {method} in {precision} on {threads} threads, {set}");
        fs::write(folder.join("scene.toml"), row.scene()).unwrap();
        let words_of_threads = threads.to_string();
        let plan = run(
            &folder,
            1 << 40,
            &[row.arguments("plan", &words_of_threads), vec!["--json"]].concat(),
        );
        let plan: Value = serde_json::from_slice(&plan.stdout).unwrap();
        let (planned, block) = (
            plan["planned_bytes"].as_u64().unwrap(),
            plan["block_bytes"].as_u64().unwrap(),
        );
        assert!(
            planned > 2 * MIB && planned <= block,
            "{name}: {planned} bytes do not show"
        );
        let limit = block.to_string();
        let solve = [
            row.arguments("solve", &words_of_threads),
            vec!["--quiet", "--force", "-o", "out", "--memory-limit", &limit],
        ]
        .concat();
        let promised = block + BESIDE + DRAWING * u64::try_from(cells.iter().product::<usize>()).unwrap();
        let addresses = promised + u64::try_from(of_threads(*threads)).unwrap();
        let (code, peak) = ended(limited(&folder, addresses, &solve));
        assert!(
            matches!(code, Some(0 | 5)),
            "{name}: with {addresses} bytes of addresses: {code:?}"
        );
        // The memory of this program at the fork counts as well.
        let most = promised.max(own_peak());
        assert!(
            (planned..=most).contains(&peak),
            "{name}: {peak} bytes were resident, of {planned} planned"
        );
        let short = run(&folder, start + planned - 4096, &solve);
        assert_eq!(
            short.status.code(),
            Some(3),
            "{name}: a page less than the plan: {short:?}"
        );
        assert!(
            words(&short).trim().lines().count() == 1 && words(&short).contains("bytes"),
            "{name}: {}",
            words(&short)
        );
    }
}
