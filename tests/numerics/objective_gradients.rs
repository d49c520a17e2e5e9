//! Gradients of the objective, of the data term alone and by every way to write the problem, against differences.

use crate::effects::among;
use crate::fields;
use crate::fields::control::Control;
use crate::fields::effects::Effects;
use crate::fields::naive::Naive;
use crate::fields::random::Random;
use crate::fields::{Components, add_scaled_all, cast, dot, dot_all, flow, grid, slot_of_all, zeros};
use crate::gradients::taylor;
use thurible_core::grid::Grid;
use thurible_core::objective::script::Lists;
use thurible_core::{Advection, D2, D3, Scheme, Space};

/// What a [`Control`] borrows, drawn at random, with keyframes at steps 2 and 5.
struct Drawn {
    grid: Grid,
    source: Vec<f64>,
    targets: Vec<f64>,
    initial: Components<f64>,
    scheme: Scheme,
}

impl Drawn {
    fn new(random: &mut Random, cells: &[usize], ends: &str, scheme: Scheme, courant: f64) -> Self {
        let grid = grid(cells, ends);
        let (source, targets) = (
            random.density(&grid),
            [random.density(&grid), random.density(&grid)].concat(),
        );
        let initial = flow::rough(random, &grid, 1, courant);
        Self {
            grid,
            source,
            targets,
            initial,
            scheme,
        }
    }

    fn control(&self, penalty: f64, viscosity: f64, smoothing: f64) -> Control<'_, f64> {
        Control {
            grid: &self.grid,
            steps: 5,
            source: &self.source,
            lists: Lists {
                steps: &[2, 5],
                ..Lists::default()
            },
            fields: &self.targets,
            buoyancy: [0.0; 3],
            solid: &[],
            sticks: false,
            initial: &self.initial,
            advection: Advection {
                scheme: self.scheme,
                tolerance: 1e-200,
            },
            filters: 2,
            penalty,
            viscosity,
            smoothing,
        }
    }
}

/// The data term of a whole trajectory, its gradient taken from AO's direction: Q(lambda/K - dF/dv / K) at v* = v.
fn trajectory_gradient(cells: &[usize], ends: &str, scheme: Scheme, first: f64) {
    let mut random = Random::new(23);
    let drawn = Drawn::new(&mut random, cells, ends, scheme, 0.8);
    let (control, grid) = (drawn.control(10.0, 0.0, 0.0), &drawn.grid);
    let slots = control.steps - 1;
    let v: Components<f64> = flow::rough(&mut random, grid, slots, 1.6);
    let d: Components<f64> = flow::rough(&mut random, grid, slots, 1.0);
    let multiplier: Components<f64> = flow::rough(&mut random, grid, slots, 0.5);
    let found = control.solve(&v, &multiplier, 1);
    let moved = add_scaled_all(&found.direction, -1.0, &multiplier);
    let slope = -control.penalty * dot_all(&moved, &d);
    let data = |t: f64| data_term(&control, &add_scaled_all(&v, t, &d));
    assert!(
        (found.info.data_before - data(0.0)).abs() < 1e-10 * data(0.0),
        "data term {} against {}",
        found.info.data_before,
        data(0.0)
    );
    taylor(
        &format!("data term on {cells:?} {ends}, {scheme:?}"),
        first,
        slope,
        data,
    );
}

/// 1/2 sum <e, C e>, by the second implementation.
fn data_term(control: &Control<'_, f64>, v: &Components<f64>) -> f64 {
    let (naive, mut rho, mut sum) = (Naive::new(control.grid), control.source.to_vec(), 0.0);
    for step in 0..control.steps {
        let v = if step == 0 {
            control.initial.clone()
        } else {
            slot_of_all(control.grid, control.steps - 1, step - 1, v)
        };
        rho = naive.transport(control.advection.into(), &v, &rho);
        if let Some(at) = control.lists.steps.iter().position(|&k| k as usize == step + 1) {
            let e: Vec<f64> = cast(&rho)
                .iter()
                .zip(&control.fields[at * rho.len()..])
                .map(|(x, y): (&f64, &f64)| x - y)
                .collect();
            sum += 0.5 * dot(&e, &naive.metric(control.filters, &e));
        }
    }
    sum
}

#[test]
fn data_term_of_a_trajectory() {
    trajectory_gradient(&[8, 10], "ww", Scheme::Central, 1e-3);
    trajectory_gradient(&[9, 7], "pw", Scheme::Quick, 1e-4);
    trajectory_gradient(&[5, 6, 4], "wpw", Scheme::Central, 1e-3);
    trajectory_gradient(&[6, 6], "pp", Scheme::SemiLagrangian, 2e-5);
}

