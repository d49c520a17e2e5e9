//! The counts and arrays of a second program.

use super::bench::{Bench, apart, close};
use crate::npz::{self, Array};
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::Path;
use thurible_core::condense::{Basis, CondenseParams, Condenser, Material, Order, Step, Update};
use thurible_core::{Named, Serial};

fn folder() -> &'static Path {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/condense"))
}

fn counts() -> Value {
    serde_json::from_str(&std::fs::read_to_string(folder().join("iterations.json")).unwrap()).unwrap()
}

fn numbers(value: &Value) -> Vec<usize> {
    value
        .as_array()
        .unwrap()
        .iter()
        .map(|value| value.as_u64().unwrap() as usize)
        .collect()
}

/// The rod with stiffness `young`.
pub fn rod(young: f64) -> (Bench, Vec<f64>) {
    let mut bench = Bench::new(&[100], &[1.0], |place| place[0] == 0.0);
    bench.material = Material {
        young,
        area: 0.01,
        ..Material::default()
    };
    let impulse = 1.0 / (1000.0 * 0.01 * 0.01 / 2.0);
    let velocity = bench.field(|place, _, _| if place[0] == 1.0 { impulse } else { 0.0 });
    (bench, velocity)
}

pub fn rod_params(method: Update, order: Order) -> CondenseParams {
    CondenseParams {
        method,
        order,
        dt: Some(0.04),
        tolerance: 1e-6,
        cap: 10_000,
        search: false,
        ..CondenseParams::default()
    }
}

#[test]
fn the_rod_takes_the_counts_of_the_reference() {
    let counts = counts();
    let rows = [
        ("newton", Update::Newton, Order::Jacobi),
        ("condensation", Update::Cc, Order::Jacobi),
        ("plain_jacobi", Update::Plain, Order::Jacobi),
        ("plain_red_black", Update::Plain, Order::Colours),
        ("jgs2_local_red_black", Update::Jgs2Local, Order::Colours),
        ("jgs2_full_red_black", Update::Jgs2, Order::Colours),
    ];
    for (name, method, order) in rows {
        let expected = numbers(&counts["rod"]["iterations"][name]);
        for (young, expected) in [1e2, 1e3, 1e4, 1e5].into_iter().zip(expected) {
            // A basis takes 100 times the work of a pass without: what reaches the cap is left out.
            if expected > 5000 && method != Update::Plain {
                continue;
            }
            let (bench, velocity) = rod(young);
            let found = bench.run::<f64, 1, _>(rod_params(method, order), |condenser| {
                condenser.set_velocity(&velocity).unwrap();
                let step = Step::default();
                condenser
                    .step(&Serial, &step, &mut thurible_core::Silent, &mut |_| {})
                    .unwrap()
                    .iterations
            });
            assert!(
                close(found, expected),
                "{name} at {young}: {found}, not {expected}"
            );
        }
    }
}

#[test]
fn the_stretched_square_takes_the_counts_of_the_reference() {
    let counts = &counts()["stretch"]["results"];
    let rows = [
        ("newton", Update::Newton, 1e-8),
        ("condensation_fixed", Update::Cc, 1e-6),
        ("jgs2_full", Update::Jgs2, 1e-6),
        ("plain_jacobi", Update::Plain, 1e-6),
        ("chord", Update::Chord, 1e-6),
    ];
    for (name, method, tolerance) in rows {
        for m in [4, 8] {
            let bench = Bench::stretch(2, m);
            let pull = bench.pull(0.1);
            let step = Step {
                shift: &pull,
                ..Step::default()
            };
            let params = CondenseParams {
                method,
                ..CondenseParams::default()
            };
            let (found, _, energy) = bench.steps::<f64, 2>(params, &[step; 3]);
            let expected = &counts[name][m.to_string()];
            let same = numbers(&expected["iterations"])
                .iter()
                .zip(&found)
                .all(|(&expected, &found)| close(found, expected));
            assert!(
                same && found.len() == 3,
                "{name} of {m}: {found:?}, not {expected}"
            );
            let expected = expected["energy"].as_f64().unwrap();
            assert!(
                (energy - expected).abs() < tolerance * expected,
                "{name} of {m}: {energy}, not {expected}"
            );
        }
    }
}

