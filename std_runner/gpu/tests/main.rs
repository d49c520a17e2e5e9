//! Searches on a device beside those of the core: on the software adapter where there is no card.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a test says what went wrong by panicking"
)]

mod verbs;

use core::mem::MaybeUninit;
use std::sync::{Mutex, MutexGuard, OnceLock, PoisonError};
use thurible_core::exec::Together;
use thurible_core::solver::room;
use thurible_core::{
    Boundary, D2, D3, Exec, HistoryPrecision, Params, Plan, Problem, Scheme, Serial, Silent, Solver, Space,
    Status,
};
use thurible_gpu::{Bounds, Gpu, adapters};

/// The device of all tests, a card or the program that plays one, for one of them at a time.
fn device() -> MutexGuard<'static, Gpu> {
    static DEVICE: OnceLock<Mutex<Gpu>> = OnceLock::new();
    let device = DEVICE.get_or_init(|| {
        let all = adapters();
        let first = all
            .first()
            .expect("no Vulkan device: install mesa-vulkan-drivers");
        println!("on {}", first.name);
        Mutex::new(first.open(None).unwrap())
    });
    device.lock().unwrap_or_else(PoisonError::into_inner)
}

/// How a search ended: its objective, data and force, its iterations on the finest grid, and the last density.
struct Ended {
    parts: [f64; 2],
    iterations: usize,
    first: f64,
    status: Status,
}

fn ball(cells: &[usize], centre: [f64; 3], radius: f64) -> Vec<f32> {
    let most = *cells.iter().max().unwrap() as f64;
    let n = |axis: usize| cells.get(axis).copied().unwrap_or(1);
    let mut field = Vec::new();
    for z in 0..n(2) {
        for y in 0..n(1) {
            for x in 0..n(0) {
                let at = [x, y, z].map(|i| (i as f64 + 0.5) / most);
                let squares = (0..cells.len()).map(|a| (at[a] - centre[a]) * (at[a] - centre[a]));
                let distance = squares.sum::<f64>().sqrt();
                field.push((0.5 + (radius - distance) * most).clamp(0.0, 1.0) as f32);
            }
        }
    }
    field
}

