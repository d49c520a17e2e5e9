//! ADMM on whole scenes: how it converges, that its result is feasible, that units do not matter.

use crate::fields;
use crate::fields::cases::{Scene, Solved, admm, balls};
use crate::fields::feasible::check;
use crate::fields::random::Random;
use crate::fields::{
    Components, add_scaled_all, assert_close, gap, grid, largest, largest_of, places, with_threads,
};
use thurible_core::{D2, D3, Method, NsoSolver, Params, Progress, Real, Scheme, Silent, Space, Status};

/// Solves circle to two circles on two threads: as the paper does, or with the defaults.
fn two_circles(from_rest: bool) -> (Scene, Solved) {
    let mut scene = Scene::two_circles();
    scene.params.threads = 2;
    if from_rest {
        (scene.params.admm.ao_momentum, scene.params.admm.nested) = (0.0, false);
    }
    let solved = with_threads(2, |exec| scene.solve::<f64, D2>(exec, &mut Silent));
    let total = solved.objective.iter().sum::<f64>();
    println!(
        "circle to two circles, from rest {from_rest}: {:?} after {} iterations, J = {total:.4}",
        solved.status,
        solved.history.len()
    );
    assert_eq!(solved.status, Status::Converged);
    assert!(
        solved.history.len() < 25 && total < 2.7,
        "{} iterations to J = {total}",
        solved.history.len()
    );
    (scene, solved)
}

/// The last value of a fact that an iteration tells.
fn fact(progress: &Progress, name: &str) -> f64 {
    progress.report.get(name).unwrap()
}

#[test]
fn circle_to_two_circles() {
    let (scene, solved) = two_circles(true);
    check(&scene, &solved, f64::EPSILON);
    let last = solved.history.last().unwrap();
    assert!(
        fact(last, "density_change") < 0.01 && fact(last, "gap") <= 0.01 && fact(last, "ao_step") >= 0.125
    );
    assert!((last.objective.data - fact(last, "data_of_star")).abs() <= 0.05 * fact(last, "data_of_star"));
    for progress in &solved.history {
        assert!(
            fact(progress, "nso_residuals") < 1e-5,
            "iteration {}: NSO did not reach its tolerance",
            progress.iteration
        );
    }
}

#[test]
fn the_defaults_end_as_low() {
    two_circles(false);
}

/// A ball that does not overlap with its keyframe, in a box of which no grid halves exactly: a start on a coarser grid finds the way.
#[test]
fn odd_boxes_begin_on_coarser_grids_too() {
    let [from_rest, nested] = [false, true].map(|nested| {
        let small = Scene::small(&[37, 29], "wp", 10);
        let grid = grid(&small.cells, "wp");
        let mut scene = Scene {
            densities: [12.0, 24.0]
                .map(|x| balls(&grid, &[[x / 37.0, 14.0 / 37.0, 0.5]], 5.0 / 37.0))
                .to_vec(),
            force_weight: 1e3,
            params: Params {
                iterations: 6,
                ..admm()
            },
            ..small
        };
        scene.params.admm.nested = nested;
        let solved = scene.solve_alone::<f64, D2>();
        check(&scene, &solved, f64::EPSILON);
        solved.objective.iter().sum::<f64>()
    });
    println!("37 x 29 from rest: J = {from_rest:.4}, from a coarser grid {nested:.4}");
    assert!(nested < 0.6 * from_rest, "{nested} and {from_rest}");
}

fn feasible<T: Real, S: Space>(cells: &[usize], ends: &str, scheme: Scheme) {
    let mut scene = Scene {
        scheme,
        ..Scene::small(cells, ends, 5)
    };
    scene.keyframes = vec![3, 5];
    scene.densities.push(scene.densities[0].clone());
    let solved = scene.solve_alone::<T, S>();
    assert_eq!((solved.status, solved.history.len()), (Status::MaxIterations, 3));
    check(&scene, &solved, T::EPSILON);
    let (first, last) = (
        solved.history[0].objective.total(),
        solved.objective.iter().sum::<f64>(),
    );
    assert!(
        last < first,
        "{cells:?} {ends}: the objective rose from {first} to {last}"
    );
}

