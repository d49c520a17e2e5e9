//! L-BFGS over the forces, by the adjoint of a simulation.

use crate::baseline::{at_rest, by, total};
use crate::fields;
use crate::fields::cases::Scene;
use crate::fields::feasible::check;
use crate::fields::{assert_close, grid, with_threads};
use thurible_core::{D2, D3, Method, Real, Scheme, Silent, Space};

fn adjoint_control<T: Real, S: Space>(cells: &[usize], ends: &str, scheme: Scheme) {
    let mut scene = by(
        Method::Lbfgs,
        Scene {
            scheme,
            ..Scene::small(cells, ends, 5)
        },
    );
    scene.params.iterations = 5;
    scene.keyframes = vec![3, 5];
    scene.densities.push(scene.densities[0].clone());
    let solved = scene.solve_alone::<T, S>();
    check(&scene, &solved, T::EPSILON);
    for pair in solved.history.windows(2) {
        assert!(
            pair[1].objective.total() < pair[0].objective.total(),
            "{cells:?} {ends}: the objective rose in iteration {}",
            pair[1].iteration
        );
    }
    // What is made feasible is what was simulated.
    let last = solved.history.last().unwrap();
    assert_close(
        "J of the simulation",
        last.objective.total(),
        total(&solved),
        total(&solved),
        1e-3,
    );
}

#[test]
fn adjoint_control_is_feasible() {
    adjoint_control::<f32, D2>(&[16, 16], "ww", Scheme::Quick);
    adjoint_control::<f64, D2>(&[17, 11], "wp", Scheme::Central);
    adjoint_control::<f32, D2>(&[10, 13], "pp", Scheme::Quick);
    adjoint_control::<f32, D3>(&[8, 7, 9], "www", Scheme::Quick);
    adjoint_control::<f64, D3>(&[9, 8, 6], "pwp", Scheme::Central);
}

/// ADMM came to 2.57 and the direct method to 2.338 after 45 iterations.
#[test]
fn adjoint_control_of_circle_to_two_circles() {
    let mut scene = by(Method::Lbfgs, Scene::two_circles());
    (scene.params.iterations, scene.params.threads) = (25, 2);
    let solved = with_threads(2, |exec| scene.solve::<f64, D2>(exec, &mut Silent));
    check(&scene, &solved, f64::EPSILON);
    let evaluations: usize = solved
        .history
        .iter()
        .map(|progress| progress.report.get("evaluations").unwrap() as usize)
        .sum();
    println!(
        "J = {} after {} iterations, {evaluations} evaluations",
        total(&solved),
        solved.history.len()
    );
    assert!(total(&solved) < 0.1 * at_rest(&scene), "J = {}", total(&solved));
    assert!(
        evaluations <= 2 * solved.history.len() + 10,
        "{evaluations} evaluations"
    );
}

/// Two ways to write one problem: the forces of all flows, the flows of all forces.
#[test]
fn adjoint_control_and_the_direct_method_meet() {
    let end = |method: Method| {
        let mut scene = by(
            method,
            Scene {
                scheme: Scheme::Quick,
                ..Scene::small(&[16, 14], "wp", 6)
            },
        );
        (
            scene.params.iterations,
            scene.params.direct.tolerance,
            scene.params.lbfgs.tolerance,
        ) = (150, 1e-6, 1e-6);
        scene.params.simulation.tolerance = 1e-7;
        total(&scene.solve_alone::<f64, D2>())
    };
    let (direct, adjoint) = (end(Method::Direct), end(Method::Lbfgs));
    println!("J = {direct} by the direct method, {adjoint} by adjoint control");
    assert_close("J", adjoint, direct, direct, 1e-3);
}

#[test]
fn the_nested_start_of_adjoint_control_is_ahead() {
    let far = |nested: bool| {
        let ball = |centre: f64| fields::cases::balls(&grid(&[32, 32], "ww"), &[[centre, centre, 0.5]], 0.15);
        let mut scene = by(Method::Lbfgs, Scene::small(&[32, 32], "ww", 12));
        (scene.params.iterations, scene.params.lbfgs.nested) = (6, nested);
        scene.densities = vec![ball(0.3), ball(0.7)];
        let solved = scene.solve_alone::<f64, D2>();
        check(&scene, &solved, f64::EPSILON);
        total(&solved)
    };
    let (nested, from_rest) = (far(true), far(false));
    assert!(
        nested < 0.8 * from_rest,
        "J = {nested} nested, {from_rest} from rest"
    );
}
