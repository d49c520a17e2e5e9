//! Memory: what is planned is what is carved, to the byte, and what it held before does not matter.

use crate::fields;
use crate::fields::Memory;
use crate::fields::cases::{Scene, admm};
use crate::fields::effects::knows_open_sides;
use crate::fields::random::Random;
use core::mem::MaybeUninit;
use thurible_core::nso::colours::Colours;
use thurible_core::{
    D2, D3, Entry, HistoryPrecision, Method, NsoSolver, Params, Plan, PlanError, ProblemError, Real, Sharing,
    Solver, SolverError, Space,
};

const METHODS: [Method; 7] = [
    Method::Admm,
    Method::Direct,
    Method::Lbfgs,
    Method::Pd,
    Method::Simulate,
    Method::Guide,
    Method::Templates,
];

/// A random scene that needs at most a few megabytes.
fn random_scene(random: &mut Random, dims: usize) -> Scene {
    let most = if dims == 2 { 40 } else { 13 };
    let mut cells: Vec<usize> = (0..dims).map(|_| random.between(4, most)).collect();
    // Now and then an axis that is transformed by Fourier.
    if random.between(0, 7) == 0 {
        cells = vec![4; dims];
        cells[random.between(0, dims - 1)] = random.between(257, 300);
    }
    let ends: String = (0..dims).map(|_| random.pick(&['w', 'p'])).collect();
    let steps = random.between(2, 14);
    let mut scene = Scene::small(&cells, &ends, steps);
    scene.keyframes = (2..=steps)
        .filter(|&step| step == steps || random.coin())
        .collect();
    scene.densities.truncate(1);
    scene.params.threads = random.pick(&[1, 1, 2, 3, 7]);
    scene.params.ceiling = random.pick(&[None, Some(0), Some(1 << 18), Some(1 << 24)]);
    scene.params.method = random.pick(&METHODS);
    scene.params.lbfgs.history = Some(random.between(1, 8));
    scene.params.lbfgs.nested = random.coin();
    scene.params.templates.history = random.between(1, 8);
    if scene.params.method == Method::Templates {
        scene = scene.with_templates();
    }
    if scene.params.method == Method::Simulate && random.coin() {
        scene.keyframes.clear();
        scene.densities.truncate(1);
    }
    scene.params.direct.history = random.pick(&[None, None, Some(1), Some(8)]);
    let precisions = [HistoryPrecision::Full, HistoryPrecision::Half];
    scene.params.direct.history_precision = random.pick(&precisions);
    scene.params.lbfgs.history_precision = random.pick(&precisions);
    scene.params.direct.nested = random.coin();
    scene.params.admm.relaxation = random.pick(&[1.0, 1.5]);
    scene.params.admm.nso.solver = random.pick(&[NsoSolver::Stfas, NsoSolver::Stfas, NsoSolver::NewtonCg]);
    scene.params.admm.nso.colours = random.pick(&[Colours::RedBlack, Colours::PowerOfTwo]);
    // With emitters, a mask, regions and what else there is; among solid cells; with open sides.
    let method = scene.params.method;
    if scene.keyframes == [scene.steps] && method != Method::Templates && random.coin() {
        scene = scene.with_everything();
    }
    let small = cells.iter().all(|&n| (8..100).contains(&n));
    match random.between(0, 3) {
        0 if small => scene.among_solids(),
        1 if small && knows_open_sides(method) => {
            let ends: String = (0..dims).map(|_| random.pick(&['w', 'o', 'l', 'h'])).collect();
            scene.in_open_box(&ends)
        }
        _ => scene,
    }
}

/// The bytes that a line and its children should have: the sum or the maximum of its children.
fn check_ledger(entries: &[Entry]) {
    for (i, entry) in entries.iter().enumerate() {
        assert!(entry.bytes.is_multiple_of(Plan::ALIGN), "{entry:?}");
        let below = entries[i + 1..]
            .iter()
            .take_while(|below| below.depth > entry.depth);
        let children: Vec<usize> = below
            .filter(|below| below.depth == entry.depth + 1)
            .map(|below| below.bytes)
            .collect();
        match entry.sharing {
            Sharing::Buffer => assert!(children.is_empty(), "{entry:?}"),
            Sharing::Together => assert_eq!(entry.bytes, children.iter().sum::<usize>(), "{entry:?}"),
            Sharing::InTurn => assert_eq!(entry.bytes, children.iter().copied().max().unwrap(), "{entry:?}"),
        }
    }
}

