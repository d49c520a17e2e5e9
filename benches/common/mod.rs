//! What the benches share: a Navier-Stokes problem in memory of its own, synthetic flows, real scenes, ratios.
#![allow(dead_code, reason = "each bench uses its own part")]
#![allow(clippy::unwrap_used, reason = "a bench stops at the first surprise")]

pub mod exec;
pub mod flow;
pub mod problem;
pub mod rate;
pub mod scene;
pub mod time;

pub use exec::team;

/// `64x64x64`
pub fn size(cells: &[usize]) -> String {
    cells.iter().map(usize::to_string).collect::<Vec<_>>().join("x")
}