/// With buoyancy AO's objective has the force of v among the densities of v*: its gradient by v*, taken from AO's direction at v* = v.
fn gradient_with_buoyancy(cells: &[usize], ends: &str, scheme: Scheme, first: f64) {
    let mut random = Random::new(29);
    let drawn = Drawn::new(&mut random, cells, ends, scheme, 0.8);
    let grid = &drawn.grid;
    let buoyancy = [0.3, -0.5, if grid.dims == 3 { 0.4 } else { 0.0 }];
    let control = Control {
        buoyancy,
        ..drawn.control(10.0, 0.01, 0.0)
    };
    let slots = control.steps - 1;
    let v: Components<f64> = flow::rough(&mut random, grid, slots, 1.6);
    let d: Components<f64> = flow::rough(&mut random, grid, slots, 1.0);
    let found = control.solve(&v, &zeros(grid, slots), 1);
    let price = |t: f64| price_among(&control, &v, &add_scaled_all(&v, t, &d));
    let value = |t: f64| data_term(&control, &add_scaled_all(&v, t, &d)) + price(t);
    assert!(price(0.0) > 0.1 * value(0.0), "the force does not count");
    taylor(
        &format!("AO with buoyancy on {cells:?} {ends}, {scheme:?}"),
        first,
        -control.penalty * dot_all(&found.direction, &d),
        value,
    );
}

/// 1/2 sum |P[v_k - v_{k-1} + Adv(v_k) + nu C^T C v_k - B rho_k]|^2 with the densities that `carrying` carries, by the second implementation.
fn price_among(control: &Control<'_, f64>, v: &Components<f64>, carrying: &Components<f64>) -> f64 {
    let (grid, slots) = (control.grid, control.steps - 1);
    let naive = Naive {
        viscosity: control.viscosity,
        ..Naive::new(grid)
    };
    let effects = Effects {
        buoyancy: control.buoyancy,
        ..Effects::default()
    };
    let of = |v: &Components<f64>, step: usize| match step.checked_sub(1) {
        None => control.initial.clone(),
        Some(slot) => slot_of_all(grid, slots, slot, v),
    };
    let (mut rho, mut sum) = (control.source.to_vec(), 0.0);
    for step in 1..=slots {
        rho = naive.transport(control.advection.into(), &of(carrying, step - 1), &rho);
        let now = of(v, step);
        let w = add_scaled_all(&now, -1.0, &of(v, step - 1));
        let w = add_scaled_all(&w, 1.0, &naive.advection(&now));
        let w = add_scaled_all(&w, -1.0, &effects.lift(&naive, &rho));
        let w = among(grid, &vec![false; grid.cells()], w);
        sum += 0.5 * dot_all(&w, &w);
    }
    sum
}

#[test]
fn advection_problem_with_buoyancy() {
    gradient_with_buoyancy(&[8, 10], "ww", Scheme::Central, 1e-4);
    gradient_with_buoyancy(&[9, 8], "pw", Scheme::Limited, 1e-5);
    gradient_with_buoyancy(&[5, 6, 4], "wpw", Scheme::Central, 1e-4);
}

/// The objective as a function of the flow, of weights that make both parts count.
fn direct_gradient<S: Space>(
    cells: &[usize],
    ends: &str,
    scheme: Scheme,
    [viscosity, smoothing]: [f64; 2],
    first: f64,
) {
    let mut random = Random::new(24);
    let drawn = Drawn::new(&mut random, cells, ends, scheme, 0.8);
    let (control, grid) = (drawn.control(1.0, viscosity, smoothing), &drawn.grid);
    let slots = control.steps - 1;
    let v: Components<f64> = flow::rough(&mut random, grid, slots, 1.6);
    let d: Components<f64> = flow::rough(&mut random, grid, slots, 1.0);
    let (at_v, gradient) = control.direct::<S>(&v, 1.0);
    let force_weight = 3.0 * at_v.data / at_v.force;
    let (_, gradient_of_both) = control.direct::<S>(&v, force_weight);
    for (what, weight, gradient) in [
        ("mostly data", 1.0, &gradient),
        ("data and force", force_weight, &gradient_of_both),
    ] {
        let value = |t: f64| control.direct::<S>(&add_scaled_all(&v, t, &d), weight).0.total();
        taylor(
            &format!("{what} on {cells:?} {ends}, {scheme:?}"),
            first,
            dot_all(gradient, &d),
            value,
        );
    }
}

#[test]
fn objective_of_the_direct_method() {
    direct_gradient::<D2>(&[8, 10], "ww", Scheme::Central, [0.0, 0.0], 1e-3);
    direct_gradient::<D2>(&[8, 10], "wp", Scheme::Central, [1e-3, 0.0], 1e-3);
    direct_gradient::<D2>(&[9, 7], "pw", Scheme::Quick, [0.0, 0.0], 1e-4);
    direct_gradient::<D3>(&[5, 6, 4], "wpw", Scheme::Central, [0.01, 0.0], 1e-3);
    direct_gradient::<D2>(&[6, 6], "pp", Scheme::SemiLagrangian, [0.0, 0.0], 2e-5);
}