fn planned_is_carved<T: Real, S: Space>(count: usize, seed: u64) {
    let mut random = Random::new(seed);
    let mut memory = Memory::new(1 << 25);
    for _ in 0..count {
        let scene = random_scene(&mut random, S::DIM);
        let plan = scene.plan::<T, S>();
        let top: usize = plan
            .entries()
            .iter()
            .filter(|entry| entry.depth == 0)
            .map(|entry| entry.bytes)
            .sum();
        assert_eq!(
            (plan.bytes(), plan.method_bytes()),
            (top, plan.entries()[0].bytes),
            "{scene:?}"
        );
        check_ledger(plan.entries());
        let bytes = plan.bytes();
        // A debug assertion in `Solver::new` compares what is carved with what is planned.
        assert!(
            Solver::<T, S>::new(&scene.problem(), &scene.params, &mut memory.block()[..bytes]).is_ok(),
            "{scene:?}"
        );
        assert!(
            Solver::<T, S>::new(&scene.problem(), &scene.params, &mut memory.block()[..bytes + 64]).is_ok(),
            "{scene:?}"
        );
        let short = Solver::<T, S>::new(&scene.problem(), &scene.params, &mut memory.block()[..bytes - 1])
            .map(|_| ());
        assert_eq!(
            short,
            Err(SolverError::TooSmall {
                needed: bytes,
                given: bytes - 1
            }),
            "{scene:?}"
        );
    }
}

#[test]
fn planned_is_carved_to_the_byte() {
    planned_is_carved::<f32, D2>(800, 1);
    planned_is_carved::<f64, D2>(400, 2);
    planned_is_carved::<f32, D3>(400, 3);
    planned_is_carved::<f64, D3>(200, 4);
}

#[test]
fn memory_that_is_not_aligned_is_refused() {
    let scene = Scene::small(&[5, 4], "wp", 3);
    let bytes = scene.plan::<f32, D2>().bytes();
    let mut memory = Memory::new(bytes);
    for by in 1..64 {
        let result = Solver::<f32, D2>::new(&scene.problem(), &scene.params, memory.shifted(by)).map(|_| ());
        assert_eq!(result, Err(SolverError::Misaligned), "{by} bytes off");
    }
    assert!(Solver::<f32, D2>::new(&scene.problem(), &scene.params, memory.shifted(0)).is_ok());
    assert!(Solver::<f32, D2>::new(&scene.problem(), &scene.params, &mut []).is_err());
}

#[test]
fn absurd_sizes_are_errors() {
    let absurd = [usize::MAX, usize::MAX / 2, 1 << 40, 1 << 32, 4097];
    let plan = |scene: &Scene| Plan::new::<f64, D3>(&scene.problem(), &scene.params).map(|plan| plan.bytes());
    let scene = |cells: [usize; 3], steps| Scene {
        cells: cells.to_vec(),
        steps,
        keyframes: vec![2],
        ..Scene::small(&[4, 4, 4], "www", 2)
    };
    for (n, axis) in absurd.into_iter().flat_map(|n| (0..3).map(move |axis| (n, axis))) {
        let mut cells = [8; 3];
        cells[axis] = n;
        assert_eq!(
            plan(&scene(cells, 20)),
            Err(PlanError::Problem(ProblemError::Cells { axis, given: n }))
        );
        assert_eq!(
            plan(&scene([n; 3], n)),
            Err(PlanError::Problem(ProblemError::Cells { axis: 0, given: n }))
        );
    }
    for steps in [usize::MAX, 1 << 40, 100_001] {
        assert_eq!(
            plan(&scene([8; 3], steps)),
            Err(PlanError::Problem(ProblemError::Steps { given: steps }))
        );
    }
    for threads in [0, 1025, usize::MAX] {
        let scene = Scene {
            params: Params { threads, ..admm() },
            ..scene([8; 3], 20)
        };
        assert!(matches!(
            plan(&scene),
            Err(PlanError::OutOfRange { field: "threads", .. })
        ));
    }
    // The largest problem that is not absurd: an exbibyte or TooLarge, by exact arithmetic.
    let largest = Scene {
        params: Params {
            threads: 1024,
            ..admm()
        },
        ..scene([4096; 3], 100_000)
    };
    match plan(&largest) {
        Ok(bytes) => assert!(bytes > 1 << 59 && isize::try_from(bytes).is_ok(), "{bytes}"),
        Err(error) => assert_eq!(error, PlanError::TooLarge),
    }
    let mut small = [MaybeUninit::uninit(); 4096];
    let start = small.as_ptr().align_offset(64);
    assert!(
        Solver::<f64, D3>::new(&largest.problem(), &largest.params, &mut small[start..start + 64]).is_err()
    );
}

