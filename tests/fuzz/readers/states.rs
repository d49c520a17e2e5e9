//! Saved solvers and the states of solves.

use super::commands::{is_known, is_resumed};
use crate::seeds::kept::with_solver;
use std::path::Path;
use thurible_core::{Serial, Silent};

pub fn saved(_: &Path, bytes: &[u8]) -> bool {
    with_solver(|solver| {
        let is_taken = solver.restore(bytes).is_ok();
        if is_taken {
            // Any numbers: it may end anywhere, but in order.
            solver.step(&Serial, &mut Silent);
            let _ = solver.finish(&Serial);
        }
        is_taken
    })
}

/// Reads it, to where memory is asked for.
pub fn state(path: &Path, _: &[u8]) -> bool {
    let states = path.parent().unwrap();
    is_known(states, &states.with_file_name("on"))
}

/// Goes on from it: the whole way.
pub fn checkpoint(path: &Path, _: &[u8]) -> bool {
    let states = path.parent().unwrap();
    let out = states.with_file_name("on");
    is_resumed(states, &out)
}
