//! Gradients of a transport step in the velocity, against differences.

use crate::fields::carry::Carry;
use crate::fields::random::Random;
use crate::fields::{Components, add_scaled_all, assert_close, dot, dot_all, flow, grid, zeros};
use thurible_core::Scheme;
use thurible_core::grid::Grid;

/// Checks `value(t) - value(0) - t slope` at three steps: each a quarter of the one before.
#[track_caller]
pub fn taylor(what: &str, first: f64, slope: f64, value: impl Fn(f64) -> f64) {
    let at_rest = value(0.0);
    let steps = [first, 0.5 * first, 0.25 * first];
    let left = steps.map(|t| value(t) - at_rest - t * slope);
    assert!(
        left[0].abs() > 1e3 * f64::EPSILON * at_rest.abs(),
        "{what}: the remainder {left:?} drowns in rounding"
    );
    assert!(
        left[0].abs() < 0.1 * (first * slope).abs(),
        "{what}: slope {slope:e}, remainders {left:?}"
    );
    for pair in left.windows(2) {
        let ratio = pair[0] / pair[1];
        assert!(
            (ratio - 4.0).abs() < 0.2,
            "{what}: slope {slope:e}, remainders {left:?}, ratio {ratio:.3}"
        );
    }
}

/// Cells and ends of the boxes in which a step is looked at.
const BOXES: [(&[usize], &str); 5] = [
    (&[10, 8], "ww"),
    (&[7, 9], "pw"),
    (&[6, 6], "pp"),
    (&[5, 4, 6], "www"),
    (&[4, 6, 5], "pwp"),
];

/// A random direction, in which a cell is gone through in a time of 1.
fn direction(random: &mut Random, grid: &Grid) -> Components<f64> {
    let d = random.faces(grid, 1);
    d.map(|c| c.iter().map(|x: &f64| x * grid.h[0]).collect())
}

/// A random flow of the Courant number `courant`, no face of which is near rest.
pub fn moving(random: &mut Random, grid: &Grid, courant: f64) -> Components<f64> {
    let v = random.moving_faces(grid, 1);
    let now = flow::courant(grid, 1, &v);
    v.map(|c| c.iter().map(|x: &f64| x * courant / now).collect())
}

/// Checks a function of which the derivative at 0 is known.
type Check<'a> = dyn Fn(&str, f64, &dyn Fn(f64) -> f64) + 'a;

/// <mu, A[rho, v]> along a random direction, for several Courant numbers: 1, 4 and 11 sub-steps (more than are kept), and fewer, longer ones.
/// `check` is told what it is about, the derivative by the adjoint, and the function.
fn step_gradients(scheme: Scheme, check: &Check<'_>) {
    let mut random = Random::new(21);
    for (cells, ends) in BOXES {
        let grid = grid(cells, ends);
        // At 10.5 limited sub-steps of Courant number 1/2 are just full: one more is there beside.
        let fastest = if scheme == Scheme::Limited { 10.4 } else { 10.5 };
        for courant in [0.7, 3.3, fastest] {
            let (v, rho, mu): (_, Vec<f64>, Vec<f64>) = (
                moving(&mut random, &grid, courant),
                random.density(&grid),
                random.cells(&grid, 1),
            );
            let d = direction(&mut random, &grid);
            // No term is ever below this cut, so the number of terms does not change with t.
            for longest in [1.0, 3.0] {
                let carry = Carry::new(&grid, scheme, 1e-200).in_substeps_of(longest);
                let (_, gradient) = carry.backward(&v, &rho, &mu).unwrap();
                let what =
                    format!("{scheme:?} on {cells:?} {ends} at Courant {courant} in sub-steps of {longest}");
                check(&what, dot_all(&gradient, &d), &|t| {
                    dot(&mu, &carry.forward(&add_scaled_all(&v, t, &d), &rho).unwrap())
                });
            }
        }
    }
}

fn step_gradient(scheme: Scheme, first: f64) {
    step_gradients(scheme, &|what, slope, value| taylor(what, first, slope, value));
}

#[test]
fn velocity_gradient_of_quick() {
    step_gradient(Scheme::Quick, 1e-3);
}

#[test]
fn velocity_gradient_of_central() {
    step_gradient(Scheme::Central, 1e-3);
}

