//! Checkpoints: what is saved after any step goes on elsewhere with the same bits, and what is not what was saved is refused.

use crate::fields::cases::{Scene, Solved, StopAt};
use crate::fields::effects::knows_open_sides;
use crate::fields::{Memory, with_threads};
use thurible_core::{
    D2, D3, HistoryPrecision, Method, NsoSolver, Params, Progress, Real, Serial, Silent, Solver, Space,
    Status,
};

pub const METHODS: [Method; 7] = [
    Method::Admm,
    Method::Direct,
    Method::Lbfgs,
    Method::Pd,
    Method::Simulate,
    Method::Guide,
    Method::Templates,
];

pub fn by(method: Method, scene: Scene) -> Scene {
    let mut scene = Scene {
        params: Params {
            method,
            iterations: 4,
            ..scene.params
        },
        ..scene
    };
    (scene.params.lbfgs.nested, scene.params.pd.gathering) = (true, 0.01);
    scene.with_everything()
}

/// Calls `work` with a solver that has nothing yet but its solid cells.
pub fn with_empty<T: Real, S: Space, R>(
    scene: &Scene,
    fill: u8,
    work: impl FnOnce(&mut Solver<'_, T, S>) -> R,
) -> R {
    let mut memory = Memory::filled(scene.plan::<T, S>().bytes(), fill);
    let mut solver = Solver::<T, S>::new(&scene.problem(), &scene.params, memory.block()).unwrap();
    if !scene.effects.solid.is_empty() {
        solver.set_solids(&scene.effects.solid).unwrap();
    }
    work(&mut solver)
}

pub fn save<T: Real, S: Space>(solver: &mut Solver<'_, T, S>) -> Vec<u8> {
    let mut bytes = vec![0xEE; solver.saved_bytes() + 3];
    solver.save(&mut bytes).unwrap();
    assert_eq!(
        bytes.split_off(solver.saved_bytes()),
        [0xEE; 3],
        "more was written than was said"
    );
    bytes
}

/// What a solver still does: every iteration and the result, bit by bit.
pub fn rest_of<T: Real, S: Space>(
    scene: &Scene,
    solver: &mut Solver<'_, T, S>,
) -> (Vec<String>, Status, Vec<u64>) {
    let solved = Solved::run(scene, solver, &Serial, &mut Silent);
    (
        solved
            .history
            .iter()
            .map(|progress| format!("{progress:?}"))
            .collect(),
        solved.status,
        solved.bits(),
    )
}

/// What emitters added after each step.
fn emissions<T: Real, S: Space>(scene: &Scene, solver: &mut Solver<'_, T, S>) -> Vec<u64> {
    let mut bits = Vec::new();
    for step in 0..scene.steps {
        let mut out = vec![T::from_f64(f64::NAN); solver.cells()];
        solver.emission(&Serial, step, &mut out);
        bits.extend(out.iter().map(|x| x.to_f64().to_bits()));
    }
    bits
}

/// Saves after every step, and goes on from each of the bytes in another block that was planned for other threads.
fn goes_on<T: Real, S: Space>(scene: &Scene) {
    let mut saved: Vec<Vec<u8>> = Vec::new();
    let mut history: Vec<Progress> = Vec::new();
    let what = format!("{:?} in {} on {:?}", scene.params.method, T::NAME, scene.cells);
    let (whole, end, emitted) = scene.with::<T, S, _>(|solver| {
        assert_eq!(solver.saved_bytes(), scene.plan::<T, S>().saved_bytes());
        loop {
            saved.push(save(solver));
            history.push(solver.step(&Serial, &mut Silent));
            if history.last().is_some_and(|progress| progress.status.is_some()) {
                break;
            }
        }
        solver.finish(&Serial).unwrap();
        let status = history.last().and_then(|progress| progress.status).unwrap();
        let read = Solved::read(scene, solver, status, history.clone());
        (read, save(solver), emissions(scene, solver))
    });
    let said: Vec<String> = history.iter().map(|progress| format!("{progress:?}")).collect();
    let mut elsewhere = scene.clone();
    elsewhere.params.threads = 3;
    elsewhere.params.direct.history = scene.params.direct.history.or(Some(5));
    for (step, bytes) in saved.iter().enumerate() {
        let (rest, status, bits) = with_empty::<T, S, _>(&elsewhere, 0x5A, |solver| {
            solver.restore(bytes).unwrap();
            assert_eq!(
                save(solver),
                *bytes,
                "{what}: what was restored after {step} steps is saved as something else"
            );
            rest_of(scene, solver)
        });
        assert_eq!(rest, said[step..], "{what}: iterations after {step} steps");
        assert_eq!(status, whole.status);
        assert!(
            bits == whole.bits(),
            "{what}: going on after {step} steps gives other bits"
        );
    }
    with_empty::<T, S, _>(scene, 0xFF, |solver| {
        assert!(!solver.is_finished());
        solver.restore(&end).unwrap();
        assert!(solver.is_finished());
        assert!(
            Solved::read(scene, solver, whole.status, Vec::new()).bits() == whole.bits(),
            "{what}: the result is not what was saved"
        );
        assert!(
            emissions(scene, solver) == emitted,
            "{what}: what emitters added is not what they had"
        );
    });
}

#[test]
fn every_method_goes_on_with_the_same_bits() {
    for method in METHODS {
        goes_on::<f32, D2>(&by(method, Scene::small(&[14, 9], "wp", 5)));
        goes_on::<f64, D2>(&by(method, Scene::small(&[32, 20], "wp", 5)));
        goes_on::<f32, D3>(&by(method, Scene::small(&[16, 8, 8], "www", 4)));
        goes_on::<f64, D3>(&by(method, Scene::small(&[6, 5, 7], "pww", 4)));
        goes_on::<f32, D2>(&by(method, Scene::small(&[33, 20], "wp", 5)).among_solids());
        goes_on::<f64, D3>(&by(method, Scene::small(&[8, 9, 8], "www", 4)).among_solids());
        if knows_open_sides(method) {
            goes_on::<f32, D2>(&by(method, Scene::small(&[32, 20], "ww", 5)).in_open_box("oh"));
            goes_on::<f64, D3>(&by(method, Scene::small(&[8, 9, 8], "www", 4)).in_open_box("wlo"));
        }
    }
}

#[test]
fn choices_with_state_of_their_own_go_on() {
    let mut relaxed = by(Method::Admm, Scene::small(&[12, 12], "ww", 4));
    (relaxed.params.admm.relaxation, relaxed.params.admm.ao_momentum) = (1.3, 0.3);
    goes_on::<f64, D2>(&relaxed);
    let mut newton = by(Method::Admm, Scene::small(&[12, 12], "ww", 4));
    newton.params.admm.nso.solver = NsoSolver::NewtonCg;
    goes_on::<f32, D2>(&newton);
    // So large a weight of the force that STFAS damps.
    goes_on::<f64, D2>(&Scene {
        force_weight: 1e7,
        ..by(Method::Admm, Scene::small(&[12, 12], "ww", 6))
    });
    for method in METHODS {
        goes_on::<f32, D2>(&Scene {
            viscosity: 1e-3,
            ..by(method, Scene::small(&[32, 16], "ww", 4))
        });
    }
    // More iterations than pairs, so that all fields change their parts.
    let mut long = by(Method::Direct, Scene::small(&[16, 16], "ww", 4));
    (long.params.iterations, long.params.direct.tolerance) = (12, 1e-12);
    goes_on::<f32, D2>(&long);
    // As many pairs as there may be: the head has room for them.
    long.params.direct.history = Some(8);
    goes_on::<f32, D2>(&long);
    long.params.direct.history_precision = HistoryPrecision::Half;
    goes_on::<f32, D2>(&long);
    goes_on::<f64, D2>(&long);
    long.params.method = Method::Lbfgs;
    (long.params.lbfgs.history, long.params.lbfgs.tolerance) = (Some(2), 1e-12);
    goes_on::<f64, D2>(&long);
    long.params.lbfgs.history_precision = HistoryPrecision::Half;
    goes_on::<f32, D2>(&long);
}

/// The direct method saves on coarser grids too.
#[test]
fn the_scene_above_begins_on_a_coarser_grid() {
    let scene = by(Method::Direct, Scene::small(&[32, 20], "wp", 5));
    let solved = scene.solve_alone::<f64, D2>();
    assert!(solved.history[0].level > 0 && solved.history.last().unwrap().level == 0);
}

#[test]
fn a_cancelled_solve_goes_on() {
    for method in METHODS {
        let scene = by(method, Scene::small(&[32, 20], "wp", 5));
        for at in [1, 40, 90] {
            let mut stop = StopAt { at, seen: 0 };
            let (bytes, here) = scene.with::<f32, D2, _>(|solver| {
                while solver.step(&Serial, &mut stop).status.is_none() {}
                (save(solver), rest_of(&scene, solver))
            });
            let there = with_empty::<f32, D2, _>(&scene, 0x33, |solver| {
                solver.restore(&bytes).unwrap();
                rest_of(&scene, solver)
            });
            assert!(
                here == there,
                "{method:?} cancelled at event {at} goes on with other bits"
            );
        }
    }
}

#[test]
fn threads_may_change_between() {
    for method in METHODS {
        let scene = by(method, Scene::small(&[32, 20], "wp", 5));
        let mut threaded = scene.clone();
        (threaded.params.threads, threaded.params.direct.history) = (2, Some(5));
        let bytes = with_threads(2, |exec| {
            threaded.with::<f32, D2, _>(|solver| {
                solver.step(exec, &mut Silent);
                save(solver)
            })
        });
        let whole = scene.solve_alone::<f32, D2>();
        let (_, _, bits) = with_empty::<f32, D2, _>(&scene, 0x11, |solver| {
            solver.restore(&bytes).unwrap();
            rest_of(&scene, solver)
        });
        assert!(bits == whole.bits(), "{method:?}");
    }
}
