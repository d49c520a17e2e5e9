//! What single and double precision come down to.

use crate::common::{size, sure};
use crate::residuals::residuals_of;
use thurible_bench::navier_stokes::Case;
use thurible_bench::prepared::PreparedScene;
use thurible_bench::scenes::{letter_f, moving_sphere};
use thurible_core::{D2, D3, Exec, Norm, Real, Silent, Space};

/// Tolerance at which the paper stops its V-cycles.
const PAPERS: f64 = 1e-5;

/// The least residuals in both precisions, with divergences as accelerations and as they are (the paper's norm).
pub fn floors(exec: &dyn Exec) {
    println!(
        "{:<50}{:>12}{:>12}{:>12}{:>12}{:>12}",
        "max |f|", "at first", "least, f32", "least, f64", "cycles f32", "cycles f64"
    );
    for (cells, steps) in [([64, 64], 20), ([128, 128], 40), ([256, 256], 40)] {
        floor::<D2>(exec, &cells, steps);
    }
    for (n, steps) in [(16, 16), (32, 20), (64, 20)] {
        floor::<D3>(exec, &[n; 3], steps);
    }
    for norm in ["scaled", "plain"] {
        let sets = [format!("method.admm.nso_norm={norm}")];
        solved::<D2>(
            exec,
            &format!("letter_f, it. 1 to 3, {norm}"),
            &sure(letter_f(&sets, "admm", exec.threads())),
        );
        let cells = ["grid.cells=[32,32,32]".into(), "method.admm.nested=false".into()];
        solved::<D3>(
            exec,
            &format!("moving_sphere 32x32x32, it. 1 to 3, {norm}"),
            &sure(moving_sphere(
                &[&sets[..], &cells].concat(),
                "admm",
                exec.threads(),
            )),
        );
    }
}

fn floor<S: Space>(exec: &dyn Exec, cells: &[usize], steps: usize) {
    for norm in [Norm::Scaled, Norm::Plain] {
        let case = Case {
            norm,
            ..Case::new(cells, steps, 1.0)
        };
        let [single, double] = [
            residuals_of::<f32, S>(exec, &case),
            residuals_of::<f64, S>(exec, &case),
        ];
        print_floor(
            &format!("{}, N = {steps}, Courant 1, {norm:?}", size(cells)),
            &single,
            &double,
        );
    }
}

fn print_floor(name: &str, single: &[f64], double: &[f64]) {
    let least = |residuals: &[f64]| residuals.iter().copied().fold(f64::INFINITY, f64::min);
    let cycles = |residuals: &[f64]| {
        residuals
            .iter()
            .position(|&r| r < PAPERS)
            .map_or_else(|| "never".into(), |count| count.to_string())
    };
    let (first, of_single, of_double) = (double[0], least(single), least(double));
    println!(
        "{name:<50}{first:>12.1e}{of_single:>12.1e}{of_double:>12.1e}{:>12}{:>12}",
        cycles(single),
        cycles(double)
    );
}

/// The first iterations of ADMM, each of which may take all cycles.
fn solved<S: Space>(exec: &dyn Exec, name: &str, ready: &PreparedScene) {
    fn iterations<T: Real, S: Space>(exec: &dyn Exec, ready: &PreparedScene) -> Vec<Vec<f64>> {
        sure(ready.with::<T, S, _>(exec, |solver| {
            (0..3)
                .map(|_| {
                    solver
                        .step(exec, &mut Silent)
                        .report
                        .series("nso_residuals")
                        .to_vec()
                })
                .collect()
        }))
    }
    let [single, double] = [
        iterations::<f32, S>(exec, ready),
        iterations::<f64, S>(exec, ready),
    ];
    for (single, double) in single.iter().zip(&double) {
        print_floor(name, single, double);
    }
}
