//! Threads that stay awake between pieces of work: a region of tasks begins and ends in a quarter of a microsecond.
//!
//! A sleeping thread takes longer to wake than most passes over a field of 128 x 128 cells take to run. So the threads that the
//! caller lends to [`Team::serve`] watch one number, the region's, and each answers on its own [`Seat`]: it claims the task of its
//! own number there, and says there when it is done. What one thread writes and another reads in a region are two cache lines, and
//! what a thread wrote in one region it finds in its cache in the next.
//!
//! One thread at a time may open a region, by [`Exec::run`]. It runs the tasks of threads that have not claimed theirs by
//! then, so nobody is waited for who did not come.

use super::{Exec, Line};
use core::cell::UnsafeCell;
use core::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering};

/// Where a thread that serves says what it is at: twice the number of the last region that it came to, or was too late for, and one
/// more when it is done with it.
#[derive(Debug, Default)]
pub struct Seat(Line<AtomicU64>);

impl Seat {
    /// Claims the task of region `number` for the thread, or closes it to the thread with `done`.
    fn take(&self, number: u64, done: u64) -> bool {
        let seen = self.0.0.load(Ordering::Relaxed);
        seen < 2 * number
            && self
                .0
                .0
                .compare_exchange(seen, 2 * number + done, Ordering::Acquire, Ordering::Relaxed)
                .is_ok()
    }
}

/// What the threads of a region share.
#[derive(Clone, Copy)]
struct Region<'a> {
    tasks: usize,
    task: &'a (dyn Fn(usize) + Sync),
}

/// What is written when a region opens, and watched by the threads that serve.
struct Board {
    /// Number of the newest region.
    number: AtomicU64,
    region: UnsafeCell<Region<'static>>,
}

/// An [`Exec`] on threads that the caller lends.
pub struct Team<'a> {
    seats: &'a [Seat],
    relax: fn(u32),
    /// Threads that came to serve.
    enlisted: AtomicUsize,
    dismissed: AtomicBool,
    board: Line<Board>,
    /// The next of the tasks that are no thread's own.
    next: Line<AtomicUsize>,
    busy: Line<AtomicBool>,
}

// SAFETY: `region` is written by the one thread that holds `busy`, when every seat is closed to the region before, and read by
// threads that have claimed their task of the newest one.
unsafe impl Sync for Team<'_> {}

impl<'a> Team<'a> {
    /// A team of the thread that runs regions and as many as there are seats, which [`Self::serve`].
    ///
    /// `relax` is called with 0, 1, 2, .. while a thread waits: it should spin at first, then yield, and may sleep in the end.
    #[must_use]
    pub fn new(seats: &'a [Seat], relax: fn(u32)) -> Self {
        let region = UnsafeCell::new(Region {
            tasks: 0,
            task: &|_| {},
        });
        Self {
            seats,
            relax,
            enlisted: AtomicUsize::new(0),
            dismissed: AtomicBool::new(false),
            board: Line(Board {
                number: AtomicU64::new(0),
                region,
            }),
            next: Line(AtomicUsize::new(0)),
            busy: Line(AtomicBool::new(false)),
        }
    }

    /// Works at every region until [`Self::dismiss`]; returns at once where every seat is taken.
    pub fn serve(&self) {
        let own = self.enlisted.fetch_add(1, Ordering::Relaxed);
        let Some(seat) = self.seats.get(own) else { return };
        let mut waited = 0;
        while !self.dismissed.load(Ordering::Acquire) {
            let number = self.board.0.number.load(Ordering::Acquire);
            if seat.take(number, 0) {
                waited = 0;
                let _done = Done { seat, number };
                // SAFETY: this thread has claimed its task of the region, which stays until that is done.
                let Region { tasks, task } = unsafe { *self.board.0.region.get() };
                if own + 1 < tasks {
                    task(own + 1);
                }
                self.take_others(tasks, task);
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

    /// Takes the tasks that are no thread's own, until there are none.
    fn take_others(&self, tasks: usize, task: &(dyn Fn(usize) + Sync)) {
        while self.next.0.load(Ordering::Relaxed) < tasks {
            let index = self.next.0.fetch_add(1, Ordering::Relaxed);
            if index < tasks {
                task(index);
            }
        }
    }
}

/// Says that a thread is done with a region, also when a task panics.
struct Done<'a> {
    seat: &'a Seat,
    number: u64,
}

impl Drop for Done<'_> {
    fn drop(&mut self) {
        self.seat.0.0.store(2 * self.number + 1, Ordering::Release);
    }
}

/// Ends a region, also when a task panics: nobody comes any more, and those who have are waited for.
struct Close<'a> {
    team: &'a Team<'a>,
    number: u64,
}

impl Drop for Close<'_> {
    fn drop(&mut self) {
        let Self { team, number } = *self;
        for seat in team.seats {
            let mut waited = 0;
            while !seat.take(number, 1) && seat.0.0.load(Ordering::Acquire) <= 2 * number {
                (team.relax)(waited);
                waited = waited.saturating_add(1);
            }
        }
        team.busy.0.store(false, Ordering::Release);
    }
}

impl Exec for Team<'_> {
    fn threads(&self) -> usize {
        self.seats.len() + 1
    }

    fn run(&self, tasks: usize, task: &(dyn Fn(usize) + Sync)) {
        let alone = tasks <= 1 || self.seats.is_empty();
        if alone || self.busy.0.swap(true, Ordering::Acquire) {
            return (0..tasks).for_each(task);
        }
        let number = self.board.0.number.load(Ordering::Relaxed) + 1;
        let _close = Close { team: self, number };
        // SAFETY: `busy` was free, so no other thread is here, and every seat is closed to the region before. `Close` keeps this
        // call from returning before the last thread is done, so `task` outlives every use.
        unsafe {
            *self.board.0.region.get() = Region {
                tasks,
                task: core::mem::transmute::<&(dyn Fn(usize) + Sync), &'static (dyn Fn(usize) + Sync)>(task),
            }
        };
        self.next.0.store(self.threads(), Ordering::Relaxed);
        self.board.0.number.store(number, Ordering::Release);
        task(0);
        self.take_others(tasks, task);
        for (own, seat) in (1..tasks).zip(self.seats) {
            if seat.take(number, 1) {
                task(own);
            }
        }
    }
}

impl core::fmt::Debug for Team<'_> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("Team")
            .field("threads", &self.threads())
            .finish_non_exhaustive()
    }
}
