//! Threads for the core: rayon's, kept awake as a [`WorkerPool`] during a solve.

use crate::exit::Failure;
use core::num::NonZeroUsize;
use core::time::Duration;
use std::thread;
use thurible_core::exec::{Worker, WorkerPool};
use thurible_core::{Exec, Serial};

/// Largest value of `--threads`.
pub const MOST: usize = 1024;

/// Waits of a thread between pieces of work that are a pause of the processor, 20 microseconds in all.
const SPINS: u32 = 1_000;
/// Waits, in all, before a thread sleeps: a few milliseconds.
const YIELDS: u32 = 10_000;
/// How long it sleeps at a time.
const SLEEP: Duration = Duration::from_micros(50);

/// How many threads this machine offers.
pub fn available() -> usize {
    thread::available_parallelism()
        .map_or(1, NonZeroUsize::get)
        .min(MOST)
}

/// Reads the value of `--threads`; the error says what is allowed.
pub fn parse(text: &str) -> Result<usize, String> {
    match text.parse() {
        Ok(count) if (1..=MOST).contains(&count) => Ok(count),
        _ => Err(format!(
            "found \"{text}\", allowed is a whole number from 1 to {MOST}"
        )),
    }
}

/// Calls `work` on a rayon pool of `threads` threads; on one thread, in place.
pub fn with<R: Send>(threads: usize, work: impl FnOnce() -> R + Send) -> Result<R, Failure> {
    if threads <= 1 {
        // Pictures are drawn on rayon's global pool when there is no other; it must not have more threads than `threads`.
        // In tests a global pool may exist already; it stays.
        let _ = rayon::ThreadPoolBuilder::new()
            .num_threads(1)
            .use_current_thread()
            .build_global();
        return Ok(work());
    }
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    let pool = pool.map_err(|error| {
        Failure::Memory(format!(
            "cannot start {threads} threads: {error}; ask for fewer with --threads"
        ))
    })?;
    Ok(pool.install(work))
}

/// Calls `work` with an [`Exec`] over the `threads` threads of the current rayon pool, which wait actively for work.
pub fn together<R: Send>(threads: usize, work: impl FnOnce(&dyn Exec) -> R + Send) -> R {
    if threads <= 1 {
        return work(&Serial);
    }
    let workers: Vec<Worker> = (1..threads).map(|_| Worker::default()).collect();
    let pool = WorkerPool::new(&workers, relax);
    rayon::scope(|scope| {
        for _ in &workers {
            scope.spawn(|_| pool.work());
        }
        let _shut_down = ShutDown(&pool);
        work(&pool)
    })
}

/// Shuts the pool down, also when the work panics: the scope waits for its threads.
struct ShutDown<'a>(&'a WorkerPool<'a>);

impl Drop for ShutDown<'_> {
    fn drop(&mut self) {
        self.0.shut_down();
    }
}

/// Lets a thread wait for the `count`th time in a row: it spins at first, then yields, then sleeps.
pub fn relax(count: u32) {
    match count {
        0..SPINS => core::hint::spin_loop(),
        SPINS..YIELDS => thread::yield_now(),
        _ => thread::sleep(SLEEP),
    }
}

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a test")]
mod tests {
    use super::*;
    use core::sync::atomic::{AtomicUsize, Ordering};

    #[test]
    fn every_task_runs_once() {
        for threads in 1..=5 {
            let counts: Vec<AtomicUsize> = (0..101).map(|_| AtomicUsize::new(0)).collect();
            let solve = |exec: &dyn Exec| {
                assert_eq!(exec.threads(), threads);
                for round in 1..=300 {
                    exec.run(counts.len(), &|i| {
                        counts[i].fetch_add(1, Ordering::Relaxed);
                    });
                    assert!(counts.iter().all(|count| count.load(Ordering::Relaxed) == round));
                }
            };
            with(threads, || together(threads, solve)).unwrap();
        }
    }

    #[test]
    fn tasks_may_have_tasks_of_their_own() {
        let count = AtomicUsize::new(0);
        let solve = |exec: &dyn Exec| {
            exec.run(7, &|_| {
                exec.run(5, &|_| {
                    count.fetch_add(1, Ordering::Relaxed);
                });
            });
        };
        with(3, || together(3, solve)).unwrap();
        assert_eq!(count.into_inner(), 35);
    }

    #[test]
    fn a_panic_is_handed_on() {
        let caught = std::panic::catch_unwind(|| {
            with(2, || {
                together(2, |exec: &dyn Exec| {
                    exec.run(100, &|i| assert!(i != 63, "task 63"))
                })
            })
        });
        assert!(caught.is_err());
    }
}
