//! The direct method on whole scenes: how far it gets, that its results are feasible, how it ends.

use crate::fields;
use crate::fields::cases::{Scene, Solved, StopAt};
use crate::fields::feasible::check;
use crate::fields::{assert_close, gap, largest, with_threads};
use thurible_core::{D2, D3, Method, Params, Real, Scheme, Serial, Silent, Space, Status};

/// The scene by the direct method.
pub fn direct(scene: Scene) -> Scene {
    Scene {
        params: Params {
            method: Method::Direct,
            ..scene.params
        },
        ..scene
    }
}

pub fn total(solved: &Solved) -> f64 {
    solved.objective.iter().sum()
}

/// Two prototypes came to 2.62 after 10 iterations and 2.338 after 45; ADMM to 2.57.
#[test]
fn circle_to_two_circles() {
    let mut scene = direct(Scene::two_circles());
    (
        scene.params.iterations,
        scene.params.threads,
        scene.params.direct.nested,
    ) = (45, 2, false);
    let solved = with_threads(2, |exec| scene.solve::<f64, D2>(exec, &mut Silent));
    check(&scene, &solved, f64::EPSILON);
    let after_ten = solved.history[9].objective.total();
    assert!(
        after_ten < 2.62 && total(&solved) < 2.338,
        "J = {after_ten} after 10 iterations, {} at the end",
        total(&solved)
    );
    for pair in solved.history.windows(2) {
        assert!(
            pair[1].objective.total() < pair[0].objective.total(),
            "the objective rose in iteration {}",
            pair[1].iteration
        );
    }
}

/// A ball on 32 x 32 cells.
pub fn balls(centre: [f64; 2]) -> Vec<f64> {
    fields::cases::balls(
        &fields::grid(&[32, 32], "ww"),
        &[[centre[0], centre[1], 0.5]],
        0.15,
    )
}

fn feasible<T: Real, S: Space>(cells: &[usize], ends: &str, scheme: Scheme) {
    let mut scene = direct(Scene {
        scheme,
        ..Scene::small(cells, ends, 5)
    });
    scene.keyframes = vec![3, 5];
    scene.densities.push(scene.densities[0].clone());
    let solved = scene.solve_alone::<T, S>();
    check(&scene, &solved, T::EPSILON);
    let first = solved
        .history
        .iter()
        .find(|progress| progress.level == 0)
        .unwrap();
    assert!(
        total(&solved) < first.objective.total(),
        "{cells:?} {ends}: from {first:?} to {}",
        total(&solved)
    );
}

#[test]
fn results_are_feasible() {
    feasible::<f32, D2>(&[16, 16], "ww", Scheme::Quick);
    feasible::<f32, D2>(&[32, 48], "wp", Scheme::Quick);
    feasible::<f64, D2>(&[17, 11], "wp", Scheme::Central);
    feasible::<f32, D2>(&[10, 13], "pp", Scheme::Quick);
    feasible::<f32, D3>(&[8, 7, 9], "www", Scheme::Quick);
    feasible::<f32, D3>(&[16, 16, 8], "wwp", Scheme::Quick);
    feasible::<f64, D3>(&[9, 8, 6], "pwp", Scheme::Central);
}

#[test]
fn other_units_give_the_same_iterates() {
    let scene = direct(Scene {
        scheme: Scheme::Quick,
        viscosity: 2e-3,
        ..Scene::small(&[14, 12], "ww", 6)
    });
    let solved = scene.solve_alone::<f64, D2>();
    for (dt, length, exact) in [(1.0 / 16.0, 8.0, true), (1.0 / 24.0, 10.0, false)] {
        let mut other = scene.clone();
        (other.dt, other.length) = (dt, length);
        other.force_weight = scene.force_weight * (dt * dt / length).powi(2);
        other.viscosity = scene.viscosity * length * length / dt;
        let found = other.solve_alone::<f64, D2>();
        check(&other, &found, f64::EPSILON);
        let (tolerance, ratio) = (if exact { 0.0 } else { 1e-9 }, length / dt);
        for (x, y) in solved.density.iter().zip(&found.density) {
            assert!(
                gap(x, y) <= tolerance,
                "densities are {:e} apart at dt = {dt}",
                gap(x, y)
            );
        }
        for (x, y) in solved
            .velocity
            .iter()
            .flatten()
            .zip(found.velocity.iter().flatten())
        {
            let error = largest(x.iter().zip(y).map(|(x, y)| x - y / ratio));
            assert!(error <= tolerance, "velocities are {error:e} apart at dt = {dt}");
        }
        assert_close("J", total(&found), total(&solved), total(&solved), tolerance);
    }
}

