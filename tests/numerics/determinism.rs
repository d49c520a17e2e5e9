//! The same bits for any number of threads and every instruction set.

use crate::exec::Backwards;
use crate::fields::cases::Scene;
use crate::fields::with_threads;
use std::sync::Mutex;
use thurible_core::nso::colours::Colours;
use thurible_core::simd::{Level, level, limit};
use thurible_core::{D2, D3, HistoryPrecision, Method, Params, Real, Scheme, Silent, Space};

/// The level is one for the whole process, so only one test at a time may change it.
pub static LEVEL: Mutex<()> = Mutex::new(());

/// The scene with the pairs of L-BFGS in half the bytes.
fn in_halves(mut scene: Scene) -> Scene {
    scene.params.direct.history_precision = HistoryPrecision::Half;
    scene.params.lbfgs.history_precision = HistoryPrecision::Half;
    scene
}

/// Scenes by `limited` transport are solved among solid cells.
fn in_2d() -> [Scene; 5] {
    let long = Scene::small(&[300, 9], "pw", 4);
    let wide = in_halves(Scene::small(&[37, 18], "wp", 6));
    let mut papers = Scene {
        scheme: Scheme::Central,
        ..Scene::small(&[11, 13], "pp", 5)
    };
    papers.params.admm.nso.colours = Colours::PowerOfTwo;
    let among_solids = Scene {
        scheme: Scheme::Limited,
        ..Scene::small(&[33, 20], "wp", 5)
    };
    [Scene::small(&[20, 16], "ww", 5), wide, papers, long, among_solids]
}

fn in_3d() -> [Scene; 3] {
    [
        in_halves(Scene::small(&[18, 8, 7], "wwp", 4)),
        Scene {
            scheme: Scheme::SemiLagrangian,
            ..Scene::small(&[7, 6, 9], "pww", 3)
        },
        Scene {
            scheme: Scheme::Limited,
            ..Scene::small(&[9, 8, 8], "www", 3)
        },
    ]
}

/// Scenes that begin on a coarser grid.
fn nested() -> (Scene, Scene) {
    (
        Scene::small(&[32, 20], "wp", 6),
        Scene::small(&[16, 8, 8], "www", 4),
    )
}

const METHODS: [Method; 7] = [
    Method::Admm,
    Method::Direct,
    Method::Lbfgs,
    Method::Pd,
    Method::Simulate,
    Method::Guide,
    Method::Templates,
];

/// The bits of two iterations of each method.
fn bits<T: Real, S: Space>(scene: &Scene, threads: usize) -> Vec<u64> {
    let by = |method| {
        let mut scene = Scene {
            params: Params {
                method,
                threads,
                iterations: 2,
                ..scene.params
            },
            ..scene.clone()
        };
        scene.params.pd.gathering = 0.01;
        scene.params.lbfgs.nested = scene.params.direct.nested;
        let among_solids = scene.scheme == Scheme::Limited;
        let scene = scene.with_everything();
        let scene = if among_solids { scene.among_solids() } else { scene };
        // More real threads than these would only wait for each other.
        if threads > 3 {
            return scene.solve::<T, S>(&Backwards(threads), &mut Silent).bits();
        }
        with_threads(threads, |exec| scene.solve::<T, S>(exec, &mut Silent).bits())
    };
    METHODS.map(by).concat()
}

fn threads_agree<T: Real, S: Space>(list: &[Scene]) {
    let _one_at_a_time = LEVEL.lock().unwrap();
    for scene in list {
        let alone = bits::<T, S>(scene, 1);
        for threads in [2, 3] {
            assert!(
                bits::<T, S>(scene, threads) == alone,
                "{threads} threads give other bits in {} on {:?}",
                T::NAME,
                scene.cells
            );
        }
    }
}

fn levels_agree<T: Real, S: Space>(list: &[Scene]) {
    let _one_at_a_time = LEVEL.lock().unwrap();
    let best = level();
    for scene in list {
        let at_best = bits::<T, S>(scene, 1);
        for lower in [Level::Avx2, Level::Baseline]
            .into_iter()
            .filter(|&lower| lower < best)
        {
            assert_eq!(limit(lower), lower);
            let found = bits::<T, S>(scene, 1);
            limit(best);
            let different = found.iter().zip(&at_best).filter(|(x, y)| x != y).count();
            assert_eq!(
                different,
                0,
                "{lower:?} gives other bits than {best:?} in {} on {:?}",
                T::NAME,
                scene.cells
            );
        }
    }
}

#[test]
fn threads_in_2d() {
    threads_agree::<f32, D2>(&in_2d());
    threads_agree::<f64, D2>(&in_2d());
}

#[test]
fn threads_in_3d() {
    threads_agree::<f32, D3>(&in_3d());
    threads_agree::<f64, D3>(&in_3d());
}

#[test]
fn instruction_sets_in_2d() {
    levels_agree::<f32, D2>(&in_2d());
    levels_agree::<f64, D2>(&in_2d());
}

#[test]
fn instruction_sets_in_3d() {
    levels_agree::<f32, D3>(&in_3d());
    levels_agree::<f64, D3>(&in_3d());
}

/// Threads and a ceiling change how much memory is shared, which must not decide how a solve begins.
fn starts_agree<T: Real, S: Space>(scene: &Scene) {
    let mut at_rest = scene.clone();
    (at_rest.params.admm.nested, at_rest.params.direct.nested) = (false, false);
    let alone = bits::<T, S>(scene, 1);
    assert!(
        bits::<T, S>(&at_rest, 1) != alone,
        "{:?} does not begin on a coarser grid",
        scene.cells
    );
    for (threads, ceiling) in [
        (2, None),
        (3, None),
        (16, None),
        (64, None),
        (1, Some(0)),
        (3, Some(0)),
        (64, Some(0)),
    ] {
        let mut other = Scene {
            params: Params {
                ceiling,
                ..scene.params
            },
            ..scene.clone()
        };
        other.params.direct.history = scene.params.direct.history.or(Some(5));
        other.params.lbfgs.history = scene.params.lbfgs.history.or(Some(8));
        assert!(
            bits::<T, S>(&other, threads) == alone,
            "{} on {:?}: {threads} threads, ceiling {ceiling:?}",
            T::NAME,
            scene.cells
        );
    }
}

#[test]
fn nested_starts() {
    let (plane, space) = nested();
    starts_agree::<f32, D2>(&plane);
    starts_agree::<f64, D2>(&plane);
    starts_agree::<f32, D3>(&space);
    starts_agree::<f64, D3>(&space);
    starts_agree::<f32, D2>(&in_halves(plane));
    starts_agree::<f64, D3>(&in_halves(space));
}

#[test]
fn a_solve_can_be_repeated() {
    let _one_at_a_time = LEVEL.lock().unwrap();
    let scene = Scene::small(&[10, 9], "ww", 4);
    assert!(bits::<f32, D2>(&scene, 2) == bits::<f32, D2>(&scene, 2));
}
