//! The core's [`Exec`] on rayon: a tree of joins, which allocates nothing inside one `install`.

use crate::exit::Failure;
use core::num::NonZeroUsize;
use core::ops::Range;
use thurible_core::Exec;

/// Most threads that `--threads` may ask for.
pub const MOST: usize = 1024;

/// How many threads this machine offers.
pub fn available() -> usize {
    std::thread::available_parallelism().map_or(1, NonZeroUsize::get).min(MOST)
}

/// Tasks on the rayon pool that the caller is inside of.
#[derive(Clone, Copy, Debug)]
pub struct Pool {
    threads: usize,
}

impl Exec for Pool {
    fn threads(&self) -> usize {
        self.threads
    }

    fn run(&self, tasks: usize, task: &(dyn Fn(usize) + Sync)) {
        split(0..tasks, task);
    }
}

/// Halves the range until one task is left; rayon steals the halves.
fn split(range: Range<usize>, task: &(dyn Fn(usize) + Sync)) {
    match range.len() {
        0 => {}
        1 => task(range.start),
        count => {
            let middle = range.start + count / 2;
            rayon::join(|| split(range.start..middle, task), || split(middle..range.end, task));
        }
    }
}

/// Calls `work` on a pool of `threads` threads with the [`Exec`] that belongs to it; on one thread, in place.
pub fn with<R: Send>(threads: usize, work: impl FnOnce(&dyn Exec) -> R + Send) -> Result<R, Failure> {
    if threads <= 1 {
        // Pictures are drawn on rayon's global pool when there is no other; it must not be wider than asked for.
        // A pool that is there already (in tests) stays.
        let _ = rayon::ThreadPoolBuilder::new().num_threads(1).use_current_thread().build_global();
        return Ok(work(&thurible_core::Serial));
    }
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    let pool = pool.map_err(|error| Failure::Memory(format!("cannot start {threads} threads: {error}; ask for fewer with --threads")))?;
    Ok(pool.install(|| work(&Pool { threads })))
}

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a test")]
mod tests {
    use super::*;
    use core::sync::atomic::{AtomicUsize, Ordering};

    #[test]
    fn every_task_runs_once() {
        for threads in 1..=3 {
            let counts: Vec<AtomicUsize> = (0..101).map(|_| AtomicUsize::new(0)).collect();
            with(threads, |exec| {
                assert_eq!(exec.threads(), threads);
                exec.run(counts.len(), &|i| {
                    counts[i].fetch_add(1, Ordering::Relaxed);
                });
            })
            .unwrap();
            assert!(counts.iter().all(|count| count.load(Ordering::Relaxed) == 1));
        }
    }
}
