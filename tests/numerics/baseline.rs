//! What simulation, adjoint control and target-driven smoke share: units, choices, statuses.

use crate::fields::cases::{Scene, Solved, StopAt};
use crate::fields::feasible::{check, check_flow};
use crate::fields::largest;
use thurible_core::{D2, Method, Params, Scheme, Serial, Silent, Status};

/// The scene by another method.
pub fn by(method: Method, scene: Scene) -> Scene {
    Scene {
        params: Params {
            method,
            ..scene.params
        },
        ..scene
    }
}

pub fn total(solved: &Solved) -> f64 {
    solved.objective.iter().sum()
}

/// J of a flow at rest.
pub fn at_rest(scene: &Scene) -> f64 {
    let scene = Scene {
        force_weight: 1e15,
        params: Params {
            method: Method::Direct,
            iterations: 1,
            ..scene.params
        },
        ..scene.clone()
    };
    total(&scene.solve_alone::<f64, D2>())
}

#[test]
fn other_units_give_the_same_iterates() {
    for method in [Method::Lbfgs, Method::Pd] {
        let mut scene = by(
            method,
            Scene {
                scheme: Scheme::Quick,
                viscosity: 2e-3,
                ..Scene::small(&[14, 12], "ww", 6)
            },
        );
        scene.params.pd.gathering = 0.02;
        let solved = scene.solve_alone::<f64, D2>();
        let mut other = Scene {
            dt: 1.0 / 16.0,
            length: 8.0,
            ..scene.clone()
        };
        other.force_weight = scene.force_weight * (other.dt * other.dt / other.length).powi(2);
        other.viscosity = scene.viscosity * other.length * other.length / other.dt;
        let found = other.solve_alone::<f64, D2>();
        check_flow(&other, &found, f64::EPSILON);
        assert!(
            solved.density == found.density
                && largest(
                    solved.density[6]
                        .iter()
                        .zip(&solved.density[0])
                        .map(|(x, y)| x - y)
                ) > 0.1,
            "{method:?}"
        );
        assert_eq!(solved.objective, found.objective, "{method:?}");
    }
}

#[test]
fn parameters_out_of_range_are_refused() {
    use thurible_core::{Plan, PlanError, ProblemError};
    let refused = |change: fn(&mut Params)| {
        let mut scene = Scene::small(&[8, 8], "ww", 4);
        change(&mut scene.params);
        match Plan::new::<f32, D2>(&scene.problem(), &scene.params) {
            Err(PlanError::Problem(
                ProblemError::Negative { field, .. }
                | ProblemError::NotPositive { field, .. }
                | ProblemError::NotFinite { field, .. },
            )) => field,
            Err(PlanError::OutOfRange { field, .. }) => field,
            other => panic!("{:?}", other.map(|_| ())),
        }
    };
    assert_eq!(refused(|params| params.pd.drive = -1.0), "pd.drive");
    assert_eq!(
        refused(|params| params.pd.attenuation = f64::NAN),
        "pd.attenuation"
    );
    assert_eq!(
        refused(|params| params.pd.gathering = f64::INFINITY),
        "pd.gathering"
    );
    assert_eq!(
        refused(|params| params.simulation.tolerance = 0.0),
        "simulation.tolerance"
    );
    assert_eq!(
        refused(|params| params.lbfgs.tolerance = -1e-3),
        "lbfgs.tolerance"
    );
    assert_eq!(refused(|params| params.lbfgs.history = Some(9)), "lbfgs.history");
}

#[test]
fn not_finite_when_the_given_flow_is_too_fast() {
    for method in [Method::Simulate, Method::Pd, Method::Lbfgs] {
        let scene = by(method, Scene::small(&[12, 10], "pw", 5));
        let status = scene.with::<f64, D2, _>(|solver| {
            solver.set_initial_velocity(0, &[1e3; 120]).unwrap();
            solver.solve(&Serial, &mut Silent, &mut |_| {})
        });
        assert_eq!(status, Status::NotFinite, "{method:?}");
    }
}

#[test]
fn a_stop_at_any_time_leaves_a_feasible_flow() {
    for method in [Method::Simulate, Method::Pd, Method::Lbfgs] {
        let mut scene = by(method, Scene::small(&[32, 20], "wp", 4));
        scene.params.iterations = 2;
        scene.params.lbfgs.nested = true;
        scene.params.pd.gathering = 0.01;
        scene.effects.buoyancy[1] = 1e-3;
        let mut counter = StopAt {
            at: usize::MAX,
            seen: 0,
        };
        scene.solve::<f64, D2>(&Serial, &mut counter);
        assert!(counter.seen > 15, "{} events of {method:?}", counter.seen);
        for at in (0..counter.seen).step_by((counter.seen / 40).max(1)) {
            let solved = scene.solve::<f64, D2>(&Serial, &mut StopAt { at, seen: 0 });
            assert_eq!(
                solved.status,
                Status::Cancelled,
                "{method:?} stopped at event {at}"
            );
            if largest(solved.velocity.iter().flatten().flatten().copied()) > 0.0 {
                check(&scene, &solved, f64::EPSILON);
            }
        }
    }
}
