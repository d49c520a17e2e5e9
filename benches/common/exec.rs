//! Two threads for benches whose harness may not leave the main thread: that thread is one of the two.

use thurible_core::Exec;

/// Threads that the benches use: the two of the smallest machine we care for.
pub const THREADS: usize = 2;

/// A tree of joins on rayon's global pool.
pub struct Joined(());

impl Joined {
    /// Makes the calling thread part of the global pool.
    pub fn new() -> Self {
        // A second call finds the pool there already.
        let _ = rayon::ThreadPoolBuilder::new().num_threads(THREADS).use_current_thread().build_global();
        Self(())
    }
}

impl Exec for Joined {
    fn threads(&self) -> usize {
        THREADS
    }

    fn run(&self, tasks: usize, task: &(dyn Fn(usize) + Sync)) {
        split(0, tasks, task);
    }
}

fn split(from: usize, to: usize, task: &(dyn Fn(usize) + Sync)) {
    match to - from {
        0 => {}
        1 => task(from),
        count => {
            let middle = from + count / 2;
            rayon::join(|| split(from, middle, task), || split(middle, to, task));
        }
    }
}
