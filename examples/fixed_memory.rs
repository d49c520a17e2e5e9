//! The core with a static array as its only memory: `cargo run --release --example fixed_memory`.
//!
//! A circle of smoke moves across a box of 24 x 24 cells. Nothing but `thurible_core` takes part in the solve, which needs
//! neither an allocator nor an operating system; `std` is here only to print.
#![allow(unsafe_code, reason = "handing out the static array, once")]

use core::cell::UnsafeCell;
use core::mem::MaybeUninit;
use core::sync::atomic::{AtomicBool, Ordering};
use thurible_core::{Boundary, D2, Params, Plan, Problem, Serial, Silent, Solver, Status};

/// Cells along each side.
const SIDE: usize = 24;
/// Steps N.
const STEPS: usize = 10;
/// What the plan of [`problem`] says, rounded up.
const BYTES: usize = 1 << 20;

/// The only memory: aligned as the core wants it.
#[repr(C, align(64))]
struct Memory {
    bytes: UnsafeCell<[MaybeUninit<u8>; BYTES]>,
    taken: AtomicBool,
}

// SAFETY: `take_memory` hands the bytes to one caller only.
unsafe impl Sync for Memory {}

static MEMORY: Memory = Memory {
    bytes: UnsafeCell::new([MaybeUninit::uninit(); BYTES]),
    taken: AtomicBool::new(false),
};

/// All of [`MEMORY`], the first time.
fn take_memory() -> Option<&'static mut [MaybeUninit<u8>]> {
    if MEMORY.taken.swap(true, Ordering::AcqRel) {
        return None;
    }
    // SAFETY: `taken` was false, so this is the only reference there ever is.
    Some(unsafe { &mut *MEMORY.bytes.get() })
}

fn problem() -> Problem<'static> {
    Problem::new(&[SIDE, SIDE], &[Boundary::Wall, Boundary::Wall], &[STEPS])
}

/// A disc with an edge of about one cell, in box lengths.
fn disc(x: f32, y: f32, radius: f32) -> [f32; SIDE * SIDE] {
    core::array::from_fn(|cell| {
        let at = |i: usize| (i as f32 + 0.5) / SIDE as f32;
        let away = (at(cell % SIDE) - x).hypot(at(cell / SIDE) - y) - radius;
        (0.5 - away * SIDE as f32).clamp(0.0, 1.0)
    })
}

/// Prints a field of cells, y upwards.
fn print(density: &[f32]) {
    for row in density.chunks_exact(SIDE).rev() {
        let shade = |&d: &f32| [" ", ".", ":", "o", "#"][(d * 4.0 + 0.5).clamp(0.0, 4.0) as usize];
        println!(
            "|{}|",
            row.iter()
                .map(shade)
                .map(|shade| [shade, shade].concat())
                .collect::<String>()
        );
    }
}

fn main() -> Result<(), Box<dyn core::error::Error>> {
    let (problem, params) = (
        problem(),
        Params {
            iterations: 20,
            ..Params::default()
        },
    );
    let plan = Plan::new::<f32, D2>(&problem, &params)?;
    println!("{} of {BYTES} bytes of a static array", plan.bytes());
    let memory = take_memory().ok_or("the memory is taken")?;
    let mut solver = Solver::<f32, D2>::new(&problem, &params, memory)?;
    solver.set_source(&disc(0.35, 0.4, 0.2))?;
    solver.set_keyframe(0, &disc(0.62, 0.6, 0.2))?;
    let status = solver.solve(&Serial, &mut Silent, &mut |progress| {
        println!(
            "iteration {:2}: objective {:.3}",
            progress.iteration,
            progress.objective.total()
        );
    });
    let objective = solver.objective();
    println!(
        "{status:?}: keyframe {:.3}, force {:.3}; step {STEPS}:",
        objective.data, objective.force
    );
    print(solver.density(STEPS));
    if matches!(status, Status::NotFinite | Status::NotReady) {
        Err("no result".into())
    } else {
        Ok(())
    }
}
