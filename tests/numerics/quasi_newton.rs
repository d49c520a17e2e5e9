//! L-BFGS and the exact preconditioner in time.

use crate::fields;
use crate::fields::random::Random;
use crate::fields::{Components, assert_close, dot_all, grid, largest};
use thurible_core::Serial;
use thurible_core::field::trajectory::Shape;
use thurible_core::force::time_line::TimeLine;
use thurible_core::grid::Grid;
use thurible_core::memory::{Ledger, Pool};
use thurible_core::optimise::quasi_newton::fields::{Fields, Initial, take};
use thurible_core::optimise::quasi_newton::history::{History, HistoryPrecision};
use thurible_core::optimise::quasi_newton::recursion::QuasiNewton;

const SLOTS: usize = 5;

/// (kappa + S) x along time, S = (D + c)^T (D + c) with D x = x_k - x_{k-1}, for trajectories stored row by row.
fn hessian(grid: &Grid, kappa: f64, drag: f64, x: &[f64]) -> Vec<f64> {
    let n = grid.n[0];
    let at = |row: usize, slot: usize, i: usize| x[(row * SLOTS + slot) * n + i];
    let number = |index: usize| {
        let (row, slot, i) = (index / (SLOTS * n), index / n % SLOTS, index % n);
        let force =
            |slot: usize| (1.0 + drag) * at(row, slot, i) - if slot > 0 { at(row, slot - 1, i) } else { 0.0 };
        kappa * x[index] + (1.0 + drag) * force(slot) - if slot + 1 < SLOTS { force(slot + 1) } else { 0.0 }
    };
    (0..x.len()).map(number).collect()
}

/// Elements of the fields of L-BFGS.
fn elements(grid: &Grid, history: History) -> usize {
    let mut ledger = Ledger::new();
    take(grid, SLOTS, history, &mut Pool::<f64>::measuring(&mut ledger));
    ledger.elements(8)
}

#[test]
fn the_time_line_is_solved_exactly() {
    let (grid, mut random) = (grid(&[7, 5], "wp"), Random::new(91));
    for (kappa, drag) in [(1e-3, 0.0), (1.0, 0.0), (50.0, 0.0), (1e-3, 0.3), (1.0, 20.0)] {
        let x: Vec<f64> = random.cells(&grid, SLOTS);
        let mut found = hessian(&grid, kappa, drag, &x);
        let mut pivots = [0.0; SLOTS];
        let line = TimeLine::new(kappa, drag, &mut pivots);
        found
            .chunks_exact_mut(SLOTS * grid.n[0])
            .for_each(|row| line.solve(row, grid.n[0]));
        let error = largest(found.iter().zip(&x).map(|(x, y)| x - y));
        assert!(
            error < 1e-12 / kappa.min(1.0),
            "kappa {kappa}, drag {drag}: {error:e}"
        );
    }
}

/// Minimises the quadratic 1/2 <x, A x> - <b, x> with A = c + S in time, where c differs from face to face.
struct Quadratic {
    grid: Grid,
    weight: Components<f64>,
    linear: Components<f64>,
}

impl Quadratic {
    fn gradient(&self, x: &Components<f64>) -> Components<f64> {
        core::array::from_fn(|a| {
            let stiff = hessian(&self.grid, 0.0, 0.0, &x[a]);
            stiff
                .iter()
                .zip(&x[a])
                .zip(self.weight[a].iter().zip(&self.linear[a]))
                .map(|((s, x), (w, b))| s + w * x - b)
                .collect()
        })
    }
}

fn write(fields: &mut Fields<'_, f64>, index: usize, values: &Components<f64>) {
    fields[index]
        .iter_mut()
        .zip(values)
        .for_each(|(field, values)| field.copy_from_slice(values));
}

fn read(fields: &Fields<'_, f64>, index: usize) -> Components<f64> {
    core::array::from_fn(|a| fields[index][a].to_vec())
}

/// -H g by the two loops of Nocedal & Wright, algorithm 7.4, over pairs (s, y) with the newest last.
fn two_loops(
    grid: &Grid,
    line: &TimeLine<'_>,
    pairs: &[(Components<f64>, Components<f64>)],
    gradient: &Components<f64>,
) -> Components<f64> {
    let precondition = |x: &mut Components<f64>| {
        x.iter_mut()
            .flat_map(|c| c.chunks_exact_mut(SLOTS * grid.n[0]))
            .for_each(|row| line.solve(row, grid.n[0]))
    };
    let mut direction = gradient.clone();
    let mut weights = Vec::new();
    for (s, y) in pairs.iter().rev() {
        weights.push(dot_all(s, &direction) / dot_all(s, y));
        direction = fields::add_scaled_all(&direction, -weights[weights.len() - 1], y);
    }
    precondition(&mut direction);
    if let Some((s, y)) = pairs.last() {
        let mut image = y.clone();
        precondition(&mut image);
        let scale = dot_all(s, y) / dot_all(y, &image);
        direction.iter_mut().flatten().for_each(|x| *x *= scale);
    }
    for ((s, y), weight) in pairs.iter().zip(weights.iter().rev()) {
        direction = fields::add_scaled_all(&direction, weight - dot_all(y, &direction) / dot_all(s, y), s);
    }
    direction.map(|c| c.iter().map(|x| -x).collect())
}

