//! Simulation without control: energy, rest, buoyancy.

use crate::fields;
use crate::fields::cases::{Scene, Solved, StopOnce};
use crate::fields::feasible::{check, faces};
use crate::fields::naive::Naive;
use crate::fields::{Components, add_scaled_all, assert_close, dot_all, flow, largest, largest_of, to_file};
use thurible_core::{D2, D3, Method, Params, Real, Serial, Silent, Space, Status};

/// A scene without control.
pub fn free(cells: &[usize], ends: &str, steps: usize) -> Scene {
    let scene = Scene::small(cells, ends, steps);
    let params = Params {
        method: Method::Simulate,
        ..scene.params
    };
    Scene {
        keyframes: Vec::new(),
        densities: vec![scene.densities[0].clone()],
        params,
        ..scene
    }
}

/// Simulates from v_0, in the scene's units.
fn simulate<T: Real, S: Space>(scene: &Scene, v: &Components<f64>) -> Solved {
    let grid = scene.problem().grid();
    let solved = scene.with::<T, S, _>(|solver| {
        for axis in 0..S::DIM {
            solver
                .set_initial_velocity(axis, &fields::cast(&to_file(&grid, axis, &v[axis])))
                .unwrap();
        }
        Solved::run(scene, solver, &Serial, &mut Silent)
    });
    assert_eq!((solved.status, solved.history.len()), (Status::Converged, 1));
    solved
}

fn velocities(scene: &Scene, solved: &Solved) -> Vec<Components<f64>> {
    solved
        .velocity
        .iter()
        .map(|v| faces(&scene.problem().grid(), v))
        .collect()
}

/// Adv does no work, so an implicit step loses exactly |v_k - v_{k-1}|^2.
fn energy_is_lost_as_it_should<T: Real, S: Space>(cells: &[usize], ends: &str, courant: f64) {
    let mut scene = free(cells, ends, 6);
    scene.params.simulation.tolerance = 1e-6;
    let grid = scene.problem().grid();
    let solved = simulate::<T, S>(&scene, &flow::swirl(&grid, 1, courant));
    check(&scene, &solved, T::EPSILON);
    let v = velocities(&scene, &solved);
    for pair in v.windows(2) {
        let change = add_scaled_all(&pair[1], -1.0, &pair[0]);
        let [before, after, lost] = [&pair[0], &pair[1], &change].map(|v| dot_all(v, v));
        assert!(
            after < before && lost > 0.0,
            "{cells:?} {ends}: energy {before} then {after}"
        );
        assert_close("energy", after + lost, before, before, 4e-5);
    }
    let (strongest, fastest) = (
        largest(solved.force.iter().flatten().flatten().copied()),
        largest(v.iter().map(largest_of)),
    );
    assert!(
        strongest < (1e-5 + 200.0 * T::EPSILON) * fastest,
        "forces of {strongest:e} without control at speed {fastest:e}"
    );
}

#[test]
fn a_free_flow_loses_energy_as_it_should() {
    for courant in [0.8, 5.0] {
        energy_is_lost_as_it_should::<f64, D2>(&[24, 16], "ww", courant);
        energy_is_lost_as_it_should::<f64, D2>(&[17, 20], "pw", courant);
        energy_is_lost_as_it_should::<f64, D3>(&[10, 8, 9], "wpw", courant);
        energy_is_lost_as_it_should::<f32, D3>(&[10, 8, 9], "wpw", courant);
    }
}

#[test]
fn a_uniform_flow_stays_where_nothing_stops_it() {
    let scene = free(&[12, 10], "pp", 7);
    let v = flow::uniform(&scene.problem().grid(), [0.05, -0.02, 0.0]);
    let solved = simulate::<f64, D2>(&scene, &v);
    for found in velocities(&scene, &solved) {
        assert!(largest_of(&add_scaled_all(&found, -1.0, &v)) < 1e-15);
    }
}

