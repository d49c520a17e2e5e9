use super::{Exec, Padded};
use core::ops::Range;
use core::sync::atomic::{AtomicUsize, Ordering};

/// Elements to write below which a second thread costs more than it brings.
const MIN_PARALLEL: usize = 1 << 12;
/// Elements that a worker writes in one turn, at least.
pub(super) const MIN_TURN: usize = 1 << 12;
/// Parts that the rows are cut into, at most: one for each worker, and workers beyond begin by helping.
const MAX_PARTS: usize = 16;

/// Cuts `rows` rows, of each of which `row_len` elements are written, into turns of consecutive rows, and calls `task` with the index
/// of a worker and the rows of a turn until every row was in one turn.
///
/// Every worker begins with a part of its own, the same in each call, because it finds there what the last call left in its cache.
/// When that part is done it takes turns of the others' parts.
///
/// `task` should own what it captures (`move`): what it owns lies side by side on the caller's stack, and another processor fetches it
/// in few cache lines. Of what is captured by reference it fetches each a line, which shows where calls are short and many.
pub(super) fn schedule(
    exec: &dyn Exec,
    rows: usize,
    row_len: usize,
    task: impl Fn(usize, Range<usize>) + Sync,
) {
    let small = (1..MIN_PARALLEL).contains(&(row_len * rows));
    let workers = if small { 1 } else { exec.threads().max(1).min(rows) };
    let turn = if row_len == 0 {
        1
    } else {
        MIN_TURN.div_ceil(row_len)
    };
    if workers <= 1 {
        return (0..rows)
            .step_by(turn)
            .for_each(|first| task(0, first..(first + turn).min(rows)));
    }
    let parts = workers.min(MAX_PARTS);
    let begin_of = move |part: usize| rows * part / parts.max(1);
    // The first turn of a part is its worker's own and never claimed.
    let next: [Padded<AtomicUsize>; MAX_PARTS] =
        core::array::from_fn(|part| Padded(AtomicUsize::new(begin_of(part) + turn)));
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
                task(worker, first..(first + turn).min(end));
                first = claim();
            }
        }
    });
}