/// Runs ten steps with exact line searches, every direction compared with that of the two loops over whole fields, from which it may be off
/// by `near` of the largest number.
fn descends(history: History, near: f64) -> f64 {
    let most = history.pairs;
    let (grid, mut random) = (grid(&[6, 4], "ww"), Random::new(92));
    let shape = Shape {
        grid: &grid,
        slots: SLOTS,
    };
    let weight: Components<f64> = random
        .faces(&grid, SLOTS)
        .map(|c: Vec<f64>| c.iter().map(|x| 1.5 + x).collect());
    let problem = Quadratic {
        grid,
        weight,
        linear: random.faces(&grid, SLOTS),
    };
    let mut numbers = vec![f64::NAN; elements(&grid, history)];
    let mut fields = take(&grid, SLOTS, history, &mut Pool::new(&mut numbers));
    let (mut pivots, mut sums) = ([0.0; SLOTS], vec![0.0; history.sums_per_row() * grid.rows()]);
    let initial = Initial {
        line: Some(TimeLine::new(1.0, 0.0, &mut pivots)),
        scale: 1.0,
        prepared: false,
    };
    let (mut newton, mut x, mut pairs) = (QuasiNewton::new(history), fields::zeros(&grid, SLOTS), Vec::new());
    let mut gradient = problem.gradient(&x);
    let before = dot_all(&gradient, &gradient);
    write(&mut fields, newton.first().gradient, &gradient);
    newton.arrive(
        &Serial,
        shape,
        &mut fields,
        newton.first(),
        None,
        &initial,
        &mut sums,
    );
    for step in 0..10 {
        let slope = newton.descend(&Serial, shape, &mut fields);
        let direction = read(&fields, newton.direction);
        let expected = two_loops(
            &grid,
            &initial.line.unwrap(),
            &pairs[pairs.len().saturating_sub(most)..],
            &gradient,
        );
        let off = largest(
            fields::add_scaled_all(&direction, -1.0, &expected)
                .into_iter()
                .flatten(),
        );
        assert!(
            off < near * largest(expected.iter().flatten().copied()),
            "direction {step} of {history:?} is off by {off:e}"
        );
        assert_close("slope", slope, dot_all(&gradient, &direction), slope.abs(), near);
        assert!(slope < 0.0);
        let curvature =
            dot_all(&direction, &problem.gradient(&direction)) + dot_all(&direction, &problem.linear);
        let length = -slope / curvature;
        x = fields::add_scaled_all(&x, length, &direction);
        let borrowed = newton.borrow().unwrap();
        let after = problem.gradient(&x);
        write(&mut fields, borrowed.gradient, &after);
        newton.arrive(
            &Serial,
            shape,
            &mut fields,
            borrowed,
            Some(length),
            &initial,
            &mut sums,
        );
        assert!(newton.has_pairs());
        pairs.push((
            direction.map(|c| c.iter().map(|x| x * length).collect()),
            fields::add_scaled_all(&after, -1.0, &gradient),
        ));
        gradient = after;
    }
    dot_all(&gradient, &gradient) / before
}

/// On a quadratic with exact line searches L-BFGS is the method of conjugate gradients, whatever the number of pairs.
#[test]
fn a_quadratic_is_minimised_as_by_conjugate_gradients() {
    let left = [1, 3, 8].map(|pairs| descends(History::full(pairs), 1e-9));
    assert!(left[0] < 1e-11, "squared gradients after ten steps: {left:?}");
    for other in left {
        assert_close("squared gradient", other, left[0], left[0], 1e-6);
    }
}

/// In halves s and z are in `f32` beside gradients in `f64`. What that leaves of the directions being conjugate is less than that.
#[test]
fn pairs_in_halves_give_nearly_the_same_directions() {
    for pairs in [1, 2, 3, 8] {
        let left = descends(halves(pairs), 1e-5);
        assert!(left < 1e-9, "squared gradients after ten steps: {left:e}");
    }
}

fn halves(pairs: usize) -> History {
    History {
        pairs,
        precision: HistoryPrecision::Half,
    }
}

#[test]
fn pairs_of_negative_curvature_are_left_out() {
    [History::full(2), halves(2)].into_iter().for_each(leaves_out);
}

fn leaves_out(history: History) {
    let (grid, mut random) = (grid(&[5, 4], "pp"), Random::new(93));
    let shape = Shape {
        grid: &grid,
        slots: SLOTS,
    };
    let mut numbers = vec![0.0; elements(&grid, history)];
    let mut fields = take(&grid, SLOTS, history, &mut Pool::new(&mut numbers));
    let (mut pivots, mut sums) = ([0.0; SLOTS], vec![0.0; history.sums_per_row() * grid.rows()]);
    let initial = Initial {
        line: Some(TimeLine::new(1.0, 0.0, &mut pivots)),
        scale: 1.0,
        prepared: false,
    };
    let mut newton = QuasiNewton::new(history);
    let gradient: Components<f64> = random.faces(&grid, SLOTS);
    write(&mut fields, newton.first().gradient, &gradient);
    newton.arrive(
        &Serial,
        shape,
        &mut fields,
        newton.first(),
        None,
        &initial,
        &mut sums,
    );
    newton.descend(&Serial, shape, &mut fields);
    let borrowed = newton.borrow().unwrap();
    // The gradient grew along the direction of descent: <s, y> < 0.
    write(
        &mut fields,
        borrowed.gradient,
        &gradient.map(|c| c.iter().map(|x| 2.0 * x).collect()),
    );
    newton.arrive(
        &Serial,
        shape,
        &mut fields,
        borrowed,
        Some(1.0),
        &initial,
        &mut sums,
    );
    assert!(!newton.has_pairs());
    // All but the direction and P g, two for a trial.
    let trials = (history.fields() - 2) / 2;
    assert!(
        (0..trials).all(|_| newton.borrow().is_some()),
        "its fields are free again"
    );
}
