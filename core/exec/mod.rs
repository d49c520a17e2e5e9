//! Threads as a value: the caller passes an [`Exec`], the core cuts its work into tasks that write disjoint chunks.
#![allow(unsafe_code)]

// Machines with fewer bits in an atomic number hardly have threads to lend.
#[cfg(target_has_atomic = "64")]
mod team;

mod capped;

pub use capped::Capped;
#[cfg(target_has_atomic = "64")]
pub use team::{Seat, Team};

use core::marker::PhantomData;
use core::ops::Range;
use core::sync::atomic::{AtomicUsize, Ordering};

/// Runs independent tasks, in any order and on any threads.
///
/// The core's results do not depend on the number of threads or on the order of the tasks.
pub trait Exec: Sync {
    /// How many tasks may run at the same time; thread-local scratch is planned for this many.
    fn threads(&self) -> usize;
    /// Calls `task(i)` once for every `i < tasks` and returns when all are done.
    fn run(&self, tasks: usize, task: &(dyn Fn(usize) + Sync));
}

/// A value on a cache line of its own: processors fetch lines in pairs.
#[derive(Debug, Default)]
#[repr(align(128))]
struct Line<T>(T);

/// One thread, in order.
#[derive(Clone, Copy, Debug, Default)]
pub struct Serial;

impl Exec for Serial {
    fn threads(&self) -> usize {
        1
    }

    fn run(&self, tasks: usize, task: &(dyn Fn(usize) + Sync)) {
        (0..tasks).for_each(task);
    }
}

/// A slice cut into equal chunks that tasks take by number.
struct Chunks<'a, T> {
    start: *mut T,
    count: usize,
    size: usize,
    slice: PhantomData<&'a mut [T]>,
}

// SAFETY: `get` hands every chunk to one task only (its caller promises that), so sharing the table is sending `T`s.
unsafe impl<T: Send> Sync for Chunks<'_, T> {}

impl<'a, T> Chunks<'a, T> {
    fn new(slice: &'a mut [T], count: usize) -> Self {
        let size = slice.len().checked_div(count).unwrap_or(0);
        Self {
            start: slice.as_mut_ptr(),
            count,
            size,
            slice: PhantomData,
        }
    }

    /// Chunks one after the other.
    ///
    /// # Safety
    /// No chunk may be taken twice while an earlier taking lives.
    #[inline(always)]
    unsafe fn get(&self, chunks: Range<usize>) -> &'a mut [T] {
        assert!(chunks.start <= chunks.end && chunks.end <= self.count);
        // SAFETY: `end <= count`, so the chunks lie in the slice; the caller keeps chunks disjoint.
        unsafe {
            core::slice::from_raw_parts_mut(
                self.start.add(chunks.start * self.size),
                chunks.len() * self.size,
            )
        }
    }
}

/// What a row task may write.
pub struct RowTask<'a, T, const K: usize> {
    /// The row.
    pub row: usize,
    /// The row's chunk of each field.
    pub fields: [&'a mut [T]; K],
    /// The row's sums.
    pub sums: &'a mut [f64],
    /// Scratch of the thread.
    pub scratch: &'a mut [T],
}

/// The buffers that [`for_rows`] cuts up.
pub struct RowBuffers<'a, T, const K: usize> {
    /// Fields of `rows` equal chunks each.
    pub fields: [&'a mut [T]; K],
    /// `rows` equal chunks of sums, or empty.
    pub sums: &'a mut [f64],
    /// `exec.threads()` equal chunks of scratch, or empty.
    pub scratch: &'a mut [T],
}

