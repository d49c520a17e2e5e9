//! Target-driven smoke.

use crate::baseline::{at_rest, by};
use crate::fields::cases::Scene;
use crate::fields::feasible::{check, check_flow};
use crate::fields::{assert_close, largest, with_threads};
use thurible_core::objective::script::{Lists, Script};
use thurible_core::{D2, D3, Method, Params, Scheme, Silent, Status};

#[test]
fn target_driven_smoke_is_feasible_and_moves_to_the_target() {
    for (method, threads) in [(Method::Pd, 1), (Method::Pd, 3)] {
        let mut scene = by(method, Scene::two_circles());
        scene.params.threads = threads;
        let solved = with_threads(threads, |exec| scene.solve::<f32, D2>(exec, &mut Silent));
        assert_eq!((solved.status, solved.history.len()), (Status::Converged, 1));
        check(&scene, &solved, f64::from(f32::EPSILON));
        assert!(
            solved.objective[0] < 0.3 * at_rest(&scene),
            "data term {}",
            solved.objective[0]
        );
    }
    let scene = by(
        Method::Pd,
        Scene {
            scheme: Scheme::Quick,
            ..Scene::small(&[12, 10, 14], "wpw", 8)
        },
    );
    check(&scene, &scene.solve_alone::<f64, D3>(), f64::EPSILON);
}

/// The data term that target-driven smoke ends with.
fn driven(drive: f64, gathering: f64) -> f64 {
    let mut scene = by(
        Method::Pd,
        Scene {
            scheme: Scheme::Quick,
            ..Scene::two_circles()
        },
    );
    (scene.params.pd.drive, scene.params.pd.gathering) = (drive, gathering);
    let solved = scene.solve_alone::<f64, D2>();
    assert_eq!(solved.status, Status::Converged);
    check_flow(&scene, &solved, f64::EPSILON);
    let mass = |rho: &[f64]| rho.iter().sum::<f64>();
    for rho in &solved.density {
        assert_close(
            "mass",
            mass(rho),
            mass(&solved.density[0]),
            mass(&solved.density[0]),
            1e-12,
        );
    }
    solved.objective[0]
}

/// The paper's Figure 15: too weak a force does not arrive, too strong a force overshoots, gathering brings what is left.
#[test]
fn target_driven_smoke_wants_tuning_and_gathers() {
    let right = Params::default().pd.drive;
    let [weak, middle, strong] = [0.05, 1.0, 10.0].map(|s| driven(s * right, 0.0));
    let gathered = driven(right, 0.05);
    println!("weak {weak}, right {middle}, strong {strong}, gathered {gathered}");
    assert!(
        middle < 0.5 * weak && middle < 0.5 * strong,
        "data terms {weak}, {middle}, {strong}"
    );
    assert!(
        gathered < 0.8 * middle,
        "{gathered} with gathering, {middle} without"
    );
}

#[test]
fn targets_that_are_reached_drive_nothing() {
    let mut scene = by(Method::Pd, Scene::small(&[12, 10], "wp", 5));
    scene.densities[1] = scene.densities[0].clone();
    scene.params.pd.gathering = 0.1;
    let solved = scene.solve_alone::<f64, D2>();
    // rho~ = rho*~, so the force is the gradient of rho*~ and pressure balances it, but for the means at faces.
    let fastest = largest(solved.velocity.iter().flatten().flatten().copied());
    assert!(fastest < 2e-3, "a flow of {fastest}");
}

/// Keyframes in a row are one stay: on each of them the way is that to the first.
#[test]
fn the_way_to_a_keyframe_that_is_held_is_that_to_its_first_step() {
    let steps = [2, 3, 7, 9, 10, 11, 20];
    let script = |steps| {
        let lists = Lists {
            steps,
            ..Lists::default()
        };
        Script::<f32>::new(lists, &[])
    };
    let keyframes = script(&steps);
    let (mut next, mut way, mut left) = (0, 2, 2);
    for step in 1..=25 {
        if step > left && next + 1 < steps.len() {
            next += 1;
            let to = steps[next] as usize;
            way = if to == left + 1 { way } else { to - left };
            left = to;
        }
        assert_eq!(keyframes.next(step), (next, way), "step {step}");
        let at = steps.iter().position(|&at| at as usize == step);
        assert_eq!(keyframes.at(step), at, "step {step}");
    }
    let halved = [4, 8, 10];
    let coarse = script(&halved).coarse(2, &[]);
    assert_eq!([1, 3, 5].map(|step| coarse.next(step)), [(0, 2), (1, 2), (2, 2)]);
    assert_eq!([4, 5, 6].map(|step| coarse.at(step)), [Some(1), Some(2), None]);
}