#[test]
fn objective_with_a_price_of_curls() {
    direct_gradient::<D2>(&[8, 10], "ww", Scheme::Central, [0.0, 0.05], 1e-3);
    direct_gradient::<D2>(&[9, 7], "pw", Scheme::Limited, [1e-3, 0.02], 1e-5);
    direct_gradient::<D3>(&[5, 6, 4], "wpw", Scheme::Central, [0.01, 0.1], 1e-3);
    adjoint_gradient::<D2>(&[8, 10], "wp", Scheme::Central, 1.0, [0.0, 0.05], 1e-4);
    adjoint_gradient::<D3>(&[5, 6, 4], "pww", Scheme::Central, 1.0, [0.01, 0.1], 1e-4);
}

/// The objective as a function of the forces, which are simulated: of weights that make both parts count.
fn adjoint_gradient<S: Space>(
    cells: &[usize],
    ends: &str,
    scheme: Scheme,
    courant: f64,
    [viscosity, smoothing]: [f64; 2],
    first: f64,
) {
    let mut random = Random::new(25);
    let drawn = Drawn::new(&mut random, cells, ends, scheme, courant);
    let (control, grid) = (drawn.control(1.0, viscosity, smoothing), &drawn.grid);
    let slots = control.steps - 1;
    let u: Components<f64> = flow::rough(&mut random, grid, slots, 0.5 * courant);
    let d: Components<f64> = flow::rough(&mut random, grid, slots, 1.0);
    let (at_u, gradient, _) = control.simulated::<S>(&u, 1.0, 1e-13);
    let force_weight = 3.0 * at_u.data / at_u.force;
    let (_, gradient_of_both, _) = control.simulated::<S>(&u, force_weight, 1e-13);
    for (what, weight, gradient) in [
        ("mostly data", 1.0, &gradient),
        ("data and force", force_weight, &gradient_of_both),
    ] {
        let value = |t: f64| {
            control
                .simulated::<S>(&add_scaled_all(&u, t, &d), weight, 1e-13)
                .0
                .total()
        };
        taylor(
            &format!("{what} on {cells:?} {ends}, {scheme:?}"),
            first,
            dot_all(gradient, &d),
            value,
        );
    }
}

#[test]
fn objective_of_the_forces() {
    adjoint_gradient::<D2>(&[8, 10], "ww", Scheme::Central, 1.0, [0.0, 0.0], 1e-3);
    adjoint_gradient::<D2>(&[8, 10], "ww", Scheme::Central, 5.0, [1e-3, 0.0], 2e-4);
    adjoint_gradient::<D2>(&[9, 7], "pw", Scheme::Quick, 1.0, [0.0, 0.0], 1e-4);
    adjoint_gradient::<D3>(&[5, 6, 4], "wpw", Scheme::Central, 1.0, [0.01, 0.0], 1e-3);
    adjoint_gradient::<D2>(&[6, 6], "pp", Scheme::SemiLagrangian, 0.8, [0.0, 0.0], 2e-5);
}

/// A gradient takes one linear solve a step where a simulation takes several: counted in V-cycles and transport steps.
#[test]
fn a_gradient_costs_less_than_three_simulations() {
    for (cells, courant) in [(32, 1.0), (64, 2.0), (48, 5.0)] {
        let grid = grid(&[cells, cells], "ww");
        let steps = 8;
        let (initial, source) = (
            flow::swirl(&grid, 1, courant),
            fields::cases::balls(&grid, &[[0.4, 0.5, 0.5]], 0.2),
        );
        let target = fields::cases::balls(&grid, &[[0.6, 0.5, 0.5]], 0.2);
        let advection = Advection {
            scheme: Scheme::Quick,
            tolerance: 1e-5,
        };
        let control = Control {
            grid: &grid,
            steps,
            source: &source,
            lists: Lists {
                steps: &[8],
                ..Lists::default()
            },
            fields: &target,
            buoyancy: [0.0; 3],
            solid: &[],
            sticks: false,
            initial: &initial,
            advection,
            filters: 3,
            penalty: 1.0,
            viscosity: 0.0,
            smoothing: 0.0,
        };
        let (_, _, [forward, backward]) = control.simulated::<D2>(&zeros(&grid, steps - 1), 1e3, 1e-5);
        assert!(
            backward < 3 * forward,
            "{backward} pieces of work for a gradient, {forward} for a simulation on {cells} cells at Courant {courant}"
        );
        println!("{cells} cells, Courant {courant}: gradient {backward}, simulation {forward}");
    }
}
