//! Milliseconds of J and of J with its gradient by Stable Fluids, f32 on one thread, from small boxes to large ones, and nanoseconds that a step
//! more takes for each cell: the difference to twice as many steps, in which what is done once, the keyframe's blur, does not count.
//!
//! `cargo bench --bench stable_fluids`, or `-- 128 40` for a square of 128 and 40 steps alone; `benches/stable_fluids.py` runs that beside the same
//! steps in JAX.

use core::mem::MaybeUninit;
use std::time::Instant;
use thurible_core::stable_fluids::Slots;
use thurible_core::{Boundary, D2, D3, Fluids, FluidsParams, FluidsPlan, Problem, Serial, Silent, Space};

/// Runs of each, of which the best counts.
const RUNS: usize = 3;

fn main() {
    // Cargo adds a word of its own.
    let sizes: Vec<usize> = std::env::args().filter_map(|word| word.parse().ok()).collect();
    if let [n, steps] = sizes[..] {
        report::<D2>(n, steps, Slots::Tape);
        return;
    }
    for (n, steps, slots) in [
        (32, 40, Slots::Tape),
        (64, 40, Slots::Tape),
        (128, 40, Slots::Tape),
        (128, 40, Slots::States(5)),
        (256, 20, Slots::Tape),
        (512, 6, Slots::Tape),
    ] {
        report::<D2>(n, steps, slots);
    }
    for (n, steps) in [(16, 20), (32, 10), (48, 6), (96, 3)] {
        report::<D3>(n, steps, Slots::Tape);
    }
}

fn report<S: Space>(n: usize, steps: usize, slots: Slots) {
    let (Some(once), Some(twice)) = (seconds::<S>(n, steps, slots), seconds::<S>(n, 2 * steps, slots)) else {
        return;
    };
    let each = |which: usize| (twice[which] - once[which]) * 1e9 / (n.pow(S::DIM as u32) * steps) as f64;
    println!(
        "{n}^{} x {steps}, {slots:?}: J {:.1} ms, {:.0} ns a cell and step; J and gradient {:.1} ms, {:.0} ns",
        S::DIM,
        1e3 * once[0],
        each(0),
        1e3 * once[1],
        each(1)
    );
}

/// The seconds of J and of its gradient, of a blob on its way to another place, with a velocity at the start.
fn seconds<S: Space>(n: usize, steps: usize, slots: Slots) -> Option<[f64; 2]> {
    let (cells, walls, keys) = (vec![n; S::DIM], vec![Boundary::Wall; S::DIM], [steps]);
    let problem = Problem::new(&cells, &walls, &keys);
    let params = FluidsParams {
        slots,
        ..FluidsParams::default()
    };
    let told = FluidsPlan::new::<f32, S>(&problem, &params).map_err(|error| error.to_string());
    let told = told.and_then(|plan| {
        let bytes = plan.bytes();
        let mut memory = vec![MaybeUninit::uninit(); bytes + FluidsPlan::ALIGN];
        let start = memory.as_ptr().align_offset(FluidsPlan::ALIGN);
        let block = memory.get_mut(start..start + bytes).unwrap_or_default();
        let fluids = Fluids::<f32, S>::new(&problem, &params, block);
        fluids
            .map(|mut fluids| measure(&mut fluids, n))
            .map_err(|error| error.to_string())
    });
    told.inspect_err(|error| println!("{n}: {error}")).ok()
}

fn measure<S: Space>(fluids: &mut Fluids<'_, f32, S>, n: usize) -> [f64; 2] {
    let blob = |middle: f64| -> Vec<f32> {
        let density = |cell: usize| {
            let [x, y] = [cell % n, cell / n % n].map(|place| (place as f64 + 0.5) / n as f64);
            (-((x - middle).powi(2) + (y - 0.5).powi(2)) / 0.02).exp() as f32
        };
        (0..fluids.cells()).map(density).collect()
    };
    let (source, keyframe) = (blob(0.3), blob(0.6));
    let given = fluids
        .set_source(&source)
        .and_then(|()| fluids.set_keyframe(0, &keyframe));
    if let Err(error) = given {
        println!("{error}");
    }
    let waves = fluids.unknowns_mut().iter_mut().enumerate();
    waves.for_each(|(index, z)| *z = 0.3 * (0.013 * index as f32).sin());
    let mut gradient = vec![0.0; fluids.unknowns().len()];
    let mut best = [f64::INFINITY; 2];
    for _ in 0..RUNS {
        let begun = Instant::now();
        let _ = fluids.value(&Serial, &mut Silent);
        let value = begun.elapsed().as_secs_f64();
        let _ = fluids.gradient(&Serial, &mut Silent, &mut gradient);
        best = [best[0].min(value), best[1].min(begun.elapsed().as_secs_f64())];
    }
    best
}