#[test]
fn results_are_feasible() {
    feasible::<f32, D2>(&[16, 16], "ww", Scheme::Quick);
    feasible::<f64, D2>(&[17, 11], "wp", Scheme::Central);
    feasible::<f32, D2>(&[10, 13], "pp", Scheme::Quick);
    feasible::<f32, D3>(&[8, 7, 9], "www", Scheme::Quick);
    feasible::<f64, D3>(&[9, 8, 6], "pwp", Scheme::Central);
}

#[test]
fn other_units_give_the_same_iterates() {
    let scene = Scene {
        scheme: Scheme::Quick,
        viscosity: 2e-3,
        ..Scene::small(&[14, 12], "ww", 6)
    };
    let solved = scene.solve_alone::<f64, D2>();
    for (dt, length, exact) in [(1.0 / 16.0, 8.0, true), (1.0 / 24.0, 10.0, false)] {
        let mut other = scene.clone();
        (other.dt, other.length) = (dt, length);
        let ratio = length / dt;
        other.force_weight = scene.force_weight * (dt * dt / length).powi(2);
        other.viscosity = scene.viscosity * length * length / dt;
        other.params.admm.penalty = scene.params.admm.penalty / (ratio * ratio);
        let found = other.solve_alone::<f64, D2>();
        check(&other, &found, f64::EPSILON);
        let tolerance = if exact { 0.0 } else { 1e-9 };
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
        assert_close(
            "J",
            found.objective.iter().sum(),
            solved.objective.iter().sum(),
            solved.objective[0],
            tolerance,
        );
    }
}

#[test]
fn a_given_velocity_is_projected_and_kept() {
    let scene = Scene::small(&[12, 10], "wp", 4);
    let grid = grid(&scene.cells, "wp");
    let v0: Components<f64> = Random::new(81)
        .faces(&grid, 1)
        .map(|c| c.iter().map(|x: &f64| 0.02 * x).collect());
    let solved = scene.with::<f64, D2, _>(|solver| {
        let mut file = vec![0.5; solver.faces(0)];
        places(&grid)
            .filter(|at| at[0] > 0)
            .for_each(|[x, y, _]| file[y * 13 + x] = v0[0][y * 12 + x]);
        solver.set_initial_velocity(0, &file).unwrap();
        solver.set_initial_velocity(1, &v0[1]).unwrap();
        let change = solver.prepare(&thurible_core::Serial).unwrap();
        assert!(
            change > 0.1 && change < 2.0,
            "a random velocity changes by {change}"
        );
        assert_eq!(solver.prepare(&thurible_core::Serial).unwrap(), change);
        Solved::run(&scene, solver, &thurible_core::Serial, &mut Silent)
    });
    check(&scene, &solved, f64::EPSILON);
    let kept = fields::feasible::faces(&grid, &solved.velocity[0]);
    let lost = add_scaled_all(&v0, -1.0, &kept);
    assert_close(
        "v_0 is projected",
        fields::dot_all(&kept, &lost),
        0.0,
        fields::dot_all(&v0, &v0),
        1e-5,
    );
    assert!(largest_of(&kept) > 0.001);
}

/// Large r: NSO must reach its tolerance, by damping if it must, and never give up numbers.
#[test]
fn expensive_forces() {
    for force_weight in [1e4, 1e6] {
        let scene = Scene {
            force_weight,
            params: Params {
                iterations: 4,
                ..admm()
            },
            ..Scene::two_circles()
        };
        let solved = scene.solve_alone::<f32, D2>();
        assert!(
            solved.status == Status::MaxIterations || solved.status == Status::Converged,
            "{:?}",
            solved.status
        );
        for progress in &solved.history {
            let list = progress.report.series("nso_residuals");
            assert!(
                *list.last().unwrap() < 1e-5,
                "r = {force_weight:e}, iteration {}: {list:?}",
                progress.iteration
            );
        }
        check(&scene, &solved, f64::from(f32::EPSILON));
    }
}

