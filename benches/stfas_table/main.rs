//! The table of STFAS: by which factor a V(2,2) cycle reduces the residual of NSO, asymptotically, in double precision.
//!
//! `cargo bench --bench stfas_table`, all in about four minutes; `-- --quick` the small rows alone; `-- --floor` instead the
//! residuals that single and double precision come down to, beside the tolerance of the paper; `-- --decades` instead the
//! seconds that a decade takes with two smoothers. Ends with 1 when a row that has
//! a bound misses it.

#[path = "../common/mod.rs"]
mod common;
mod decades;
mod floors;
mod residuals;

use common::rate::{asymptotic, listed};
use common::{pool, size, sure};
use decades::decades;
use floors::floors;
use residuals::{FLOOR, cycles};
use std::process::ExitCode;
use std::time::Instant;
use thurible_bench::navier_stokes::{Case, Obstacle};
use thurible_bench::scenes::letter_f;
use thurible_core::nso::damping::LocalDamping;
use thurible_core::{Colours, D2, D3, Exec, Silent, Space};

/// Prints rows and counts those that miss their bound.
struct Table {
    missed: usize,
    quick: bool,
}

impl Table {
    fn title(&self, text: &str) {
        println!(
            "\n{text}\n{:<45}{:>8}{:>8}  ratio of each cycle",
            "", "ratio", "bound"
        );
    }

    fn row(&mut self, name: &str, residuals: &[f64], bound: Option<f64>) {
        let ratio = asymptotic(residuals, FLOOR);
        let missed = bound.is_some_and(|bound| ratio.is_nan() || ratio > bound);
        self.missed += usize::from(missed);
        let bound = bound.map_or_else(|| "-".into(), |bound| format!("{bound:.2}"));
        println!(
            "{name:<45}{ratio:>8.3}{bound:>8}  {}{}",
            listed(residuals),
            if missed { "  MISSED" } else { "" }
        );
    }

    fn case<S: Space>(&mut self, exec: &dyn Exec, name: &str, case: &Case, bound: Option<f64>) {
        self.row(name, &cycles::<S>(exec, case), bound);
    }
}

fn main() -> ExitCode {
    if std::env::args().any(|argument| argument == "--floor") {
        floors(pool());
        return ExitCode::SUCCESS;
    }
    if std::env::args().any(|argument| argument == "--decades") {
        decades();
        return ExitCode::SUCCESS;
    }
    let mut table = Table {
        missed: 0,
        quick: std::env::args().any(|argument| argument == "--quick"),
    };
    let began = Instant::now();
    let exec = pool();
    synthetic_2d(exec, &mut table);
    synthetic_3d(exec, &mut table);
    at_rest(exec, &mut table);
    other_boxes(exec, &mut table);
    fast_flows(exec, &mut table);
    solids(exec, &mut table);
    local_damping_cases(exec, &mut table);
    if !table.quick {
        real_runs(exec, &mut table);
    }
    println!(
        "\n{:.0} s, {} rows missed their bound",
        began.elapsed().as_secs_f64(),
        table.missed
    );
    if table.missed == 0 {
        ExitCode::SUCCESS
    } else {
        ExitCode::FAILURE
    }
}

fn synthetic_2d(exec: &dyn Exec, table: &mut Table) {
    table.title("2D, kappa = 1, synthetic targets");
    let (sides, steps): (&[usize], &[usize]) = if table.quick {
        (&[32], &[20, 40])
    } else {
        (&[32, 64, 128], &[20, 40, 80])
    };
    for courant in [0.5, 1.0] {
        for &n in sides {
            for &steps in steps {
                let name = format!("{n}x{n}, N = {steps}, Courant {courant}");
                table.case::<D2>(exec, &name, &Case::new(&[n, n], steps, courant), Some(0.25));
            }
        }
    }
}