/// A solver of a problem, in a block that stays.
fn solver<S: Space>(problem: &Problem<'_>, params: &Params) -> Solver<'static, f32, S> {
    let plan = Plan::new::<f32, S>(problem, params).unwrap();
    let memory = vec![MaybeUninit::new(0u8); plan.bytes() + Plan::ALIGN].leak();
    let at = memory.as_ptr().align_offset(Plan::ALIGN);
    let mut solver = Solver::<f32, S>::new(problem, plan.params(), &mut memory[at..]).unwrap();
    solver
        .set_source(&ball(problem.cells, [0.4, 0.5, 0.45], 0.2))
        .unwrap();
    for index in 0..problem.keyframes.len() {
        let target = ball(problem.cells, [0.55, 0.5, 0.5], 0.2);
        solver.set_keyframe(index, &target).unwrap();
    }
    solver
}

fn search<S: Space>(exec: &dyn Exec, problem: &Problem<'_>, params: &Params) -> Ended {
    let mut solver = solver::<S>(problem, params);
    let (mut iterations, mut first) = (0, f64::NAN);
    let status = solver.solve(exec, &mut Silent, &mut |progress| {
        if iterations == 0 {
            first = progress.objective.total();
        }
        iterations += 1;
    });
    let objective = solver.objective();
    Ended {
        parts: [objective.data, objective.force],
        iterations,
        first,
        status,
    }
}

fn agree<S: Space>(problem: &Problem<'_>, params: &Params) {
    let device = device();
    let here = search::<S>(&Serial, problem, params);
    let there = search::<S>(&Together::beside(&Serial, &*device), problem, params);
    assert_eq!(device.failure(), None);
    println!(
        "{:?}: here {:?} {} {:?} first {}, there {:?} {} {:?} first {}",
        problem.cells,
        here.parts,
        here.iterations,
        here.status,
        here.first,
        there.parts,
        there.iterations,
        there.status,
        there.first
    );
    let [total, other] = [&here, &there].map(|ended| ended.parts[0] + ended.parts[1]);
    assert!((total - other).abs() <= 1e-3 * total, "{total} and {other}");
}

#[test]
fn a_search_in_2d() {
    let walls = [Boundary::Wall, Boundary::Wall];
    let problem = Problem::new(&[16, 16], &walls, &[8]);
    let mut params = Params::default();
    params.direct.nested = false;
    agree::<D2>(&problem, &params);
    agree::<D2>(&problem, &Params::default());
}

/// Three grids, half of the steps on the coarser ones, and more slots than are projected together.
#[test]
fn a_nested_search() {
    let ends = [Boundary::Periodic, Boundary::Wall];
    let problem = Problem::new(&[48, 36], &ends, &[12, 24]);
    let mut params = Params::default();
    params.direct.coarse_iterations = Some(5);
    params.iterations = 5;
    agree::<D2>(&problem, &params);
}

/// Fields in many buffers, dispatches of many rows and sums of few parts, as otherwise only the largest boxes have them.
#[test]
fn a_search_in_many_pieces() {
    let walls = [Boundary::Wall; 3];
    let problem = Problem::new(&[12, 12, 12], &walls, &[40]);
    let mut params = Params {
        iterations: 8,
        ..Params::default()
    };
    (params.direct.nested, params.direct.history) = (false, Some(2));
    let bounds = Bounds {
        buffer: 7 * 4 * 3 * 12 * 12 * 12,
        row: 5,
        partial: 2,
        ..Bounds::default()
    };
    let device = device();
    let pieces = adapters()[0].open_within(None, bounds).unwrap();
    let [whole, pieces] = [&*device, &pieces].map(|device| {
        let ended = search::<D3>(&Together::beside(&Serial, device), &problem, &params);
        assert_eq!(device.failure(), None);
        ended
    });
    assert_eq!(whole.status, pieces.status);
    assert_eq!(whole.iterations, pieces.iterations);
    for (whole, pieces) in whole.parts.iter().zip(pieces.parts) {
        assert!((whole - pieces).abs() <= 1e-3 * whole, "{whole} and {pieces}");
    }
    let [here, there] = [&search::<D3>(&Serial, &problem, &params), &pieces].map(|ended| ended.first);
    assert!((here - there).abs() <= 1e-5 * here, "{here} and {there}");
}

/// Streamed through a few frames, a search has the bits of one that is whole in the same pages.
#[test]
fn a_search_that_is_streamed() {
    let ends = [Boundary::Wall, Boundary::Periodic, Boundary::Wall];
    let problem = Problem::new(&[10, 8, 9], &ends, &[24]);
    let params = Params {
        iterations: 6,
        ..Params::default()
    };
    let steps = 3;
    let whole = Bounds {
        buffer: steps * 4 * 3 * 768,
        ..Bounds::default()
    };
    // Products of whole fields come back in parts, too.
    let streamed = Bounds {
        paged: Some(steps as usize),
        sums: 60,
        ..whole
    };
    let _one_at_a_time = device();
    let [whole, streamed] = [whole, streamed].map(|bounds| {
        let gpu = adapters()[0].open_within(None, bounds).unwrap();
        let ended = search::<D3>(&Together::beside(&Serial, &gpu), &problem, &params);
        assert_eq!(gpu.failure(), None);
        assert_eq!(gpu.streamed() > 0, bounds.paged.is_some());
        (ended.parts, ended.iterations, ended.first, ended.status)
    });
    assert_eq!(whole, streamed);
}

/// What was taken back from the device and saved goes on there with the same bits.
#[test]
fn a_search_goes_on() {
    let walls = [Boundary::Wall, Boundary::Wall];
    let problem = Problem::new(&[32, 24], &walls, &[8]);
    let mut params = Params {
        iterations: 9,
        ..Params::default()
    };
    params.direct.coarse_iterations = Some(3);
    let device = device();
    let exec = &Together::beside(&Serial, &*device);
    let mut whole = solver::<D2>(&problem, &params);
    for _ in 0..7 {
        assert_eq!(whole.step(exec, &mut Silent).status, None);
    }
    whole.fetch_all(exec);
    let mut bytes = vec![0; whole.saved_bytes()];
    whole.save(&mut bytes).unwrap();
    whole.solve(exec, &mut Silent, &mut |_| {});
    let mut other = solver::<D2>(&problem, &params);
    other.restore(&bytes).unwrap();
    other.solve(exec, &mut Silent, &mut |_| {});
    assert_eq!(device.failure(), None);
    assert_eq!(whole.objective(), other.objective());
    assert_eq!(whole.density(5), other.density(5));
    // On the processors it goes on too.
    let mut here = solver::<D2>(&problem, &params);
    here.restore(&bytes).unwrap();
    here.solve(&Serial, &mut Silent, &mut |_| {});
    let [there, here] = [other, here].map(|solver| solver.objective().total());
    assert!((there - here).abs() <= 1e-3 * here, "{there} and {here}");
}

/// A ceiling is said before anything is taken, and a search that does not fit ends in a sentence.
#[test]
fn a_ceiling_holds() {
    let walls = [Boundary::Wall, Boundary::Wall];
    let mut problem = Problem::new(&[16, 16], &walls, &[8]);
    // What comes after the release is no part of the search.
    (problem.steps, problem.release) = (12, Some(8));
    let params = Params::default();
    let plan = Plan::new::<f32, D2>(&problem, &params).unwrap();
    let needed = room(&problem, plan.params()).unwrap();
    let device = device();
    let taken = device.plan(&needed).unwrap();
    assert_eq!(taken.here, 0);
    let bytes: u64 = taken.lines.iter().map(|(_, bytes)| bytes).sum();
    let first = &adapters()[0];
    let enough = first.open(Some(bytes)).unwrap();
    assert_eq!(enough.plan(&needed), device.plan(&needed));
    search::<D2>(&Together::beside(&Serial, &enough), &problem, &params);
    assert_eq!((enough.failure(), enough.streamed()), (None, 0));
    // What does not fit is streamed, down to a few frames.
    let refused = first.open(Some(0)).unwrap().plan(&needed).unwrap_err();
    let least = refused.split("and needs ").nth(1).unwrap();
    let least: u64 = least.split(' ').next().unwrap().parse().unwrap();
    assert!(least < bytes / 2, "{least} of {bytes}");
    for most in [bytes - 1, (bytes + least) / 2, least] {
        let streams = first.open(Some(most)).unwrap();
        let taken = streams.plan(&needed).unwrap();
        let of_device: u64 = taken.lines.iter().map(|(_, bytes)| bytes).sum();
        assert!(of_device <= most && taken.here > 0, "{taken:?} under {most}");
        let ended = search::<D2>(&Together::beside(&Serial, &streams), &problem, &params);
        assert_eq!(streams.failure(), None);
        assert!(streams.streamed() > 0);
        let whole = search::<D2>(&Together::beside(&Serial, &*device), &problem, &params);
        let [total, other] = [&whole, &ended].map(|ended| ended.parts[0] + ended.parts[1]);
        assert!((total - other).abs() <= 1e-3 * total, "{total} and {other}");
    }
    let short = first.open(Some(least - 1)).unwrap();
    let refused = short.plan(&needed).unwrap_err();
    assert!(
        refused.contains(&format!("it may take {}", least - 1)),
        "{refused}"
    );
    let ended = search::<D2>(&Together::beside(&Serial, &short), &problem, &params);
    assert_eq!(short.failure(), Some(refused));
    assert_ne!(ended.status, Status::Converged);
}

/// What a device cannot do is told by a word.
#[test]
fn what_a_device_cannot_do_is_told() {
    let walls = [Boundary::Wall, Boundary::Wall];
    let mut problem = Problem::new(&[16, 16], &walls, &[8]);
    let mut params = Params::default();
    params.direct.history_precision = HistoryPrecision::Half;
    assert_eq!(room(&problem, &params), Err("pairs in half the bytes"));
    problem.advection.scheme = Scheme::Quick;
    let other = room(&problem, &Params::default());
    assert_eq!(other, Err("other advection than limited"));
}

#[test]
fn a_search_in_3d() {
    let walls = [Boundary::Wall, Boundary::Periodic, Boundary::Wall];
    let problem = Problem::new(&[8, 8, 8], &walls, &[6]);
    agree::<D3>(&problem, &Params::default());
}
