use super::chunks::Chunks;
use super::schedule::{MIN_TURN, schedule};
use super::{Exec, RowBuffers, RunTask};
use core::ops::Range;

/// Rows, or planes, cut into slabs of equal thickness; the first ones may be thicker by one row.
#[derive(Clone, Copy, Debug)]
pub struct Slabs {
    rows: usize,
    count: usize,
}

impl Slabs {
    /// At most `count` slabs of at least `least` rows each, but always one.
    #[must_use]
    pub fn new(rows: usize, count: usize, least: usize) -> Self {
        Self {
            rows,
            count: count.min(rows / least.max(1)).max(1),
        }
    }

    /// Two for each thread of `exec`, where each has so many rows and enough to write, `row_len` elements a row: for passes that begin anew with each slab.
    #[must_use]
    pub fn among(exec: &dyn Exec, rows: usize, row_len: usize, least: usize) -> Self {
        let worth = MIN_TURN.div_ceil(row_len.max(1));
        Self::new(rows, 2 * exec.threads().max(1), least.max(worth))
    }

    /// How many slabs there are, at least one.
    #[must_use]
    pub fn count(self) -> usize {
        self.count
    }

    /// The rows of slab `slab`.
    #[must_use]
    pub fn rows_of(self, slab: usize) -> Range<usize> {
        let (thin, thick) = self.thickness();
        let begin_of = |slab: usize| slab * thin + slab.min(thick);
        begin_of(slab)..begin_of(slab + 1)
    }

    /// The slab that holds `row`.
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

    /// Rows of a thin slab, and how many slabs have one row more.
    fn thickness(self) -> (usize, usize) {
        let count = self.count.max(1);
        (self.rows / count, self.rows % count)
    }
}

/// Calls `task` once for each slab, with the slab's rows of every field and of the sums. A worker begins with the same slabs in each call.
pub fn for_slabs<T, const K: usize, F>(exec: &dyn Exec, slabs: Slabs, buffers: RowBuffers<'_, T, K>, task: F)
where
    T: Send,
    F: Fn(RunTask<'_, T, K>) + Sync,
{
    let fields = buffers.fields.map(|field| Chunks::new(field, slabs.rows));
    let sums = Chunks::new(buffers.sums, slabs.rows);
    let scratch = Chunks::new(buffers.scratch, exec.threads().max(1));
    schedule(exec, slabs.count, 0, move |worker, turn| {
        for slab in turn {
            let rows = slabs.rows_of(slab);
            // SAFETY: `schedule` gives every slab to one worker once, slabs share no rows, and every worker index runs once. Nothing in
            // `rows_of` overflows, since `slab < count <= max(rows, 1)`.
            let task_of_slab = unsafe {
                RunTask {
                    fields: core::array::from_fn(|k| fields[k].get(rows.clone())),
                    sums: sums.get(rows.clone()),
                    scratch: scratch.get(worker..worker + 1),
                    rows,
                }
            };
            task(task_of_slab);
        }
    });
}

/// Runs two different tasks at the same time and returns when both are done.
///
/// With at least two threads, `first` runs on the calling thread and `second` on another. With one, `second` runs after `first`.
pub fn join<'a>(exec: &dyn Exec, first: &'a mut (dyn FnMut() + Send), second: &'a mut (dyn FnMut() + Send)) {
    for_slabs(
        exec,
        Slabs::new(2, 2, 1),
        RowBuffers::fields([&mut [first, second][..]]),
        |slab| slab.fields.into_iter().flatten().for_each(|task| task()),
    );
}
