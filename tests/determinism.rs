//! The same bits for any number of threads and every instruction set.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a test says what went wrong by panicking"
)]

#[path = "numerics/fields/mod.rs"]
mod fields;

use fields::cases::Scene;
use fields::with_threads;
use std::sync::Mutex;
use thurible_core::exec::{Exec, Planes, RowBuffers, Slabs, for_rows, for_rows_across, for_runs, for_slabs};
use thurible_core::nso::colours::Colours;
use thurible_core::simd::{Level, level, limit};
use thurible_core::{D2, D3, Method, Params, Real, Scheme, Silent, Space};

/// The level is one for the whole process, so only one test at a time may change it.
static LEVEL: Mutex<()> = Mutex::new(());

fn in_2d() -> [Scene; 3] {
    let wide = Scene::small(&[37, 18], "wp", 6);
    let mut papers = Scene {
        scheme: Scheme::Central,
        ..Scene::small(&[11, 13], "pp", 5)
    };
    papers.params.admm.nso.colours = Colours::PowerOfTwo;
    [Scene::small(&[20, 16], "ww", 5), wide, papers]
}

fn in_3d() -> [Scene; 2] {
    [
        Scene::small(&[18, 8, 7], "wwp", 4),
        Scene {
            scheme: Scheme::SemiLagrangian,
            ..Scene::small(&[7, 6, 9], "pww", 3)
        },
    ]
}

/// Says that there are some threads, and runs their tasks one by one from the last.
struct Backwards(usize);

impl Exec for Backwards {
    fn threads(&self) -> usize {
        self.0
    }

    fn run(&self, tasks: usize, task: &(dyn Fn(usize) + Sync)) {
        (0..tasks).rev().for_each(task);
    }
}

#[test]
fn every_row_is_visited_once() {
    const ROWS: usize = 53;
    let visits = |exec: &dyn Exec, rows: usize, length: usize| {
        let mut field = vec![0f32; rows * length];
        for_rows(exec, rows, RowBuffers::fields([&mut field]), |task| {
            task.fields
                .into_iter()
                .flatten()
                .for_each(|x| *x += 1.0 + task.row as f32);
        });
        for (row, numbers) in field.chunks_exact(length).enumerate() {
            assert!(
                numbers.iter().all(|&x| x == 1.0 + row as f32),
                "{} threads, {rows} rows of {length} elements: row {row}",
                exec.threads()
            );
        }
    };
    let visits_in_runs = |exec: &dyn Exec, length: usize| {
        let mut field = vec![0f32; ROWS * length];
        for_runs(exec, ROWS, [&mut field], &mut [], |task| {
            let [numbers] = task.fields;
            assert_eq!(numbers.len(), task.rows.len() * length);
            for (row, numbers) in task.rows.zip(numbers.chunks_exact_mut(length)) {
                numbers.iter_mut().for_each(|x| *x += 1.0 + row as f32);
            }
        });
        for (row, numbers) in field.chunks_exact(length).enumerate() {
            assert!(
                numbers.iter().all(|&x| x == 1.0 + row as f32),
                "{} threads, runs of {length} numbers a row: row {row}",
                exec.threads()
            );
        }
    };
    let visits_in_slabs = |exec: &dyn Exec, count: usize, least: usize| {
        let (slabs, mut field) = (Slabs::new(ROWS, count, least), vec![0f32; ROWS]);
        assert!(
            (1..=count.max(1)).contains(&slabs.count())
                && (0..slabs.count()).all(|slab| slabs.rows_of(slab).len() >= least.min(ROWS))
        );
        for_slabs(exec, slabs, [&mut field], &mut [], |task| {
            let ([numbers], rows) = (task.fields, task.rows);
            assert!(rows.clone().all(|row| slabs.rows_of(slabs.slab_of(row)) == rows));
            rows.zip(numbers).for_each(|(row, x)| *x += 1.0 + row as f32);
        });
        assert!(
            field.iter().enumerate().all(|(row, &x)| x == 1.0 + row as f32),
            "{} threads, {count} slabs",
            exec.threads()
        );
    };
    // A ring of seven planes of eight rows behind one that is left out.
    let visits_across = |exec: &dyn Exec, count: usize, first: usize, length: usize| {
        let mut field = vec![0f32; 64 * length];
        let planes = Planes {
            count,
            first,
            size: 7,
            offset: 1,
        };
        for_rows_across(exec, 64, 8, planes, RowBuffers::fields([&mut field]), |task| {
            task.fields
                .into_iter()
                .flatten()
                .for_each(|x| *x += 1.0 + task.row as f32);
        });
        let expected = (0..count).map(|at| 1 + (first % 7 + at) % 7).collect::<Vec<_>>();
        for (row, numbers) in field.chunks_exact(length).enumerate() {
            let expected = if expected.contains(&(row / 8)) {
                1.0 + row as f32
            } else {
                0.0
            };
            assert!(
                numbers.iter().all(|&x| x == expected),
                "{} threads, {count} planes from {first}, rows of {length} numbers: row {row}",
                exec.threads()
            );
        }
    };
    for threads in [1, 2, 3, 16, 17, 40] {
        for length in [1, 300, 5000] {
            visits_in_runs(&Backwards(threads), length);
            with_threads(threads, |exec| (0..20).for_each(|_| visits_in_runs(exec, length)));
            for (count, first) in [(7, 0), (7, 5), (3, 6), (0, 2), (4, usize::MAX)] {
                visits_across(&Backwards(threads), count, first, length);
                with_threads(threads, |exec| visits_across(exec, count, first, length));
            }
        }
        for (count, least) in [(0, 1), (1, 1), (2 * threads, 4), (60, 1), (7, 60)] {
            visits_in_slabs(&Backwards(threads), count, least);
            with_threads(threads, |exec| {
                (0..20).for_each(|_| visits_in_slabs(exec, count, least))
            });
        }
        for rows in [ROWS, 0, 1, 26] {
            for length in [1, 300, 5000] {
                visits(&Backwards(threads), rows, length);
                with_threads(threads, |exec| (0..20).for_each(|_| visits(exec, rows, length)));
            }
        }
    }
}

/// Scenes that begin on a coarser grid.
fn nested() -> (Scene, Scene) {
    (
        Scene::small(&[32, 20], "wp", 6),
        Scene::small(&[16, 8, 8], "www", 4),
    )
}

const METHODS: [Method; 5] = [
    Method::Admm,
    Method::Direct,
    Method::Lbfgs,
    Method::Pd,
    Method::Simulate,
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
        (scene.params.simulation.buoyancy, scene.params.pd.gathering) = (1e-3, 0.01);
        scene.params.lbfgs.nested = scene.params.direct.nested;
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
}

#[test]
fn a_solve_can_be_repeated() {
    let _one_at_a_time = LEVEL.lock().unwrap();
    let scene = Scene::small(&[10, 9], "ww", 4);
    assert!(bits::<f32, D2>(&scene, 2) == bits::<f32, D2>(&scene, 2));
}