fn synthetic_3d(exec: &dyn Exec, table: &mut Table) {
    table.title("3D, kappa = 1, synthetic targets");
    let cases: &[(usize, usize)] = if table.quick {
        &[(16, 16)]
    } else {
        &[(16, 16), (32, 20), (64, 20)]
    };
    for &(n, steps) in cases {
        let courants: &[f64] = if n == 64 { &[1.0] } else { &[0.5, 1.0] };
        for courant in courants {
            let name = format!("{n}x{n}x{n}, N = {steps}, Courant {courant}");
            table.case::<D3>(exec, &name, &Case::new(&[n; 3], steps, *courant), Some(0.2));
        }
    }
}

/// A disc, and plates of one cell with two free ends or one: between cells of all coarser grids, and where the second would go through.
fn solids(exec: &dyn Exec, table: &mut Table) {
    table.title("Among solids, kappa = 1, Courant 1");
    let flat: &[(usize, usize)] = if table.quick {
        &[(32, 20)]
    } else {
        &[(32, 20), (32, 80), (64, 20), (128, 40)]
    };
    for &(n, steps) in flat {
        for (name, obstacle) in obstacles(n) {
            let name = format!("{n}x{n}, N = {steps}, {name}");
            let obstacle = Some(obstacle);
            let case = Case {
                obstacle,
                ..Case::new(&[n, n], steps, 1.0)
            };
            table.case::<D2>(exec, &name, &case, Some(0.3));
        }
    }
    let deep: &[usize] = if table.quick { &[16] } else { &[16, 32] };
    for &n in deep {
        for (name, obstacle) in obstacles(n) {
            let name = format!("{n}x{n}x{n}, N = 16, {name}");
            let obstacle = Some(obstacle);
            let case = Case {
                obstacle,
                ..Case::new(&[n; 3], 16, 1.0)
            };
            table.case::<D3>(exec, &name, &case, Some(0.3));
        }
    }
}

