//! Threads that stay awake between pieces of work: a region of tasks begins and ends in about a microsecond.
//!
//! A sleeping thread takes longer to wake than most passes over a field of 128 x 128 cells take to run. So the threads that the
//! caller lends to [`Team::serve`] watch one number. It holds the region's count, whether tasks are still to be had, and how
//! many threads are at them; one at a time may open a region, by [`Exec::run`], and none is waited for that did not join it.
//!
//! A thread takes the task of its own number first: what it wrote in one region it finds in its cache in the next.

use super::Exec;
use core::cell::UnsafeCell;
use core::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering};

/// A thread is at the tasks.
const MEMBER: u64 = 1;
/// All members.
const MEMBERS: u64 = OPEN - 1;
/// There are tasks.
const OPEN: u64 = 1 << 31;
/// A region of tasks was opened.
const REGION: u64 = 1 << 32;

/// Tasks that threads may take by number.
const MARKED: usize = u64::BITS as usize;

/// What the members of a region share.
#[derive(Clone, Copy)]
struct Region<'a> {
    tasks: usize,
    task: &'a (dyn Fn(usize) + Sync),
}

/// An [`Exec`] on threads that the caller lends.
pub struct Team {
    threads: usize,
    relax: fn(u32),
    state: AtomicU64,
    /// Tasks below [`MARKED`] that were taken, a bit each.
    taken: AtomicU64,
    /// The next of the others.
    next: AtomicUsize,
    /// Threads that came to serve: their numbers, from 1.
    enlisted: AtomicUsize,
    region: UnsafeCell<Region<'static>>,
    dismissed: AtomicBool,
    busy: AtomicBool,
}

// SAFETY: `region` is written by the one thread that holds `busy`, while `state` is not open and has no members, and read by
// members alone, who joined by an acquiring exchange after it was opened with release.
unsafe impl Sync for Team {}

impl Team {
    /// A team of `threads` in all: the one that runs regions, and those that [`Self::serve`].
    ///
    /// `relax` is called with 0, 1, 2, .. while a thread waits: it should spin at first, then yield, and may sleep in the end.
    #[must_use]
    pub fn new(threads: usize, relax: fn(u32)) -> Self {
        let region = UnsafeCell::new(Region { tasks: 0, task: &|_| {} });
        Self {
            threads: threads.max(1),
            relax,
            state: AtomicU64::new(0),
            taken: AtomicU64::new(0),
            next: AtomicUsize::new(MARKED),
            enlisted: AtomicUsize::new(0),
            region,
            dismissed: AtomicBool::new(false),
            busy: AtomicBool::new(false),
        }
    }

    /// Works at every region until [`Self::dismiss`].
    pub fn serve(&self) {
        let own = 1 + self.enlisted.fetch_add(1, Ordering::Relaxed);
        let (mut served, mut waited) = (0, 0);
        while !self.dismissed.load(Ordering::Acquire) {
            let state = self.state.load(Ordering::Relaxed);
            if state & OPEN != 0 && state / REGION != served && state & MEMBERS < MEMBERS {
                if self.state.compare_exchange_weak(state, state + MEMBER, Ordering::Acquire, Ordering::Relaxed).is_ok() {
                    (served, waited) = (state / REGION, 0);
                    let _leave = Leave(self);
                    // SAFETY: this thread is a member now, so the region stays until it leaves.
                    let Region { tasks, task } = unsafe { *self.region.get() };
                    self.take(own, tasks, task);
                }
            } else {
                (self.relax)(waited);
                waited = waited.saturating_add(1);
            }
        }
    }

    /// Sends the threads that serve home.
    pub fn dismiss(&self) {
        self.dismissed.store(true, Ordering::Release);
    }

    /// Takes tasks until there are none, its own first.
    fn take(&self, own: usize, tasks: usize, task: &(dyn Fn(usize) + Sync)) {
        if own < tasks.min(MARKED) && self.mark(own) {
            task(own);
        }
        (0..tasks.min(MARKED)).filter(|&index| self.mark(index)).for_each(task);
        while self.next.load(Ordering::Relaxed) < tasks {
            let index = self.next.fetch_add(1, Ordering::Relaxed);
            if index < tasks {
                task(index);
            }
        }
    }

    /// Whether this call is the one that takes the task.
    fn mark(&self, index: usize) -> bool {
        let bit = 1 << index;
        self.taken.load(Ordering::Relaxed) & bit == 0 && self.taken.fetch_or(bit, Ordering::Relaxed) & bit == 0
    }
}

/// Ends a membership, also when a task panics.
struct Leave<'a>(&'a Team);

impl Drop for Leave<'_> {
    fn drop(&mut self) {
        self.0.state.fetch_sub(MEMBER, Ordering::Release);
    }
}

/// Ends a region, also when a task panics: nobody joins any more, and those who have are waited for.
struct Close<'a>(&'a Team);

impl Drop for Close<'_> {
    fn drop(&mut self) {
        let team = self.0;
        team.state.fetch_and(!OPEN, Ordering::Relaxed);
        let mut waited = 0;
        while team.state.load(Ordering::Acquire) & MEMBERS != 0 {
            (team.relax)(waited);
            waited = waited.saturating_add(1);
        }
        team.busy.store(false, Ordering::Release);
    }
}

impl Exec for Team {
    fn threads(&self) -> usize {
        self.threads
    }

    fn run(&self, tasks: usize, task: &(dyn Fn(usize) + Sync)) {
        let alone = tasks <= 1 || self.threads == 1;
        if alone || self.busy.swap(true, Ordering::Acquire) {
            return (0..tasks).for_each(task);
        }
        let _close = Close(self);
        // SAFETY: `busy` was free, so no other thread is here, and no member is left of the region before. `Close` keeps this
        // call from returning before the last member has left, so `task` outlives every use.
        unsafe { *self.region.get() = Region { tasks, task: core::mem::transmute::<&(dyn Fn(usize) + Sync), &'static (dyn Fn(usize) + Sync)>(task) } };
        self.taken.store(0, Ordering::Relaxed);
        self.next.store(MARKED, Ordering::Relaxed);
        let next = self.state.load(Ordering::Relaxed).wrapping_add(REGION);
        self.state.store(next | OPEN, Ordering::Release);
        self.take(0, tasks, task);
    }
}

impl core::fmt::Debug for Team {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("Team").field("threads", &self.threads).finish_non_exhaustive()
    }
}
