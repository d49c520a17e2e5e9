//! Taylor tests of the whole gradient, and its bits.

use super::case::{Scene, gradient, stir};
use crate::fields::random::Random;
use crate::fields::with_threads;
use thurible_core::reversal::repeated_steps;
use thurible_core::stable_fluids::{Adjoint, Control, Pressure, Slots};
use thurible_core::{D2, D3, Serial, Silent, Space};

/// |J(z + h d) - J(z) - h <g, d>| falls by a hundred when h falls by ten, but where a trace crosses a cell: so steps are short.
fn is_of_second_order<S: Space>(scene: &Scene) {
    scene.with::<f64, S, _>(|fluids| {
        stir(fluids);
        let (objective, slope, _) = gradient(&Serial, fluids);
        let at = fluids.unknowns().to_vec();
        let mut random = Random::new(21);
        let way: Vec<f64> = at.iter().map(|_| random.signed()).collect();
        let along: f64 = slope.iter().zip(&way).map(|(g, d)| g * d).sum();
        let mut left = |h: f64| {
            let moved = fluids.unknowns_mut();
            moved
                .iter_mut()
                .zip(&at)
                .zip(&way)
                .for_each(|((z, at), d)| *z = at + h * d);
            let there = fluids.value(&Serial, &mut Silent).unwrap();
            (there.total() - objective.total() - h * along).abs()
        };
        let orders = [[1e-3, 1e-4], [1e-4, 1e-5]].map(|[long, short]| (left(long) / left(short)).log10());
        assert!(along.abs() > 1e-9, "{along}");
        assert!(
            orders.iter().any(|&order| order > 1.8),
            "{orders:?}, slope {along}"
        );
    });
}

#[test]
fn gradients_by_every_control() {
    let all = [Control::InitialVelocity, Control::Forces, Control::Templates];
    for controls in [&all[..1], &all[1..2], &all[2..], &all[..]] {
        is_of_second_order::<D2>(&Scene::new(&[12, 10], "ww", controls));
        is_of_second_order::<D2>(&Scene::new(&[10, 12], "pw", controls));
        is_of_second_order::<D3>(&Scene::new(&[7, 6, 5], "www", controls));
        is_of_second_order::<D3>(&Scene::new(&[6, 5, 6], "wwp", controls));
    }
}

#[test]
fn gradients_through_conjugate_gradients() {
    let all = [Control::InitialVelocity, Control::Forces, Control::Templates];
    for slots in [Slots::Tape, Slots::States(2)] {
        let mut scene = Scene::new(&[10, 9], "wp", &all).kept(slots);
        scene.params.pressure = Pressure::Conjugate;
        scene.params.cg_iterations = 9;
        is_of_second_order::<D2>(&scene);
        let mut scene = Scene::new(&[6, 5, 6], "pww", &all).kept(slots);
        scene.params.pressure = Pressure::Conjugate;
        scene.params.cg_iterations = 7;
        is_of_second_order::<D3>(&scene);
    }
}

#[test]
fn a_second_solve_comes_near_where_iterations_converge() {
    let mut scene = Scene::new(&[12, 12], "ww", &[Control::InitialVelocity]);
    scene.params.pressure = Pressure::Conjugate;
    let mut gap = |iterations: usize, tolerance: f64| {
        (scene.params.cg_iterations, scene.params.cg_tolerance) = (iterations, tolerance);
        scene.params.adjoint = Adjoint::Exact;
        let (_, exact, _) = scene.with::<f64, D2, _>(|fluids| gradient(&Serial, fluids));
        scene.params.adjoint = Adjoint::SecondSolve;
        let (_, second, _) = scene.with::<f64, D2, _>(|fluids| gradient(&Serial, fluids));
        let size: f64 = exact.iter().map(|g| g * g).sum();
        let gap: f64 = exact.iter().zip(&second).map(|(a, b)| (a - b) * (a - b)).sum();
        (gap / size).sqrt()
    };
    assert!(gap(5, 0.0) > 1e-3);
    assert!(gap(400, 1e-10) < 1e-7);
}

#[test]
fn every_number_of_slots_and_threads_gives_the_same_bits() {
    let all = [Control::InitialVelocity, Control::Forces, Control::Templates];
    for pressure in [Pressure::GaussSeidel, Pressure::Conjugate] {
        let found = |slots: Slots, threads: usize| {
            let mut scene = Scene::new(&[20, 18], "wp", &all).kept(slots);
            (
                scene.params.pressure,
                scene.params.cg_iterations,
                scene.params.threads,
            ) = (pressure, 8, threads);
            scene.with::<f32, D2, _>(|fluids| {
                stir(fluids);
                with_threads(threads, |exec| gradient(exec, fluids))
            })
        };
        let (objective, slope, _) = found(Slots::Tape, 1);
        for slots in [1, 2, 3, 5] {
            let (same, other, repeated) = found(Slots::States(slots), 1);
            assert_eq!((objective, &slope), (same, &other), "{slots} slots");
            assert_eq!(repeated, repeated_steps(5, slots));
        }
        for threads in [2, 3] {
            let (same, other, _) = found(Slots::Tape, threads);
            assert_eq!((objective, &slope), (same, &other), "{threads} threads");
        }
    }
}

#[test]
fn gradients_in_3d_have_the_same_bits_too() {
    let found = |slots: Slots, threads: usize| {
        let mut scene = Scene::new(&[14, 12, 13], "wpw", &[Control::InitialVelocity]).kept(slots);
        scene.params.threads = threads;
        scene.with::<f32, D3, _>(|fluids| {
            stir(fluids);
            with_threads(threads, |exec| gradient(exec, fluids)).1
        })
    };
    let alone = found(Slots::Tape, 1);
    assert_eq!(found(Slots::States(2), 1), alone);
    assert_eq!(found(Slots::States(3), 2), alone);
    assert_eq!(found(Slots::Tape, 3), alone);
}
