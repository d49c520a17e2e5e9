//! Address space of threads, where it is limited (`ulimit -v`). Threads that would not fit are refused before one is started: a
//! thread that finds no room for its allocations ends the program.

use crate::bytes::{grouped, rounded};
use crate::exit::Failure;
use std::fs;

/// Bytes of address space of a thread: glibc reserves 64 MiB for its allocations, Rust a stack of 2 MiB.
pub const OF_A_THREAD: usize = 68 << 20;

/// Bytes of address space of `threads` threads; glibc needs the room of one more to align its reservations.
pub const fn of_threads(threads: usize) -> usize {
    if threads > 1 {
        OF_A_THREAD.saturating_mul(threads.saturating_add(1))
    } else {
        0
    }
}

/// Refuses `threads` threads if their address space exceeds what is left.
pub fn check(threads: usize) -> Result<(), Failure> {
    let needed = of_threads(threads);
    match left() {
        Some(left) if left < needed => Err(Failure::Memory(format!(
            "{threads} threads take {} bytes of addresses ({}), but only {} are left of those that `ulimit -v` allows; use --threads 1, which takes none, or raise that limit",
            grouped(needed),
            rounded(needed),
            grouped(left)
        ))),
        _ => Ok(()),
    }
}

/// Bytes of address space that this process may still take; `None` where there is no limit, or none that can be read.
fn left() -> Option<usize> {
    let limits = fs::read_to_string("/proc/self/limits").ok()?;
    let limit = limits
        .lines()
        .find_map(|line| line.strip_prefix("Max address space"))?;
    let limit: usize = limit.split_whitespace().next()?.parse().ok()?;
    let status = fs::read_to_string("/proc/self/status").ok()?;
    let size: usize = status
        .lines()
        .find_map(|line| line.strip_prefix("VmSize:"))?
        .trim()
        .strip_suffix("kB")?
        .trim()
        .parse()
        .ok()?;
    Some(limit.saturating_sub(size.saturating_mul(1024)))
}