/// What stands in a box of `n` cells a side.
fn obstacles(n: usize) -> [(&'static str, Obstacle); 5] {
    let across = [0.25, 0.75];
    let from_a_wall = [0.0, 0.75];
    [
        ("ball", Obstacle::Ball(0.2 * n as f64)),
        ("plate", Obstacle::Plate(n / 2 - 1, across)),
        ("plate, lost", Obstacle::Plate(n / 2 - 2, across)),
        ("plate at a wall", Obstacle::Plate(n / 2 - 1, from_a_wall)),
        ("plate at a wall, lost", Obstacle::Plate(n / 2 - 2, from_a_wall)),
    ]
}

fn at_rest(exec: &dyn Exec, table: &mut Table) {
    table.title("At v = 0 (Courant 1e-4), 32x32: kappa = K/r dt^2 in box lengths");
    for (steps, penalty, weight, dt) in [
        (20, 1e3, 1e3, 1.0),
        (80, 1e3, 1e3, 1.0),
        (20, 1e3, 1e5, 1.0),
        (20, 1e3, 10.0, 1.0),
        (20, 1e1, 1e3, 1.0),
        (20, 1e5, 1e3, 1.0),
        (20, 1e3, 1e3, 1.0 / 24.0),
    ] {
        let kappa = penalty / weight * dt * dt;
        let name = format!("N = {steps}, K = {penalty:e}, r = {weight:e}, dt = {dt:.3}");
        table.case::<D2>(
            exec,
            &name,
            &Case {
                kappa,
                ..Case::new(&[32, 32], steps, 1e-4)
            },
            None,
        );
    }
}

fn other_boxes(exec: &dyn Exec, table: &mut Table) {
    table.title("Boxes that are no powers of two, N = 20, Courant 1");
    for cells in [[96, 60], [50, 50], [33, 47], [64, 8]] {
        table.case::<D2>(exec, &size(&cells), &Case::new(&cells, 20, 1.0), Some(0.4));
    }
}

fn fast_flows(exec: &dyn Exec, table: &mut Table) {
    table.title("Beyond Courant 1, 32x32, N = 20: both orders of the smoother");
    for courant in [2.0, 2.2, 3.0] {
        for colours in [Colours::RedBlack, Colours::PowerOfTwo] {
            let name = format!("Courant {courant}, {colours:?}");
            table.case::<D2>(
                exec,
                &name,
                &Case {
                    colours,
                    ..Case::new(&[32, 32], 20, courant)
                },
                (courant <= 2.2).then_some(0.45),
            );
        }
    }
}

/// With and without local damping: the same to a tenth, where a cycle leaves more than a fortieth at all.
fn local_damping_cases(exec: &dyn Exec, table: &mut Table) {
    table.title("Cells damped where the flow is slow / nowhere, by kappa = K / r");
    for (kappa, courant) in [
        (0.01, 0.2),
        (0.1, 0.6),
        (1.0, 0.6),
        (1.0, 1.0),
        (4.0, 2.0),
        (20.0, 2.0),
    ] {
        local_damping::<D2>(
            exec,
            table,
            &Case {
                kappa,
                ..Case::new(&[64, 64], 40, courant)
            },
        );
        if !table.quick {
            local_damping::<D3>(
                exec,
                table,
                &Case {
                    kappa,
                    ..Case::new(&[24, 24, 24], 20, courant)
                },
            );
        }
    }
}

fn local_damping<S: Space>(exec: &dyn Exec, table: &mut Table, case: &Case) {
    let name = format!(
        "{}, N = {}, kappa {}, C {}",
        size(&case.cells),
        case.steps,
        case.kappa,
        case.courant
    );
    let everywhere = cycles::<S>(
        exec,
        &Case {
            damping: LocalDamping::NONE,
            ..case.clone()
        },
    );
    table.row(&format!("{name}, nowhere"), &everywhere, None);
    let bound = (1.1 * asymptotic(&everywhere, FLOOR)).max(0.025);
    table.case::<S>(exec, &name, case, Some(bound));
}

/// NSO within real solves by ADMM: scenes of the examples, solved in f64 with an NSO tolerance far below the usual one.
fn real_runs(exec: &dyn Exec, table: &mut Table) {
    table.title("Real runs: NSO in the first iterations of ADMM, K/r = 1");
    for n in [32, 64, 128] {
        for steps in [20, 40, 80] {
            // As far as the smoke gets at a Courant number below 1.
            let shift = (0.4 * steps as f64 / n as f64).min(0.15);
            let circle = |x: f64| format!("{{circle={{center=[{x}, 0.5], radius=0.14}}}}");
            let shapes = [circle(0.5 - shift), circle(0.5 + shift)].join(", ");
            let keyframe = format!("keyframe=[{{step={steps}, shapes=[{shapes}]}}]");
            real_run(
                exec,
                table,
                "two circles",
                &[
                    format!("grid.cells=[{n}, {n}]"),
                    format!("time.steps={steps}"),
                    keyframe,
                ],
                2,
                None,
            );
        }
    }
    real_run(exec, table, "letter_f", &[], 3, Some(0.45));
}

fn real_run(
    exec: &dyn Exec,
    table: &mut Table,
    name: &str,
    assignments: &[String],
    iterations: usize,
    first_bound: Option<f64>,
) {
    let mut ready = sure(letter_f(assignments, "admm", exec.threads()));
    ready.params.admm.nso.tolerance = 1e-13;
    ready.params.admm.nso.cycles = 20;
    let (cells, steps) = (size(ready.problem().cells), ready.problem().steps);
    sure(ready.with::<f64, D2, _>(exec, |solver| {
        for iteration in 1..=iterations {
            let progress = solver.step(exec, &mut Silent);
            let courant = ready.courant(solver);
            let label = format!("{name} {cells}, N = {steps}, it. {iteration}, C {courant:.1}");
            let bound = if iteration == 1 { first_bound } else { None }.or((courant <= 1.0).then_some(0.25));
            table.row(&label, progress.report.series("nso_residuals"), bound);
        }
    }));
}