/// Rows without smoke are passed over. The gradient is linear in rho, so it is also that of rho and a haze less that of the haze, which
/// leaves no row out.
#[test]
fn rows_without_smoke_are_passed_over() {
    let mut random = Random::new(23);
    for (cells, ends) in [
        (&[12, 120][..], "ww"),
        (&[9, 120], "pp"),
        (&[6, 70, 5], "wwp"),
        (&[5, 7, 70], "pww"),
    ] {
        let grid = grid(cells, ends);
        let long = if cells[1] > 60 { 1 } else { 2 };
        let (v, mu) = (moving(&mut random, &grid, 2.6), random.cells(&grid, 1));
        let along = |cell: usize| grid.row_at(cell / grid.n[0])[long - 1] * 10 / grid.n[long];
        let smoke: Vec<f64> = random
            .density(&grid)
            .into_iter()
            .enumerate()
            .map(|(cell, x): (usize, f64)| if along(cell) == 5 { x } else { 0.0 })
            .collect();
        let both: Vec<f64> = smoke.iter().map(|x| x + 1.0).collect();
        let carry = Carry::new(&grid, Scheme::Quick, 1e-15);
        let [(back, found), (_, of_both), (_, of_haze)] =
            [&smoke, &both, &vec![1.0; both.len()]].map(|rho| carry.backward(&v, rho, &mu).unwrap());
        let largest = of_both
            .iter()
            .flatten()
            .fold(0.0, |most: f64, x| most.max(x.abs()));
        for ((found, both), haze) in found.iter().zip(&of_both).zip(&of_haze) {
            let off = found
                .iter()
                .zip(both.iter().zip(haze))
                .fold(0.0, |most: f64, (found, (both, haze))| {
                    most.max((found - (both - haze)).abs())
                });
            assert!(off <= 1e-12 * largest, "{cells:?} {ends}: {off:e} of {largest:e}");
        }
        let (after, far) = (
            carry.forward(&v, &smoke).unwrap(),
            (0..both.len()).filter(|&cell| along(cell) == 0),
        );
        assert_close(
            &format!("mu where there is smoke on {cells:?}"),
            dot(&after, &mu),
            dot(&smoke, &back),
            dot(&both, &both),
            1e-14,
        );
        assert!(
            far.into_iter()
                .all(|cell| back[cell] == mu[cell] && after[cell] == 0.0),
            "{cells:?} {ends}: no row is far enough"
        );
    }
}

/// In a band of even smoke all terms of the series are exactly 0, and yet what flows there counts.
#[test]
fn even_smoke_is_not_passed_over() {
    let mut random = Random::new(24);
    for (cells, ends) in [(&[6, 40][..], "pp"), (&[5, 4, 40], "ppp")] {
        let grid = grid(cells, ends);
        let mu = random.cells(&grid, 1);
        let d = direction(&mut random, &grid);
        let v = flow::uniform(&grid, [0.3 * grid.h[0], 0.9 * grid.h[0], 0.4 * grid.h[0]]);
        let last = grid.dims - 1;
        let along = |cell: usize| grid.row_at(cell / grid.n[0])[last - 1];
        let rho: Vec<f64> = random
            .density(&grid)
            .into_iter()
            .enumerate()
            .map(|(cell, x): (usize, f64)| match along(cell) {
                5..20 => 1.0,
                30..33 => x,
                _ => 0.0,
            })
            .collect();
        let carry = Carry::new(&grid, Scheme::Quick, 1e-30);
        let (_, gradient) = carry.backward(&v, &rho, &mu).unwrap();
        taylor(
            &format!("even smoke on {cells:?}"),
            1e-3,
            dot_all(&gradient, &d),
            |t| dot(&mu, &carry.forward(&add_scaled_all(&v, t, &d), &rho).unwrap()),
        );
    }
}

#[test]
fn velocity_gradient_of_semi_lagrangian() {
    // Small steps: the map has a kink wherever an origin moves to another cell.
    step_gradient(Scheme::SemiLagrangian, 2e-5);
}

/// A cell at rest is at the kink of its interpolation: its gradient is the mean of both sides, as central differences have it.
#[test]
fn velocity_gradient_of_semi_lagrangian_at_rest() {
    let mut random = Random::new(33);
    for (cells, ends) in BOXES {
        let grid = grid(cells, ends);
        let (rho, mu): (Vec<f64>, _) = (random.density(&grid), random.cells(&grid, 1));
        let d = direction(&mut random, &grid);
        let carry = Carry::new(&grid, Scheme::SemiLagrangian, 1e-200);
        let rest = zeros(&grid, 1);
        let (_, gradient) = carry.backward(&rest, &rho, &mu).unwrap();
        let value = |t: f64| dot(&mu, &carry.forward(&add_scaled_all(&rest, t, &d), &rho).unwrap());
        const STEP: f64 = 1e-6;
        let differences = (value(STEP) - value(-STEP)) / (2.0 * STEP);
        let slope = dot_all(&gradient, &d);
        assert!(
            (differences - slope).abs() < 1e-4 * slope.abs().max(1.0),
            "{cells:?} {ends}: slope {slope:e}, differences {differences:e}"
        );
    }
}

