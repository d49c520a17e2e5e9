//! What the benches share beyond `thurible_bench`: threads, ratios, how they stop.
#![allow(dead_code, reason = "each bench uses its own part")]

pub mod exec;
pub mod rate;

pub use exec::pool;

use thurible::exit::Failure;

/// What there is no reason to do without: a bench stops at the first surprise.
pub fn sure<R>(result: Result<R, Failure>) -> R {
    result.unwrap_or_else(|failure| {
        eprintln!("{failure}");
        std::process::exit(i32::from(failure.code()))
    })
}

/// The size as its rows are named: `64x64x64`.
pub fn size(cells: &[usize]) -> String {
    cells.iter().map(usize::to_string).collect::<Vec<_>>().join("x")
}
