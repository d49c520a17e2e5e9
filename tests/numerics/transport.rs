//! Density transport: what it keeps, how exact it is, when it is refused, and a plain second implementation beside it.

use crate::fields;
use crate::fields::carry::Carry;
use crate::fields::naive::Naive;
use crate::fields::random::Random;
use crate::fields::{Components, assert_close, cast, cast_all, dot, flow, gap, grid, largest, places, view};
use core::ops::ControlFlow;
use thurible_core::memory::{Ledger, Pool};
use thurible_core::transport::{Flow, Stop, Transport};
use thurible_core::{Advection, Event, Named, Real, Scheme, Serial, Silent};

pub const GRIDS: [(&[usize], &str); 7] = [
    (&[12, 12], "ww"),
    (&[13, 7], "ww"),
    (&[9, 14], "wp"),
    (&[4, 5], "pp"),
    (&[6, 5, 7], "www"),
    (&[5, 6, 4], "pwp"),
    (&[7, 7, 5], "ppp"),
];

pub const CONSERVING: [Scheme; 3] = [Scheme::Quick, Scheme::Central, Scheme::Limited];

/// A step by the core and by the second implementation.
pub fn both<T: Real>(scheme: Scheme, tolerance: f64, seed: u64) {
    let mut random = Random::new(seed);
    for (cells, ends) in GRIDS {
        let grid = grid(cells, ends);
        for courant in [0.4, 0.97, 4.6] {
            let v: Components<T> = flow::rough(&mut random, &grid, 1, courant);
            let rho: Vec<T> = random.density(&grid);
            for longest in [1.0, 3.0] {
                let carry = Carry::new(&grid, scheme, tolerance).in_substeps_of(longest);
                let found = carry.forward(&v, &rho).unwrap();
                let expected = Naive::new(&grid).transport(carry.stepping, &cast_all(&v), &cast(&rho));
                let (error, size) = (gap(&cast(&found), &expected), largest(expected.iter().copied()));
                assert!(
                    error <= 100.0 * T::EPSILON * size,
                    "{scheme:?} on {cells:?} {ends} at {courant}, {longest}: {error:e} apart"
                );
            }
        }
    }
}

#[test]
fn agrees_with_the_second_implementation() {
    for &scheme in Scheme::ALL {
        both::<f64>(scheme, 1e-5, 31);
        both::<f64>(scheme, 1e-200, 32);
        both::<f32>(scheme, 1e-5, 33);
    }
}

#[test]
fn series_ends_with_the_first_term_below_the_cut() {
    // At a loose cut the number of terms shows in the result: both implementations must stop at the same term.
    for tolerance in [0.3, 0.05, 1e-3] {
        both::<f64>(Scheme::Quick, tolerance, 34);
    }
    let mut random = Random::new(35);
    let grid = grid(&[10, 10], "ww");
    let (v, rho): (Components<f64>, Vec<f64>) =
        (flow::rough(&mut random, &grid, 1, 0.9), random.density(&grid));
    let at = |tolerance| {
        Carry::new(&grid, Scheme::Quick, tolerance)
            .forward(&v, &rho)
            .unwrap()
    };
    let exact = at(1e-200);
    for tolerance in [1e-2, 1e-4, 1e-6] {
        let error = gap(&at(tolerance), &exact);
        assert!(
            error > 0.0 && error < 3.0 * tolerance,
            "cut at {tolerance:e}: off by {error:e}"
        );
    }
}

fn keeps<T: Real>() {
    let mut random = Random::new(36);
    for ((cells, ends), scheme) in GRIDS.into_iter().flat_map(|g| CONSERVING.map(|s| (g, s))) {
        let grid = grid(cells, ends);
        let carry = Carry::new(&grid, scheme, T::EPSILON);
        for courant in [0.8, 5.4] {
            let what = format!("{scheme:?} on {cells:?} {ends} at {courant}");
            let (v, rho): (Components<T>, Vec<T>) =
                (flow::rough(&mut random, &grid, 1, courant), random.density(&grid));
            let after = carry.forward(&v, &rho).unwrap();
            let one = vec![T::ONE; rho.len()];
            assert_close(
                &format!("mass, {what}"),
                dot(&after, &one),
                dot(&rho, &one),
                dot(&rho, &one),
                20.0 * T::EPSILON,
            );
            if scheme == Scheme::Central {
                assert_close(
                    &format!("2-norm, {what}"),
                    dot(&after, &after),
                    dot(&rho, &rho),
                    dot(&rho, &rho),
                    100.0 * T::EPSILON,
                );
            }
            let uniform = carry.forward(&v, &one).unwrap();
            assert!(
                gap(&cast(&uniform), &cast(&one)) <= 100.0 * T::EPSILON,
                "a uniform density changes, {what}"
            );
        }
    }
}

#[test]
fn mass_norm_and_uniform_density_are_kept() {
    keeps::<f64>();
    keeps::<f32>();
}

#[test]
fn mass_is_kept_by_flows_with_divergence_too() {
    let mut random = Random::new(37);
    let grid = grid(&[9, 8], "wp");
    let v: Components<f64> = random
        .faces(&grid, 1)
        .map(|c| c.iter().map(|x: &f64| x / 40.0).collect());
    let rho: Vec<f64> = random.density(&grid);
    for scheme in CONSERVING {
        let after = Carry::new(&grid, scheme, 1e-14).forward(&v, &rho).unwrap();
        assert_close(
            "mass",
            after.iter().sum(),
            rho.iter().sum(),
            rho.iter().sum(),
            1e-13,
        );
    }
}