#[test]
fn what_rests_stays_at_rest() {
    let scene = free(&[9, 8, 7], "wpw", 5);
    let solved = simulate::<f32, D3>(&scene, &fields::zeros(&scene.problem().grid(), 1));
    assert!(
        solved
            .velocity
            .iter()
            .chain(&solved.force)
            .flatten()
            .flatten()
            .all(|&x| x == 0.0)
    );
    assert!(solved.density.iter().all(|rho| rho == &solved.density[0]));
}

/// Nothing acts but the buoyancy b rho along the last axis, rho taken at the step that it leads to.
fn smoke_rises<S: Space>(cells: &[usize], ends: &str, dt: f64, length: f64) {
    let mut scene = Scene {
        dt,
        length,
        ..free(cells, ends, 8)
    };
    let (grid, up) = (scene.problem().grid(), cells.len() - 1);
    scene.effects.buoyancy[up] = 2e-4 * length / (dt * dt);
    let solved = simulate::<f64, S>(&scene, &fields::zeros(&grid, 1));
    check(&scene, &solved, f64::EPSILON);
    let naive = Naive::new(&grid);
    for (k, u) in solved.force.iter().enumerate() {
        let lift = largest_of(&scene.effects.lift(&naive, &solved.density[k + 1]));
        let left = largest_of(&faces(&grid, u));
        assert!(
            left < 1e-3 * lift,
            "step {k}: a force of {left:e} beside a buoyancy of {lift:e}"
        );
    }
    let height = |rho: &[f64]| {
        fields::places(&grid)
            .zip(rho)
            .map(|(at, x)| at[up] as f64 * x)
            .sum::<f64>()
            / rho.iter().sum::<f64>()
    };
    let heights: Vec<f64> = solved.density.iter().skip(1).map(|rho| height(rho)).collect();
    assert!(heights.is_sorted_by(|a, b| a < b), "{heights:?}");
}

#[test]
fn smoke_rises_by_buoyancy() {
    smoke_rises::<D2>(&[20, 24], "ww", 1.0, 1.0);
    smoke_rises::<D2>(&[16, 16], "pw", 0.04, 5.0);
    smoke_rises::<D3>(&[8, 9, 12], "pww", 1.0, 1.0);
}

#[test]
fn a_free_flow_needs_no_keyframe_and_control_does() {
    use thurible_core::{Plan, PlanError, ProblemError};
    let scene = free(&[8, 8], "ww", 4);
    for method in [
        Method::Simulate,
        Method::Direct,
        Method::Admm,
        Method::Lbfgs,
        Method::Pd,
    ] {
        let planned = Plan::new::<f32, D2>(
            &scene.problem(),
            &Params {
                method,
                ..scene.params
            },
        )
        .map(|_| ());
        let expected = if method == Method::Simulate {
            Ok(())
        } else {
            Err(PlanError::Problem(ProblemError::NoKeyframe))
        };
        assert_eq!(planned, expected, "{method:?}");
    }
}

/// Whoever says stop once is heard, whenever that is.
#[test]
fn a_stop_that_is_said_once_is_heard() {
    let mut scene = free(&[12, 10], "wp", 4);
    scene.effects.buoyancy[1] = 2e-3;
    let mut steered = Scene::small(&[12, 10], "wp", 4);
    steered.params.method = Method::Admm;
    steered.params.iterations = 3;
    for scene in [scene, steered] {
        let mut all = StopOnce { at: 0, seen: 0 };
        scene.solve::<f64, D2>(&Serial, &mut all);
        assert!(all.seen > 20, "{}", all.seen);
        for at in 1..=all.seen {
            let solved = scene.solve::<f64, D2>(&Serial, &mut StopOnce { at, seen: 0 });
            assert_eq!(
                solved.status,
                Status::Cancelled,
                "{:?} at event {at} of {}",
                scene.params.method,
                all.seen
            );
        }
    }
}