#[test]
fn velocity_gradient_of_limited() {
    // The limiter has a kink wherever the smallest of its three slopes becomes another: steps so small that none is met, which leave
    // too little of the second order to be seen everywhere.
    step_gradients(Scheme::Limited, &|what, slope, value| {
        let t = 1e-7;
        let central = (value(t) - value(-t)) / (2.0 * t);
        assert!(
            (central - slope).abs() < 1e-6 * slope.abs().max(1.0),
            "{what}: {central} against {slope}"
        );
    });
}

#[test]
fn a_step_of_limited_is_of_second_order() {
    let mut random = Random::new(26);
    let grid = grid(&[10, 8], "wp");
    let (v, mu) = (moving(&mut random, &grid, 3.3), random.cells(&grid, 1));
    let rho: Vec<f64> = random.density(&grid);
    let d: Components<f64> = random.faces(&grid, 1);
    let d = d.map(|c| c.iter().map(|x| x * grid.h[0]).collect());
    let carry = Carry::new(&grid, Scheme::Limited, 1e-200);
    let (_, gradient) = carry.backward(&v, &rho, &mu).unwrap();
    taylor("limited", 4e-6, dot_all(&gradient, &d), |t| {
        dot(&mu, &carry.forward(&add_scaled_all(&v, t, &d), &rho).unwrap())
    });
}

#[test]
fn density_gradient_of_limited() {
    let mut random = Random::new(24);
    for (cells, ends) in [
        (&[10, 8][..], "ww"),
        (&[7, 9], "pw"),
        (&[6, 6], "pp"),
        (&[5, 4, 6], "pww"),
    ] {
        let grid = grid(cells, ends);
        for courant in [0.4, 3.3, 10.5] {
            let v = moving(&mut random, &grid, courant);
            let (rho, mu): (Vec<f64>, Vec<f64>) = (random.density(&grid), random.cells(&grid, 1));
            let d: Vec<f64> = random.cells(&grid, 1);
            let carry = Carry::new(&grid, Scheme::Limited, 1e-200);
            let (back, _) = carry.backward(&v, &rho, &mu).unwrap();
            let along = |t: f64| -> Vec<f64> { rho.iter().zip(&d).map(|(rho, d)| rho + t * d).collect() };
            let what = format!("density, {cells:?} {ends} at Courant {courant}");
            let (value, slope) = (
                |t| dot(&mu, &carry.forward(&v, &along(t)).unwrap()),
                dot(&back, &d),
            );
            let t = 1e-7;
            let central = (value(t) - value(-t)) / (2.0 * t);
            // Between its kinks a step is linear in rho.
            assert!(
                (central - slope).abs() < 1e-7 * slope.abs().max(1.0),
                "{what}: {central} against {slope}"
            );
        }
    }
}

#[test]
fn gradient_at_rest_is_the_mean_of_both_sides() {
    let mut random = Random::new(22);
    let grid = grid(&[8, 7], "wp");
    let rest = zeros::<f64>(&grid, 1);
    let (rho, mu): (Vec<f64>, Vec<f64>) = (random.density(&grid), random.cells(&grid, 1));
    let d: Components<f64> = random.faces(&grid, 1);
    let carry = Carry::new(&grid, Scheme::Quick, 1e-200);
    let (_, gradient) = carry.backward(&rest, &rho, &mu).unwrap();
    let value = |t: f64| dot(&mu, &carry.forward(&add_scaled_all(&rest, t, &d), &rho).unwrap());
    let t = 1e-7;
    let (central, slope) = ((value(t) - value(-t)) / (2.0 * t), dot_all(&gradient, &d));
    assert!(
        (central - slope).abs() < 1e-5 * slope.abs(),
        "{central} against {slope}"
    );
    let forward = (value(t) - value(0.0)) / t;
    assert!(
        (forward - slope).abs() > 1e-3 * slope.abs(),
        "this flow should have shown the kink"
    );
}
