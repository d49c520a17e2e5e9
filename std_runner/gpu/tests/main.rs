//! Searches on a device beside those of the core: on the software adapter where there is no card.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a test says what went wrong by panicking"
)]

mod verbs;

use core::mem::MaybeUninit;
use std::sync::OnceLock;
use thurible_core::exec::Beside;
use thurible_core::{Boundary, D2, D3, Exec, Params, Plan, Problem, Serial, Silent, Solver, Space, Status};
use thurible_gpu::{Gpu, adapters};

/// The device of all tests: a card, or the program that plays one.
fn device() -> &'static Gpu {
    static DEVICE: OnceLock<Gpu> = OnceLock::new();
    DEVICE.get_or_init(|| {
        let all = adapters();
        let first = all
            .first()
            .expect("no Vulkan device: install mesa-vulkan-drivers");
        println!("on {}", first.name);
        first.open(None).unwrap()
    })
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

fn search<S: Space>(exec: &dyn Exec, problem: &Problem<'_>, params: &Params) -> Ended {
    let plan = Plan::new::<f32, S>(problem, params).unwrap();
    let mut memory = vec![MaybeUninit::<u64>::uninit(); plan.bytes() / 8 + 16];
    let bytes = memory.len() * 8;
    let start = memory.as_mut_ptr().cast::<MaybeUninit<u8>>();
    // SAFETY: bytes of the vector, which outlives the solver.
    #[allow(unsafe_code, reason = "a block of bytes of any alignment")]
    let block = unsafe { core::slice::from_raw_parts_mut(start, bytes) };
    let at = block.as_ptr().align_offset(64);
    let block = &mut block[at..];
    let mut solver = Solver::<f32, S>::new(problem, plan.params(), block).unwrap();
    solver
        .set_source(&ball(problem.cells, [0.4, 0.5, 0.45], 0.2))
        .unwrap();
    for index in 0..problem.keyframes.len() {
        let target = ball(problem.cells, [0.55, 0.5, 0.5], 0.2);
        solver.set_keyframe(index, &target).unwrap();
    }
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
    let here = search::<S>(&Serial, problem, params);
    let there = search::<S>(&Beside::new(&Serial, device()), problem, params);
    assert_eq!(device().failure(), None);
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

#[test]
fn a_search_in_3d() {
    let walls = [Boundary::Wall, Boundary::Periodic, Boundary::Wall];
    let problem = Problem::new(&[8, 8, 8], &walls, &[6]);
    agree::<D3>(&problem, &Params::default());
}