impl<'a, T, const K: usize> RowBuffers<'a, T, K> {
    /// Fields alone: no sums, no scratch.
    #[inline(always)]
    #[must_use]
    pub fn fields(fields: [&'a mut [T]; K]) -> Self {
        Self {
            fields,
            sums: &mut [],
            scratch: &mut [],
        }
    }

    /// As `self`, with `sums` cut into one chunk a row.
    #[inline(always)]
    #[must_use]
    pub fn with_sums(self, sums: &'a mut [f64]) -> Self {
        Self { sums, ..self }
    }

    /// As `self`, with `scratch` cut into one chunk a thread.
    #[inline(always)]
    #[must_use]
    pub fn with_scratch(self, scratch: &'a mut [T]) -> Self {
        Self { scratch, ..self }
    }
}

impl<'a, T> RowBuffers<'a, T, 0> {
    /// Sums alone, for a reduction that writes no field.
    #[inline(always)]
    #[must_use]
    pub fn sums(sums: &'a mut [f64]) -> Self {
        Self::fields([]).with_sums(sums)
    }
}

/// Numbers to write below which a second thread costs more than it brings.
const WORTH_A_THREAD: usize = 1 << 12;
/// Numbers that a thread takes at a time, at least.
const WORTH_A_TURN: usize = 1 << 12;

/// Parts of a range that workers begin with, at most.
const MOST_PARTS: usize = 16;

/// What a task of rows one after the other may write.
pub struct RunTask<'a, T, const K: usize> {
    /// The rows.
    pub rows: Range<usize>,
    /// The rows' chunks of each field.
    pub fields: [&'a mut [T]; K],
    /// Scratch of the thread.
    pub scratch: &'a mut [T],
}

/// Calls `task` for each of `rows` rows, with the row's own chunk of every field.
///
/// Reductions go through `sums`, added up by the caller in row order.
pub fn for_rows<T, const K: usize, F>(exec: &dyn Exec, rows: usize, buffers: RowBuffers<'_, T, K>, task: F)
where
    T: Send,
    F: Fn(RowTask<'_, T, K>) + Sync,
{
    // SAFETY: every number is that of its row.
    unsafe { in_order(exec, rows, 0..rows, |row| row, buffers, task) }
}

/// Planes one after the other, or around a ring of them.
#[derive(Clone, Copy, Debug)]
pub struct Planes {
    /// How many.
    pub count: usize,
    /// The first of them, as a place of the ring.
    pub first: usize,
    /// Places of the ring, at least as many as there are planes.
    pub size: usize,
    /// The plane at its first place.
    pub offset: usize,
}

impl Planes {
    /// Those of a range.
    #[must_use]
    pub fn of(range: Range<usize>) -> Self {
        Self {
            count: range.len(),
            first: 0,
            size: range.len(),
            offset: range.start,
        }
    }
}

/// As [`for_rows`], for the rows of some planes, a row of all of them after the other: so that a worker has the same rows of every plane.
///
/// # Panics
/// When a ring has fewer places than there are planes, or more than `rows` has.
pub fn for_rows_across<T, const K: usize, F>(
    exec: &dyn Exec,
    rows: usize,
    rows_per_plane: usize,
    planes: Planes,
    buffers: RowBuffers<'_, T, K>,
    task: F,
) where
    T: Send,
    F: Fn(RowTask<'_, T, K>) + Sync,
{
    let Planes {
        count,
        first,
        size,
        offset,
    } = planes;
    assert!(count <= size && offset.saturating_add(size).saturating_mul(rows_per_plane) <= rows);
    let first = first % size.max(1);
    let row_at = move |at: usize| {
        (offset + (first + at % count.max(1)) % size.max(1)) * rows_per_plane + at / count.max(1)
    };
    // SAFETY: nothing above overflows, and `count <= size`, so planes differ, and every number is that of another row.
    unsafe { in_order(exec, rows, 0..count * rows_per_plane, row_at, buffers, task) }
}

/// Calls `task` for the rows that `row_at` makes of the numbers of `range`.
///
/// # Safety
/// No row may be made of two numbers.
unsafe fn in_order<T, const K: usize, F>(
    exec: &dyn Exec,
    rows: usize,
    range: Range<usize>,
    row_at: impl Fn(usize) -> usize + Sync,
    buffers: RowBuffers<'_, T, K>,
    task: F,
) where
    T: Send,
    F: Fn(RowTask<'_, T, K>) + Sync,
{
    let a_row = buffers.fields.iter().map(|field| field.len()).sum::<usize>() / rows.max(1);
    let fields = buffers.fields.map(|field| Chunks::new(field, rows));
    let sums = Chunks::new(buffers.sums, rows);
    let scratch = Chunks::new(buffers.scratch, exec.threads().max(1));
    share_out(exec, range, a_row, move |worker, turn| {
        for row in turn.map(&row_at) {
            // SAFETY: `share_out` gives every number to one worker once, and every worker number runs once, so no chunk is shared.
            let task_of_row = unsafe {
                RowTask {
                    row,
                    fields: core::array::from_fn(|k| fields[k].get(row..row + 1)),
                    sums: sums.get(row..row + 1),
                    scratch: scratch.get(worker..worker + 1),
                }
            };
            task(task_of_row);
        }
    });
}

/// Calls `task` for the `rows` chunks of the fields, some rows after another at a time: those that a thread takes at once.
pub fn for_runs<T, const K: usize, F>(
    exec: &dyn Exec,
    rows: usize,
    fields: [&mut [T]; K],
    scratch: &mut [T],
    task: F,
) where
    T: Send,
    F: Fn(RunTask<'_, T, K>) + Sync,
{
    let a_row = fields.iter().map(|field| field.len()).sum::<usize>() / rows.max(1);
    let fields = fields.map(|field| Chunks::new(field, rows));
    let scratch = Chunks::new(scratch, exec.threads().max(1));
    share_out(exec, 0..rows, a_row, move |worker, turn| {
        // SAFETY: as in `for_rows`.
        let task_of_turn = unsafe {
            RunTask {
                fields: core::array::from_fn(|k| fields[k].get(turn.clone())),
                scratch: scratch.get(worker..worker + 1),
                rows: turn,
            }
        };
        task(task_of_turn);
    });
}

/// Rows, or planes, cut into slabs that are as thick as each other, or thicker by one.
#[derive(Clone, Copy, Debug)]
pub struct Slabs {
    rows: usize,
    count: usize,
}

impl Slabs {
    /// As many of `count` as have `least` rows each, but one at least.
    #[must_use]
    pub fn new(rows: usize, count: usize, least: usize) -> Self {
        Self {
            rows,
            count: count.min(rows / least.max(1)).max(1),
        }
    }

    /// How many there are.
    #[must_use]
    pub fn count(self) -> usize {
        self.count
    }

    /// The rows of a slab.
    #[must_use]
    pub fn rows_of(self, slab: usize) -> Range<usize> {
        let (thin, thick) = self.thickness();
        let begin_of = |slab: usize| slab * thin + slab.min(thick);
        begin_of(slab)..begin_of(slab + 1)
    }

    /// The slab that a row is in.
    #[must_use]
    pub fn slab_of(self, row: usize) -> usize {
        let (thin, thick) = self.thickness();
        let in_thick = row / thin.saturating_add(1);
        if in_thick < thick {
            in_thick
        } else {
            (row - thick) / thin.max(1)
        }
    }

    /// Rows of a thin slab, and how many are thicker by one: the first ones.
    fn thickness(self) -> (usize, usize) {
        let count = self.count.max(1);
        (self.rows / count, self.rows % count)
    }
}

/// As [`for_runs`], but each run is a slab, and a worker begins with the same ones each time.
pub fn for_slabs<T, const K: usize, F>(
    exec: &dyn Exec,
    slabs: Slabs,
    fields: [&mut [T]; K],
    scratch: &mut [T],
    task: F,
) where
    T: Send,
    F: Fn(RunTask<'_, T, K>) + Sync,
{
    let fields = fields.map(|field| Chunks::new(field, slabs.rows));
    let scratch = Chunks::new(scratch, exec.threads().max(1));
    share_out(exec, 0..slabs.count, 0, move |worker, turn| {
        for slab in turn {
            let rows = slabs.rows_of(slab);
            // SAFETY: as in `for_rows`: slabs share no rows, and nothing overflows where their number is below `count`, and `count` no more than `rows`.
            let task_of_slab = unsafe {
                RunTask {
                    fields: core::array::from_fn(|k| fields[k].get(rows.clone())),
                    scratch: scratch.get(worker..worker + 1),
                    rows,
                }
            };
            task(task_of_slab);
        }
    });
}

/// Two different works at the same time, each on one thread: the first on that which calls, if there is another.
pub fn join<'a>(exec: &dyn Exec, first: &'a mut (dyn FnMut() + Send), second: &'a mut (dyn FnMut() + Send)) {
    for_slabs(
        exec,
        Slabs::new(2, 2, 1),
        [&mut [first, second][..]],
        &mut [],
        |task| task.fields.into_iter().flatten().for_each(|work| work()),
    );
}

/// Calls `work` with the number of a worker and the rows of one of its turns until all rows of `range` are done, of each of which `a_row`
/// numbers are written.
///
/// Every worker begins with the same part of the range each time, so that it finds there what it left in its cache, and then
/// helps the others.
///
/// All that workers need lies side by side on the caller's stack, from where another processor fetches it line by line: where regions are
/// small and many, let `work` own what it captures.
fn share_out(exec: &dyn Exec, range: Range<usize>, a_row: usize, work: impl Fn(usize, Range<usize>) + Sync) {
    let small = (1..WORTH_A_THREAD).contains(&(a_row * range.len()));
    let workers = if small {
        1
    } else {
        exec.threads().max(1).min(range.len())
    };
    let turn = if a_row == 0 {
        1
    } else {
        WORTH_A_TURN.div_ceil(a_row)
    };
    if workers <= 1 {
        return range
            .clone()
            .step_by(turn)
            .for_each(|first| work(0, first..(first + turn).min(range.end)));
    }
    let parts = workers.min(MOST_PARTS);
    let begin_of = move |part: usize| range.start + range.len() * part / parts.max(1);
    // The first turn of a part is its worker's own, for which nobody asks.
    let next: [Line<AtomicUsize>; MOST_PARTS] =
        core::array::from_fn(|part| Line(AtomicUsize::new(begin_of(part) + turn)));
    let next = &next;
    exec.run(workers, &move |worker| {
        for ahead in 0..parts {
            let part = (worker + ahead) % parts;
            let end = begin_of(part + 1);
            let claim = || {
                if next[part].0.load(Ordering::Relaxed) < end {
                    next[part].0.fetch_add(turn, Ordering::Relaxed)
                } else {
                    end
                }
            };
            let mut first = if part == worker { begin_of(part) } else { claim() };
            while first < end {
                work(worker, first..(first + turn).min(end));
                first = claim();
            }
        }
    });
}