fn rubbish_does_not_matter<T: Real, S: Space>(scene: &Scene) {
    let solve = |fill| {
        scene.with_fill::<T, S, _>(fill, |solver| {
            fields::cases::Solved::run(scene, solver, &thurible_core::Serial, &mut thurible_core::Silent)
                .bits()
        })
    };
    let zeros = solve(0);
    assert!(zeros.iter().any(|&bits| bits != 0));
    for fill in [0xAA, 0xFF] {
        assert!(
            solve(fill) == zeros,
            "a block filled with {fill:#x} gives another result"
        );
    }
}

#[test]
fn what_the_memory_held_before_does_not_matter() {
    for method in METHODS {
        let by = |scene: Scene| {
            let mut scene = Scene {
                params: Params {
                    method,
                    ..scene.params
                },
                ..scene
            };
            (scene.params.lbfgs.nested, scene.params.pd.gathering) = (true, 0.01);
            scene.with_everything()
        };
        rubbish_does_not_matter::<f32, D2>(&by(Scene::small(&[12, 9], "wp", 5)));
        rubbish_does_not_matter::<f32, D2>(&by(Scene::small(&[32, 20], "wp", 5)));
        rubbish_does_not_matter::<f32, D2>(&by(Scene::small(&[290, 7], "wp", 4)));
        rubbish_does_not_matter::<f64, D3>(&by(Scene::small(&[6, 5, 7], "pww", 4)));
        rubbish_does_not_matter::<f32, D2>(&by(Scene::small(&[33, 20], "wp", 5)).among_solids());
        rubbish_does_not_matter::<f64, D3>(&by(Scene::small(&[8, 9, 8], "www", 4)).among_solids());
        if knows_open_sides(method) {
            rubbish_does_not_matter::<f32, D2>(&by(Scene::small(&[32, 20], "ww", 5)).in_open_box("oh"));
            rubbish_does_not_matter::<f64, D3>(&by(Scene::small(&[8, 9, 8], "www", 4)).in_open_box("wlo"));
        }
    }
}

/// m pairs are m + 3 fields in halves, and 2 m + 2 as they are.
#[test]
fn pairs_in_halves_take_fewer_bytes() {
    let (cells, slots) = (24 * 24, 11);
    let mut scene = Scene::small(&[24, 24], "ww", 12);
    scene.params.direct.nested = false;
    for method in [Method::Direct, Method::Lbfgs] {
        scene.params.method = method;
        for pairs in 1..=8 {
            (scene.params.direct.history, scene.params.lbfgs.history) = (Some(pairs), Some(pairs));
            let mut bytes = |precision| {
                scene.params.direct.history_precision = precision;
                scene.params.lbfgs.history_precision = precision;
                let plan = scene.plan::<f32, D2>();
                [plan.bytes(), plan.saved_bytes()]
            };
            let [full, half] = [HistoryPrecision::Full, HistoryPrecision::Half].map(&mut bytes);
            let fewer = (pairs - 1) * 2 * 4 * cells * slots;
            assert_eq!(full[0] - half[0], fewer, "{method:?}, {pairs} pairs: the block");
            assert_eq!(
                full[1] - half[1],
                fewer,
                "{method:?}, {pairs} pairs: what is saved"
            );
        }
    }
}

#[test]
fn the_history_of_the_direct_method_is_what_fits() {
    let mut scene = Scene {
        params: Params {
            method: Method::Direct,
            ..Params::default()
        },
        ..Scene::small(&[24, 24], "ww", 12)
    };
    let mut with = |history, ceiling, threads| {
        (
            scene.params.direct.history,
            scene.params.ceiling,
            scene.params.threads,
        ) = (history, ceiling, threads);
        scene.plan::<f32, D2>().bytes()
    };
    let fixed: Vec<usize> = (1..=8).map(|pairs| with(Some(pairs), None, 1)).collect();
    assert!(fixed.is_sorted_by(|a, b| a < b));
    assert_eq!(with(None, None, 1), fixed[4], "five pairs by default");
    for pairs in 1..=5 {
        assert_eq!(with(None, Some(fixed[pairs - 1]), 1), fixed[pairs - 1]);
        assert_eq!(with(None, Some(fixed[pairs - 1] - 1), 1), fixed[pairs.max(2) - 2]);
        // The pairs, and with them every bit of the result, do not depend on the threads.
        let more = with(None, Some(fixed[pairs - 1]), 3);
        assert_eq!(more, with(Some(pairs), Some(1), 3));
        assert!(
            more < with(Some(pairs), None, 3),
            "where there is memory, two threads do different works"
        );
    }
}
