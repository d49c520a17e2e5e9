//! Threads that stay awake between parallel regions: a region begins and ends in a quarter of a microsecond.
//!
//! A sleeping thread takes longer to wake than most passes over a field of 128 x 128 cells take to run. So the threads that the caller
//! lends to [`WorkerPool::work`] watch the index of the newest region, and each answers in a [`Worker`] of its own: there it claims the
//! task of its own index, and says when it is done. What one thread writes and another reads in a region are two cache lines, and what a
//! thread wrote in one region it finds in its cache in the next.
//!
//! One thread at a time may open a region, by [`Exec::run`]. It also runs the tasks of workers that have not claimed theirs by then, so
//! nobody waits for a thread that did not come.

use super::{Exec, Padded};
use core::cell::UnsafeCell;
use core::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering};

/// The state of one lent thread: twice the index of the last region that it claimed, or that was closed to it, and one more once it is
/// done there.
#[derive(Debug, Default)]
pub struct Worker(Padded<AtomicU64>);

impl Worker {
    fn state(&self) -> &AtomicU64 {
        &self.0.0
    }

    /// Claims the worker's task of a region: for the worker with `done` 0, or against it, so that it cannot come any more, with 1.
    fn claim(&self, region: u64, done: u64) -> bool {
        let seen = self.state().load(Ordering::Relaxed);
        seen < 2 * region
            && self
                .state()
                .compare_exchange(seen, 2 * region + done, Ordering::Acquire, Ordering::Relaxed)
                .is_ok()
    }
}

/// What the threads of a region share.
#[derive(Clone, Copy)]
struct Region<'a> {
    tasks: usize,
    task: &'a (dyn Fn(usize) + Sync),
}

/// What is written when a region opens, and watched by the workers.
struct Newest {
    /// Index of the newest region, from 1.
    index: AtomicU64,
    region: UnsafeCell<Region<'static>>,
}

/// An [`Exec`] on threads that the caller lends.
pub struct WorkerPool<'a> {
    workers: &'a [Worker],
    relax: fn(u32),
    /// Threads that came to work.
    joined: AtomicUsize,
    shut_down: AtomicBool,
    newest: Padded<Newest>,
    /// The next of the tasks that belong to no thread.
    next: Padded<AtomicUsize>,
    /// Whether a region is open.
    busy: Padded<AtomicBool>,
}

// SAFETY: `region` is written by the one thread that holds `busy`, when the region before is closed to every worker, and read by
// threads that have claimed their task of the newest one.
unsafe impl Sync for WorkerPool<'_> {}

impl<'a> WorkerPool<'a> {
    /// A pool of the thread that opens regions and of one lent thread for each of `workers`, which calls [`Self::work`].
    ///
    /// A thread that waits calls `relax` with 0, 1, 2, ..: it should spin at first, then yield, and may sleep in the end.
    #[must_use]
    pub fn new(workers: &'a [Worker], relax: fn(u32)) -> Self {
        let region = UnsafeCell::new(Region {
            tasks: 0,
            task: &|_| {},
        });
        Self {
            workers,
            relax,
            joined: AtomicUsize::new(0),
            shut_down: AtomicBool::new(false),
            newest: Padded(Newest {
                index: AtomicU64::new(0),
                region,
            }),
            next: Padded(AtomicUsize::new(0)),
            busy: Padded(AtomicBool::new(false)),
        }
    }

    /// Lends the calling thread to every region until [`Self::shut_down`]; returns at once where the pool has all its threads.
    pub fn work(&self) {
        let own = self.joined.fetch_add(1, Ordering::Relaxed);
        let Some(worker) = self.workers.get(own) else {
            return;
        };
        let mut waited = 0;
        while !self.shut_down.load(Ordering::Acquire) {
            let index = self.newest.0.index.load(Ordering::Acquire);
            if worker.claim(index, 0) {
                waited = 0;
                let _done = Done { worker, index };
                // SAFETY: this thread has claimed its task of the region, which stays until that is done.
                let Region { tasks, task } = unsafe { *self.newest.0.region.get() };
                if own + 1 < tasks {
                    task(own + 1);
                }
                self.run_shared(tasks, task);
            } else {
                (self.relax)(waited);
                waited = waited.saturating_add(1);
            }
        }
    }

    /// Makes every [`Self::work`] return.
    pub fn shut_down(&self) {
        self.shut_down.store(true, Ordering::Release);
    }

    /// Runs tasks that belong to no thread, until there are none left.
    fn run_shared(&self, tasks: usize, task: &(dyn Fn(usize) + Sync)) {
        while self.next.0.load(Ordering::Relaxed) < tasks {
            let index = self.next.0.fetch_add(1, Ordering::Relaxed);
            if index < tasks {
                task(index);
            }
        }
    }
}

/// Says that a worker is done with a region, also when a task panics.
struct Done<'a> {
    worker: &'a Worker,
    index: u64,
}

impl Drop for Done<'_> {
    fn drop(&mut self) {
        self.worker.state().store(2 * self.index + 1, Ordering::Release);
    }
}

/// Ends a region, also when a task panics: it is closed to workers that did not come, and those that came are waited for.
struct Close<'a> {
    pool: &'a WorkerPool<'a>,
    index: u64,
}

impl Drop for Close<'_> {
    fn drop(&mut self) {
        let Self { pool, index } = *self;
        for worker in pool.workers {
            let mut waited = 0;
            while !worker.claim(index, 1) && worker.state().load(Ordering::Acquire) <= 2 * index {
                (pool.relax)(waited);
                waited = waited.saturating_add(1);
            }
        }
        pool.busy.0.store(false, Ordering::Release);
    }
}

impl Exec for WorkerPool<'_> {
    fn threads(&self) -> usize {
        self.workers.len() + 1
    }

    fn run(&self, tasks: usize, task: &(dyn Fn(usize) + Sync)) {
        let alone = tasks <= 1 || self.workers.is_empty();
        if alone || self.busy.0.swap(true, Ordering::Acquire) {
            return (0..tasks).for_each(task);
        }
        let index = self.newest.0.index.load(Ordering::Relaxed) + 1;
        let _close = Close { pool: self, index };
        // SAFETY: `busy` was free, so no other thread is here, and the region before is closed to every worker. `Close` keeps this
        // call from returning before the last thread is done, so `task` outlives every use.
        unsafe {
            *self.newest.0.region.get() = Region {
                tasks,
                task: core::mem::transmute::<&(dyn Fn(usize) + Sync), &'static (dyn Fn(usize) + Sync)>(task),
            }
        };
        self.next.0.store(self.threads(), Ordering::Relaxed);
        self.newest.0.index.store(index, Ordering::Release);
        task(0);
        self.run_shared(tasks, task);
        for (own, worker) in (1..tasks).zip(self.workers) {
            if worker.claim(index, 1) {
                task(own);
            }
        }
    }
}

impl core::fmt::Debug for WorkerPool<'_> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("WorkerPool")
            .field("threads", &self.threads())
            .finish_non_exhaustive()
    }
}
