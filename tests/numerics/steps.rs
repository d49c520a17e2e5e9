//! One implicit step of the flow and its adjoint.

use crate::fields;
use crate::fields::naive::Naive;
use crate::fields::random::Random;
use crate::fields::{
    Components, Memory, add_scaled_all, assert_close, dot_all, flow, grid, largest, largest_of,
};
use thurible_core::grid::Grid;
use thurible_core::grid::levels::Levels;
use thurible_core::memory::{Arena, Ledger, Pool};
use thurible_core::method::simulate::step::{Setup, Step};
use thurible_core::transport::Stop;
use thurible_core::{D2, D3, Real, Serial, Silent, Space};

/// Calls `work` with the workspace of a step.
fn with_step<T: Real, R>(
    grid: &Grid,
    viscosity: f64,
    tolerance: f64,
    work: impl FnOnce(&mut Step<'_, T>, &mut [f64]) -> R,
) -> R {
    let mut memory = Memory::new(1 << 20);
    let levels = Levels::carve(&mut Arena::new(memory.block()), grid, 0).unwrap();
    let setup = Setup {
        viscosity,
        tolerance,
        threads: 1,
        directions: 20,
        adjoint: true,
    };
    let mut ledger = Ledger::new();
    Step::<T>::carve(&levels, 0, setup, &mut Pool::measuring(&mut ledger));
    let mut elements = vec![T::from_f64(f64::NAN); ledger.elements(T::BYTES)];
    let mut step = Step::carve(&levels, 0, setup, &mut Pool::new(&mut elements));
    work(&mut step, &mut vec![0.0; 2 * grid.rows()])
}

fn write<T: Real>(out: &mut [&mut [T]; 3], values: &Components<T>) {
    out.iter_mut()
        .zip(values)
        .for_each(|(out, values)| out.copy_from_slice(values));
}

/// The flow one step after `v` pushed by `u`, from the guess v.
fn advance<T: Real, S: Space>(
    grid: &Grid,
    viscosity: f64,
    tolerance: f64,
    v: &Components<T>,
    u: &Components<T>,
) -> Result<Components<T>, Stop> {
    with_step(grid, viscosity, tolerance, |step: &mut Step<'_, T>, sums| {
        write(&mut step.given, &add_scaled_all(v, 1.0, u));
        write(&mut step.v, v);
        step.advance::<S>(&Serial, &mut Silent, sums)?;
        Ok(step.v.each_ref().map(|component| component.to_vec()))
    })
}

/// The largest error of `x`, which should be a gradient: its curl times h, its mean along periodic axes.
pub fn not_a_gradient(naive: &Naive, x: &Components<f64>) -> f64 {
    let grid = &naive.grid;
    let mean = |a: usize| x[a].iter().sum::<f64>() / grid.cells() as f64;
    let means = (0..grid.dims).filter(|&a| grid.axis(a).is_ring()).map(mean);
    largest(means.chain([naive.largest_curl(x) * grid.h[0]]))
}

fn step_is_solved<T: Real, S: Space>(
    cells: &[usize],
    ends: &str,
    courant: f64,
    viscosity: f64,
    tolerance: f64,
) {
    let (mut random, grid) = (Random::new(71), grid(cells, ends));
    let viscosity = viscosity * grid.h[0] * grid.h[0];
    let naive = Naive {
        viscosity,
        ..Naive::new(&grid)
    };
    let v: Components<T> = flow::swirl(&grid, 1, courant);
    let speed = largest_of(&v);
    // Forces that are not free of divergence, a tenth of the flow.
    let u: Components<T> = random
        .faces(&grid, 1)
        .map(|c: Vec<T>| c.iter().map(|x| T::from_f64(0.1 * speed * x.to_f64())).collect());
    let after = fields::cast_all(
        &advance::<T, S>(&grid, viscosity, tolerance, &v, &u)
            .unwrap_or_else(|stop| panic!("{cells:?} {ends} at Courant {courant}: {stop:?}")),
    );
    let given = fields::cast_all(&add_scaled_all(&v, 1.0, &u));
    let left = add_scaled_all(
        &add_scaled_all(&after, -1.0, &given),
        1.0,
        &naive.advection(&after),
    );
    let fastest = largest_of(&after).max(largest_of(&given));
    let allowed = 8.0
        * (tolerance + 16.0 * T::EPSILON * (1.0 + fastest / grid.h[0] + viscosity / (grid.h[0] * grid.h[0])))
        * fastest;
    let what = format!("{cells:?} {ends} at Courant {courant} in {}", T::NAME);
    assert_close(
        &format!("momentum on {what}"),
        not_a_gradient(&naive, &left),
        0.0,
        allowed,
        1.0,
    );
    assert_close(
        &format!("div v on {what}"),
        largest(naive.divergence(&after)) * grid.h[0],
        0.0,
        allowed,
        1.0,
    );
    assert!(
        largest_of(&add_scaled_all(&after, -1.0, &fields::cast_all(&v))) > 0.01 * speed,
        "nothing happened on {what}"
    );
}

