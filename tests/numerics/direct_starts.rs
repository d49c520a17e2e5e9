//! Where the direct method begins: on coarser grids, in larger steps, from a flow that is given.

use crate::direct::{balls, direct, total};
use crate::fields;
use crate::fields::cases::{Scene, Solved};
use crate::fields::feasible::check;
use crate::fields::gap;
use crate::fields::spacetime::trajectory;
use thurible_core::objective::coarse;
use thurible_core::{D2, Serial, Silent};

#[test]
fn the_nested_start_is_ahead() {
    let far = |nested: bool| {
        let mut scene = direct(Scene::small(&[32, 32], "ww", 12));
        (scene.params.iterations, scene.params.direct.nested) = (8, nested);
        scene.densities = vec![balls([0.3, 0.3]), balls([0.7, 0.7])];
        let solved = scene.solve_alone::<f64, D2>();
        check(&scene, &solved, f64::EPSILON);
        let levels: Vec<usize> = solved.history.iter().map(|progress| progress.level).collect();
        assert_eq!(
            levels.iter().filter(|&&level| level == 0).count(),
            8,
            "{levels:?}"
        );
        assert!(
            levels.is_sorted_by(|a, b| a >= b) && levels[0] == usize::from(nested),
            "{levels:?}"
        );
        total(&solved)
    };
    let (nested, from_rest) = (far(true), far(false));
    assert!(
        nested < 0.5 * from_rest,
        "J = {nested} nested, {from_rest} from rest"
    );
}

#[test]
fn coarser_grids_take_as_many_iterations_as_are_asked_for() {
    let on_coarser = |most: Option<usize>| {
        let mut scene = direct(Scene::small(&[32, 32], "ww", 12));
        (scene.params.iterations, scene.params.direct.coarse_iterations) = (1, most);
        scene.densities = vec![balls([0.3, 0.3]), balls([0.7, 0.7])];
        let solved = scene.solve_alone::<f64, D2>();
        check(&scene, &solved, f64::EPSILON);
        solved
            .history
            .iter()
            .filter(|progress| progress.level == 1)
            .count()
    };
    assert_eq!([Some(3), Some(120), None].map(on_coarser), [3, 120, 100]);
}

/// The coarsest of two coarser grids solves the scene with nine times its weight of the force, the finest one the scene itself.
#[test]
fn force_is_dearer_on_coarser_grids() {
    let solved = |force_weight: f64, factor: f64| {
        let mut scene = direct(Scene {
            force_weight,
            ..Scene::small(&[64, 32], "ww", 6)
        });
        (scene.params.iterations, scene.params.direct.coarse_force_weight) = (3, factor);
        let solved = scene.solve_alone::<f64, D2>();
        check(&scene, &solved, f64::EPSILON);
        let coarsest = solved.history.iter().filter(|progress| progress.level == 2);
        coarsest
            .map(|progress| format!("{progress:?}"))
            .collect::<Vec<_>>()
    };
    let (dearer, nine_times) = (solved(1e2, 3.0), solved(9e2, 1.0));
    assert!(!dearer.is_empty());
    assert_eq!(dearer, nine_times);
    assert_ne!(dearer, solved(1e2, 1.0));
    // As far as single precision goes, however many grids there are.
    assert_eq!(solved(1e6, 1e-200), solved(1.0, 1.0));
}

#[test]
fn a_flow_that_is_given_goes_on_where_it_is_free() {
    let mut scene = direct(Scene {
        force_weight: 1e6,
        ..Scene::small(&[12, 10], "pw", 5)
    });
    scene.params.iterations = 30;
    let solved = scene.with::<f64, D2, _>(|solver| {
        solver.set_initial_velocity(0, &[0.01; 120]).unwrap();
        Solved::run(&scene, solver, &Serial, &mut Silent)
    });
    check(&scene, &solved, f64::EPSILON);
    // Forces are dear, so the uniform flow hardly changes.
    for v in &solved.velocity {
        assert!(v[0].iter().all(|&x| (x - 0.01).abs() < 2e-3), "{:?}", v[0]);
    }
}

/// The flow at steps twice as long is twice the displacement; on the finer grid it is the given one again.
#[test]
fn a_flow_that_is_given_passes_through_the_coarser_grids() {
    for keyframe in [6, 5] {
        let mut scene = direct(Scene {
            force_weight: 1e9,
            ..Scene::small(&[32, 20], "pw", 6)
        });
        (scene.params.iterations, scene.keyframes) = (1, vec![keyframe]);
        let solved = scene.with::<f64, D2, _>(|solver| {
            solver.set_initial_velocity(0, &[0.01; 640]).unwrap();
            Solved::run(&scene, solver, &Serial, &mut Silent)
        });
        check(&scene, &solved, f64::EPSILON);
        assert_eq!(solved.history[0].level, 1);
        for v in &solved.velocity {
            assert!(
                v[0].iter().all(|&x| (x - 0.01).abs() < 1e-4),
                "keyframe {keyframe}: {:?}",
                v[0]
            );
        }
    }
}

#[test]
fn flows_linear_in_time_are_refined_exactly() {
    let grid = fields::grid(&[4, 3], "ww");
    let (cells, few, slots) = (grid.cells(), 3, 7);
    let by_slots = |slots: usize, value: &dyn Fn(usize, usize) -> f64| -> Vec<f64> {
        let slot = |slot: usize| (0..cells).map(|face| value(slot, face)).collect();
        trajectory(&grid, &(0..slots).map(slot).collect::<Vec<_>>())
    };
    // v at time t is `t - 1/2` times a pattern, a step of length 2 from t on moves by twice v at its middle; one of length 1 by v there.
    let pattern = |face: usize| 0.3 + face as f64;
    let velocity = |middle: f64, face: usize| (middle - 0.5) * pattern(face);
    let long = by_slots(few, &|slot, face| {
        2.0 * velocity(2.0 * (slot + 1) as f64 + 1.0, face)
    });
    let initial: Vec<f64> = (0..cells).map(|face| 2.0 * velocity(1.0, face)).collect();
    let mut fine = [vec![0.0; cells * slots], vec![0.0; cells * slots]];
    let [x, y] = &mut fine;
    coarse::refine_time(
        &Serial,
        &grid,
        few,
        [&initial, &initial, &[]],
        [&long, &long, &[]],
        [x, y, &mut []],
    );
    // After the middle of the last long step the flow is constant.
    let last = 2.0 * few as f64 + 1.0;
    let expected = by_slots(slots, &|slot, face| {
        velocity(last.min((slot + 1) as f64 + 0.5), face)
    });
    for axis in &fine {
        assert!(gap(axis, &expected) < 1e-14, "{axis:?} is not {expected:?}");
    }
}