/// The search cuts the series of transport at a hundred times the cut of the result, on the coarser grids at ten times.
#[test]
fn the_cut_of_the_search_does_not_move_the_minimum() {
    for (cells, ends, scheme) in [
        (&[16, 16], "ww", Scheme::Quick),
        (&[16, 12], "wp", Scheme::Central),
    ] {
        let mut scene = direct(Scene {
            scheme,
            ..Scene::small(cells, ends, 8)
        });
        (scene.params.iterations, scene.params.direct.tolerance) = (400, 1e-7);
        let solve = |cut: f64| {
            let scene = Scene { cut, ..scene.clone() };
            let solved = scene.solve_alone::<f64, D2>();
            let last = solved.history.last().unwrap().objective.total();
            assert_eq!(solved.status, Status::Converged, "{cells:?}, cut {cut:e}");
            (total(&solved), (total(&solved) / last - 1.0).abs())
        };
        let ((as_usual, off), (exact, exact_off)) = (solve(1e-5), solve(1e-9));
        assert!(
            exact_off < 1e-6 && off < 1e-4,
            "{cells:?}: the last iteration is off by {off:e}, with less cut by {exact_off:e}"
        );
        assert!(
            (as_usual / exact - 1.0).abs() < 5e-6,
            "{cells:?}: J = {as_usual}, with less cut {exact}"
        );
    }
}

#[test]
fn weights_from_weak_to_strong() {
    for force_weight in [1e1, 1e2, 1e3, 1e4, 1e5] {
        let mut scene = direct(Scene {
            force_weight,
            scheme: Scheme::Quick,
            ..Scene::two_circles()
        });
        scene.params.iterations = 30;
        let solved = scene.solve_alone::<f32, D2>();
        assert!(
            matches!(solved.status, Status::Converged | Status::MaxIterations),
            "r = {force_weight:e}: {:?}",
            solved.status
        );
        check(&scene, &solved, f64::from(f32::EPSILON));
        // At rest there is no force, and what is left is the data term.
        let at_rest = Scene {
            params: Params {
                iterations: 1,
                ..scene.params
            },
            force_weight: 1e15,
            ..scene.clone()
        }
        .solve_alone::<f32, D2>();
        assert!(
            total(&solved) < total(&at_rest),
            "r = {force_weight:e}: {} against {} at rest",
            total(&solved),
            total(&at_rest)
        );
    }
}

#[test]
fn nothing_to_do_ends_early_and_at_rest() {
    let mut scene = direct(Scene::small(&[12, 10], "wp", 5));
    scene.densities[1] = scene.densities[0].clone();
    let solved = scene.solve_alone::<f64, D2>();
    assert_eq!((solved.status, solved.history.len()), (Status::Converged, 1));
    assert_eq!(solved.objective, [0.0, 0.0]);
}

#[test]
fn not_finite_when_the_given_flow_is_too_fast() {
    let scene = direct(Scene::small(&[12, 10], "pw", 5));
    let status = scene.with::<f64, D2, _>(|solver| {
        solver.set_initial_velocity(0, &[1e3; 120]).unwrap();
        solver.solve(&Serial, &mut Silent, &mut |_| {})
    });
    assert_eq!(status, Status::NotFinite);
}

#[test]
fn a_stop_at_any_time_leaves_a_feasible_flow() {
    let mut scene = direct(Scene::small(&[32, 20], "wp", 6));
    scene.params.iterations = 3;
    let mut counter = StopAt {
        at: usize::MAX,
        seen: 0,
    };
    scene.solve::<f64, D2>(&Serial, &mut counter);
    assert!(counter.seen > 200, "{} events", counter.seen);
    for at in (0..40).chain((40..counter.seen).step_by(counter.seen / 30)) {
        let solved = scene.solve::<f64, D2>(&Serial, &mut StopAt { at, seen: 0 });
        assert_eq!(solved.status, Status::Cancelled, "stopped at event {at}");
        if at > 100 {
            check(&scene, &solved, f64::EPSILON);
        }
    }
}

#[test]
fn a_solve_goes_on_after_a_stop() {
    let mut scene = direct(Scene::small(&[32, 20], "wp", 4));
    scene.params.iterations = 6;
    let whole = scene.solve_alone::<f64, D2>();
    for at in [0, 3, 50, 150, 300] {
        let resumed = scene.with::<f64, D2, _>(|solver| {
            let mut stop = StopAt { at, seen: 0 };
            while solver.step(&Serial, &mut stop).status != Some(Status::Cancelled) {}
            Solved::run(&scene, solver, &Serial, &mut Silent)
        });
        check(&scene, &resumed, f64::EPSILON);
        assert!(
            total(&resumed) < 1.2 * total(&whole),
            "J = {} after a stop, {} without",
            total(&resumed),
            total(&whole)
        );
    }
}