/// How far a smooth density that is carried a whole number of cells around a periodic box is from the shifted one.
fn translation(scheme: Scheme, n: usize) -> f64 {
    let grid = grid(&[n, n], "pp");
    let wave = |i: f64| (core::f64::consts::TAU * i / n as f64).sin();
    let density = |x: f64, y: f64| 1.0 + 0.5 * wave(x) * wave(y + 3.0) + 0.2 * wave(2.0 * x);
    let at = |dx: f64, dy: f64| {
        places(&grid)
            .map(|[x, y, _]| density(x as f64 - dx, y as f64 - dy))
            .collect::<Vec<f64>>()
    };
    let cells = n as f64 / 16.0;
    let v = flow::uniform(&grid, [cells * grid.h[0], -2.0 * cells * grid.h[1], 0.0]);
    gap(
        &Carry::new(&grid, scheme, 1e-12)
            .forward(&v, &at(0.0, 0.0))
            .unwrap(),
        &at(cells, -2.0 * cells),
    )
}

#[test]
fn translation_around_a_periodic_box() {
    for (scheme, most, order) in [
        (Scheme::Quick, 3e-3, 3.6),
        (Scheme::Central, 1e-2, 3.6),
        (Scheme::SemiLagrangian, 0.06, 1.8),
    ] {
        let (coarse, fine) = (translation(scheme, 32), translation(scheme, 64));
        assert!(coarse < most && fine < most, "{scheme:?}: {coarse:e}, {fine:e}");
        assert!(
            coarse / fine > order,
            "{scheme:?} converges too slowly: {coarse:e}, {fine:e}"
        );
    }
    assert!(
        translation(Scheme::Quick, 64) < 0.4 * translation(Scheme::Central, 64),
        "quick should be the more exact one"
    );
    // Along one axis a sub-step of semi-Lagrangian goes exactly one cell.
    let (grid, rho) = (
        grid(&[9, 5], "pw"),
        Random::new(41).density::<f64>(&grid(&[9, 5], "pw")),
    );
    let carry = Carry::new(&grid, Scheme::SemiLagrangian, 1e-5);
    let after = carry
        .forward(&flow::uniform(&grid, [4.0 / 9.0, 0.0, 0.0]), &rho)
        .unwrap();
    let shifted: Vec<f64> = places(&grid).map(|[x, y, _]| rho[9 * y + (x + 5) % 9]).collect();
    assert!(gap(&after, &shifted) < 1e-12);
}

/// Runs a whole trajectory; `stop` breaks at that event.
pub fn run(
    flow: &Flow<'_, f64>,
    grid: &thurible_core::grid::Grid,
    slots: usize,
    source: &[f64],
    stop: usize,
) -> Result<Vec<f64>, Stop> {
    let stepping = Advection {
        scheme: Scheme::Quick,
        tolerance: 1e-12,
    }
    .into();
    let mut ledger = Ledger::new();
    Transport::<f64>::carve(grid, stepping, 1.0, 1, &mut Pool::measuring(&mut ledger));
    let (mut elements, mut sums) = (vec![0.0; ledger.elements(8)], vec![0.0; grid.rows()]);
    let mut transport = Transport::carve(grid, stepping, 1.0, 1, &mut Pool::new(&mut elements));
    let mut rho = source.repeat(slots + 2);
    let mut observer = Stopper(stop);
    transport
        .run(&Serial, &mut observer, flow, slots, &mut rho, &mut sums)
        .map(|()| rho)
}

struct Stopper(usize);

impl thurible_core::Observer for Stopper {
    fn on(&mut self, _event: Event) -> ControlFlow<()> {
        self.0 = self.0.saturating_sub(1);
        if self.0 == 0 {
            ControlFlow::Break(())
        } else {
            Silent.on(Event::Work)
        }
    }
}

#[test]
fn trajectories_step_by_step() {
    let (mut random, slots) = (Random::new(40), 3);
    let grid = grid(&[7, 6], "wp");
    let [v, other]: [Components<f64>; 2] =
        core::array::from_fn(|_| flow::rough(&mut random, &grid, slots, 1.3));
    let (initial, source): (Components<f64>, Vec<f64>) =
        (flow::rough(&mut random, &grid, 1, 0.7), random.density(&grid));
    let flow = Flow {
        initial: view(&initial),
        v: view(&v),
        along: Some((view(&other), 0.25)),
    };
    let rho = run(&flow, &grid, slots, &source, usize::MAX).unwrap();
    let (mut expected, naive) = (source.clone(), Naive::new(&grid));
    for step in 0..=slots {
        let moved = |a: usize| {
            if step == 0 {
                initial[a].clone()
            } else {
                fields::add_scaled(&v[a], 0.25, &other[a])
            }
        };
        let all: Components<f64> = core::array::from_fn(|a| if a < 2 { moved(a) } else { Vec::new() });
        let now = if step == 0 {
            all
        } else {
            fields::slot_of_all(&grid, slots, step - 1, &all)
        };
        assert!(gap(&rho[step * 42..][..42], &expected) < 1e-12, "rho_{step}");
        expected = naive.transport(
            Advection {
                scheme: Scheme::Quick,
                tolerance: 1e-12,
            }
            .into(),
            &now,
            &expected,
        );
    }
    assert!(gap(&rho[4 * 42..], &expected) < 1e-12, "rho_N");
    assert_eq!(run(&flow, &grid, slots, &source, 2), Err(Stop::Cancelled));
    let fast = v.clone().map(|c| c.iter().map(|x| x * 100.0).collect());
    let flow = Flow {
        v: view(&fast),
        along: None,
        ..flow
    };
    assert_eq!(run(&flow, &grid, slots, &source, usize::MAX), Err(Stop::TooFast));
}