/// The square of the point.
fn square(point: &BTreeMap<String, Array>) -> Bench {
    let mut bench = Bench::stretch(2, 4);
    bench.rest = point["rest"].data.clone();
    bench.elements = point["triangles"]
        .data
        .iter()
        .map(|&corner| corner as u32)
        .collect();
    bench.held = point["fixed"].data.iter().map(|&held| held != 0.0).collect();
    bench.material = Material {
        young: point["young"].data[0],
        poisson: point["poisson"].data[0],
        ..Material::default()
    };
    bench
}

type Run<'a, 'm> = &'a mut Condenser<'m, f64, 2>;

fn matrix(run: Run<'_, '_>, unknowns: &[[usize; 2]]) -> Vec<f64> {
    let row = |&[one, i]: &[usize; 2]| -> Vec<f64> {
        unknowns
            .iter()
            .map(|&[other, k]| run.hessian_block(one, other)[i][k])
            .collect()
    };
    unknowns.iter().flat_map(row).collect()
}

#[test]
fn a_state_has_the_numbers_of_the_reference() {
    let point = npz::read(&folder().join("point.npz"));
    let bench = square(&point);
    let unknowns = bench.unknowns();
    let position = &point["position"].data;
    let shift: Vec<f64> = position
        .iter()
        .zip(&bench.rest)
        .map(|(x, rest)| x - rest)
        .collect();
    let of = |list: &dyn Fn(usize) -> [f64; 3]| -> Vec<f64> {
        unknowns.iter().map(|&[vertex, k]| list(vertex)[k]).collect()
    };
    bench.run::<f64, 2, _>(CondenseParams::default(), |run| {
        run.make_hessian(&Serial, true);
        assert!(apart(&matrix(run, &unknowns), &point["hessian_rest"].data) < 1e-10);
        run.build_basis(&Serial);
        let basis: Vec<f64> = unknowns
            .iter()
            .flat_map(|&row| unknowns.iter().map(move |&column| (row, column)))
            .map(|(row, column)| run.basis_value(row, column))
            .collect();
        assert!(apart(&basis, &point["basis_rest"].data) < 1e-9);
        run.shift(&shift).unwrap();
        let [energy, _] = run.evaluate(&Serial);
        assert!(apart(&[energy], &point["energy"].data) < 1e-10);
        assert!(apart(&of(&|vertex| run.gradient(vertex)), &point["gradient"].data) < 1e-10);
        run.make_hessian(&Serial, true);
        assert!(apart(&matrix(run, &unknowns), &point["hessian"].data) < 1e-10);
        let rotations: Vec<f64> = (0..bench.vertices())
            .flat_map(|vertex| run.rotation(vertex).as_flattened().to_vec())
            .collect();
        assert!(apart(&rotations, &point["rotations"].data) < 1e-10);
    });
    let rows = [
        ("newton", Update::Newton, Basis::Fixed),
        ("plain", Update::Plain, Basis::Fixed),
        ("jgs2_full", Update::Jgs2, Basis::Fixed),
        ("jgs2_local", Update::Jgs2Local, Basis::Fixed),
        ("condensation", Update::Cc, Basis::Fixed),
        ("condensation_corotated", Update::Cc, Basis::Corotated),
    ];
    for (name, method, basis) in rows {
        let params = CondenseParams {
            method,
            basis,
            ..CondenseParams::default()
        };
        let found = bench.run::<f64, 2, _>(params, |run| {
            run.build_basis(&Serial);
            run.shift(&shift).unwrap();
            run.make_direction(&Serial);
            of(&|vertex| run.direction(vertex))
        });
        let apart = apart(&found, &point[&format!("direction_{name}")].data);
        assert!(apart < 1e-9, "{} {}: {apart:e}", method.name(), basis.name());
    }
}
