//! What threads take of a process's addresses, where those are limited (`ulimit -v`): refused before one is started, since a thread
//! that finds no room for its allocations ends the program.

use crate::bytes::{grouped, rounded};
use crate::exit::Failure;
use std::fs;

/// Addresses that a thread takes beside its share of the block: glibc gives it 64 MiB to allocate from, Rust a stack of 2 MiB.
pub const OF_A_THREAD: usize = 68 << 20;

/// Addresses that `threads` threads take; glibc needs room once more to begin an allocator's part on a multiple of its size.
pub const fn of_threads(threads: usize) -> usize {
    if threads > 1 {
        OF_A_THREAD.saturating_mul(threads.saturating_add(1))
    } else {
        0
    }
}

/// Refuses `threads` threads for which there are not the addresses.
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

/// Addresses that this process may still take, or `None` where they are not limited or the system does not tell.
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