/// Both solvers of NSO end at the same flow, whatever kappa = K / r.
#[test]
fn newton_agrees_with_stfas() {
    for penalty in [1e4, 1e3, 1e2] {
        let mut scene = Scene {
            params: Params {
                iterations: 3,
                ..admm()
            },
            ..Scene::two_circles()
        };
        (scene.params.admm.penalty, scene.params.admm.nested) = (penalty, false);
        scene.params.admm.nso.tolerance = 1e-6;
        let stfas = scene.solve_alone::<f64, D2>();
        scene.params.admm.nso.solver = NsoSolver::NewtonCg;
        let newton = scene.solve_alone::<f64, D2>();
        check(&scene, &newton, f64::EPSILON);
        for solved in [&stfas, &newton] {
            for progress in &solved.history {
                let list = progress.report.series("nso_residuals");
                assert!(
                    *list.last().unwrap() < 1e-6,
                    "K = {penalty:e}, iteration {}: {list:?}",
                    progress.iteration
                );
            }
        }
        for (by_stfas, by_newton) in stfas.history.iter().zip(&newton.history) {
            let (x, y) = (by_stfas.objective.total(), by_newton.objective.total());
            assert_close("J", y, x, x, 1e-3);
            let list = by_newton.report.series("nso_residuals");
            assert!(list.len() < 12, "K = {penalty:e}: {list:?}");
        }
    }
}

#[test]
fn newton_in_space_and_on_any_box() {
    let mut scene = Scene::small(&[9, 8, 6], "pwp", 4);
    scene.params.admm.nso.solver = NsoSolver::NewtonCg;
    for progress in &scene.solve_alone::<f32, D3>().history {
        assert!(
            fact(progress, "nso_residuals") < 1e-5,
            "{:?}",
            progress.report.series("nso_residuals")
        );
    }
}

/// With buoyancy AO and NSO meet where the direct method does: J is a function of the flow whose gradient both halves share.
#[test]
fn buoyancy_ends_where_the_direct_method_does() {
    let mut scene = Scene::small(&[20, 20], "ww", 8);
    scene.force_weight = 1e3;
    scene.effects.buoyancy[1] = 8e-3;
    (scene.params.iterations, scene.params.admm.ao_iterations) = (120, 4);
    (scene.params.admm.penalty, scene.params.admm.density_tolerance) = (5e2, 1e-4);
    let mut direct = scene.clone();
    (direct.params.method, direct.params.iterations) = (Method::Direct, 300);
    direct.params.direct.tolerance = 1e-6;
    let [admm, least] = [&scene, &direct].map(|scene| {
        let solved = scene.solve_alone::<f64, D2>();
        check(scene, &solved, f64::EPSILON);
        solved.objective.iter().sum::<f64>()
    });
    let mut still = direct.clone();
    still.effects.buoyancy = [0.0; 3];
    let without: f64 = still.solve_alone::<f64, D2>().objective.iter().sum();
    assert!(
        (least - without).abs() > 0.05 * least,
        "buoyancy does not matter: {without} without, {least} with"
    );
    assert!(
        admm < 1.01 * least,
        "J = {admm} by ADMM, {least} by the direct method"
    );
}

/// Around a plate both solvers of the Navier-Stokes problem find the same flow, and the violation of the conditions falls.
#[test]
fn a_plate_in_the_way() {
    let mut scene = Scene::small(&[24, 21], "wp", 8).among_solids();
    (scene.params.iterations, scene.force_weight) = (12, 1e3);
    let solved = scene.solve_alone::<f64, D2>();
    let kkt = |progress: &Progress| fact(progress, "kkt");
    let [first, last] =
        [solved.history.first(), solved.history.last()].map(|progress| kkt(progress.unwrap()));
    assert!(last < 0.5 * first, "{last:e} after {first:e}");
    for progress in &solved.history {
        assert!(fact(progress, "nso_residuals") < 1e-5);
        assert!(progress.report.series("nso_residuals").len() <= 4, "cycles");
    }
    scene.params.admm.nso.solver = NsoSolver::NewtonCg;
    let newton = scene.solve_alone::<f64, D2>();
    let [one, two] = [&solved, &newton].map(|solved| solved.objective.iter().sum::<f64>());
    assert!(
        (one - two).abs() < 0.02 * one,
        "{one} by STFAS, {two} by Newton-CG"
    );
}