#[test]
fn steps_are_solved_up_to_courant_five() {
    for (courant, viscosity) in [(0.5, 0.0), (2.0, 0.0), (2.0, 3.0), (5.0, 0.0), (5.0, 0.1)] {
        step_is_solved::<f64, D2>(&[24, 20], "ww", courant, viscosity, 1e-5);
        step_is_solved::<f64, D2>(&[33, 17], "pw", courant, viscosity, 1e-10);
        step_is_solved::<f32, D2>(&[32, 32], "pp", courant, viscosity, 1e-5);
        step_is_solved::<f32, D3>(&[12, 10, 14], "www", courant, viscosity, 1e-5);
        step_is_solved::<f64, D3>(&[9, 12, 8], "wpp", courant, viscosity, 1e-8);
    }
}

#[test]
fn a_step_that_cannot_be_solved_is_too_fast() {
    let grid = grid(&[16, 16], "ww");
    for speed in [f64::NAN, f64::INFINITY, 1e200, 1e13] {
        let v = fields::zeros::<f64>(&grid, 1);
        let mut u = v.clone();
        u[0][37] = speed;
        assert_eq!(
            advance::<f64, D2>(&grid, 0.0, 1e-5, &v, &u).map(|_| ()),
            Err(Stop::TooFast),
            "{speed}"
        );
    }
}

/// <z, (I + Q J) d> = <b, d> for every d free of divergence.
fn adjoint_is_solved<S: Space>(cells: &[usize], ends: &str, courant: f64, viscosity: f64) {
    let (mut random, grid) = (Random::new(72), grid(cells, ends));
    let viscosity = viscosity * grid.h[0] * grid.h[0];
    let naive = Naive {
        viscosity,
        ..Naive::new(&grid)
    };
    let (v, b): (Components<f64>, Components<f64>) = (
        flow::rough(&mut random, &grid, 1, courant),
        random.faces(&grid, 1),
    );
    let z = with_step(&grid, viscosity, 1e-12, |step: &mut Step<'_, f64>, sums| {
        write(&mut step.given, &b);
        write(&mut step.v, &v);
        write(&mut step.adjoint, &flow::rough(&mut random, &grid, 1, 1.0));
        step.adjoin::<S>(&Serial, &mut Silent, sums).unwrap();
        step.adjoint.each_ref().map(|component| component.to_vec())
    });
    for _ in 0..3 {
        let d: Components<f64> = flow::rough(&mut random, &grid, 1, 1.0);
        // J d exactly, since Adv is quadratic.
        let around = |s: f64| naive.advection(&add_scaled_all(&v, s, &d));
        let jd = add_scaled_all(&around(0.5), -1.0, &around(-0.5));
        let (left, right) = (dot_all(&z, &add_scaled_all(&d, 1.0, &jd)), dot_all(&b, &d));
        assert_close(
            "<z, (I + J) d>",
            left,
            right,
            (dot_all(&b, &b) * dot_all(&d, &d)).sqrt(),
            1e-9,
        );
    }
    assert!(largest(naive.divergence(&z)) < 1e-9 * largest_of(&z) / grid.h[0]);
}

#[test]
fn adjoints_are_solved_up_to_courant_five() {
    for (courant, viscosity) in [(0.5, 0.0), (5.0, 0.0), (5.0, 1.0)] {
        adjoint_is_solved::<D2>(&[14, 10], "ww", courant, viscosity);
        adjoint_is_solved::<D2>(&[9, 12], "pw", courant, viscosity);
        adjoint_is_solved::<D3>(&[6, 5, 7], "wpw", courant, viscosity);
    }
}
