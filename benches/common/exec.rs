//! Two threads for benches whose harness may not leave the main thread: that thread is one of the two.

use std::sync::OnceLock;
use thurible::threads::relax;
use thurible_core::exec::{Worker, WorkerPool};

/// Threads that the benches use: the two of the smallest machine we care for.
pub const THREADS: usize = 2;

/// The calling thread and others that work until the program ends.
pub fn pool() -> &'static WorkerPool<'static> {
    static WORKERS: OnceLock<[Worker; THREADS - 1]> = OnceLock::new();
    static POOL: OnceLock<WorkerPool<'_>> = OnceLock::new();
    let pool = POOL.get_or_init(|| WorkerPool::new(WORKERS.get_or_init(Default::default), relax));
    static LENT: OnceLock<()> = OnceLock::new();
    LENT.get_or_init(|| (1..THREADS).for_each(|_| drop(std::thread::spawn(|| pool.work()))));
    pool
}
