//! Seconds of one V(2,2) cycle of STFAS in f32 on two threads, beside the machine's own machine, a triad.
//!
//! `cargo bench --bench cycle`; `-- --quick` leaves out the largest size.

mod common;

use common::{pool, size, sure};
use thurible_bench::machine::Machine;
use thurible_bench::navier_stokes::Case;
use thurible_bench::timing::best;
use thurible_core::{D2, D3, Exec, Silent, Space};

fn main() {
    let quick = std::env::args().any(|argument| argument == "--quick");
    let exec = pool();
    let machine = sure(Machine::measure(exec, quick));
    println!("{}", machine.sentence());
    println!(
        "{:<18}{:>12}{:>20}{:>34}",
        "cells, N", "s/cycle", "ns per cell, slot", "unknowns read at triad speed"
    );
    for (n, steps) in [(64, 40), (128, 40), (256, 80)] {
        report::<D2>(exec, &Case::new(&[n, n], steps, 1.0), machine.moment.triad);
    }
    let sizes: &[(usize, usize)] = if quick {
        &[(32, 30)]
    } else {
        &[(32, 30), (64, 20), (64, 60)]
    };
    for &(n, steps) in sizes {
        report::<D3>(exec, &Case::new(&[n; 3], steps, 1.0), machine.moment.triad);
    }
}

/// One row: the best of a few cycles, and how often a triad-fast pass could have read the unknowns (v, w, p, pbar) in that time.
fn report<S: Space>(exec: &dyn Exec, case: &Case, triad: f64) {
    let slots = case.steps - 1;
    let seconds = sure(case.pose::<f32, S, _>(exec, |nso| {
        best(3, || {
            let _ = nso.vcycle(exec, &mut Silent);
        })
    }));
    let passes = seconds * triad / case.state_bytes::<f32, S>() as f64;
    let work = (case.grid().cells() * slots) as f64;
    println!(
        "{:<18}{seconds:>12.4}{:>20.1}{passes:>34.1}",
        format!("{}, {}", size(&case.cells), case.steps),
        1e9 * seconds / work
    );
}
