use super::Exec;
use super::chunks::Chunks;
use super::schedule::schedule;
use core::ops::Range;

/// What the task of one row may write.
pub struct RowTask<'a, T, const K: usize> {
    /// Index of the row.
    pub row: usize,
    /// The row's chunk of each field.
    pub fields: [&'a mut [T]; K],
    /// The row's chunk of the sums.
    pub sums: &'a mut [f64],
    /// The thread's chunk of the scratch; it holds what the last task left there.
    pub scratch: &'a mut [T],
}

/// What the task of some consecutive rows may write.
pub struct RunTask<'a, T, const K: usize> {
    /// Indices of the rows.
    pub rows: Range<usize>,
    /// The rows' chunks of each field, one after the other.
    pub fields: [&'a mut [T]; K],
    /// Those of the sums.
    pub sums: &'a mut [f64],
    /// The thread's chunk of the scratch; it holds what the last task left there.
    pub scratch: &'a mut [T],
}

/// The buffers that [`for_rows`] cuts up.
pub struct RowBuffers<'a, T, const K: usize> {
    pub(super) fields: [&'a mut [T]; K],
    pub(super) sums: &'a mut [f64],
    pub(super) scratch: &'a mut [T],
}

impl<'a, T, const K: usize> RowBuffers<'a, T, K> {
    /// Fields, each cut into one chunk a row; no sums and no scratch.
    #[inline(always)]
    #[must_use]
    pub fn fields(fields: [&'a mut [T]; K]) -> Self {
        Self {
            fields,
            sums: &mut [],
            scratch: &mut [],
        }
    }

    /// The same with `sums`, cut into one chunk a row.
    #[inline(always)]
    #[must_use]
    pub fn with_sums(self, sums: &'a mut [f64]) -> Self {
        Self { sums, ..self }
    }

    /// The same with `scratch`, cut into one chunk a thread.
    #[inline(always)]
    #[must_use]
    pub fn with_scratch(self, scratch: &'a mut [T]) -> Self {
        Self { scratch, ..self }
    }
}

impl<'a, T> RowBuffers<'a, T, 0> {
    /// Sums alone, cut into one chunk a row: for a reduction that writes no field.
    #[inline(always)]
    #[must_use]
    pub fn sums(sums: &'a mut [f64]) -> Self {
        Self::fields([]).with_sums(sums)
    }
}

/// Calls `task` for each of `rows` rows, with the row's own chunk of every field.
///
/// A reduction writes one value a row to `sums`; the caller adds them up in the order of the rows.
pub fn for_rows<T, const K: usize, F>(exec: &dyn Exec, rows: usize, buffers: RowBuffers<'_, T, K>, task: F)
where
    T: Send,
    F: Fn(RowTask<'_, T, K>) + Sync,
{
    // SAFETY: each index is its own row.
    unsafe { for_rows_at(exec, rows, rows, |index| index, buffers, task) }
}

/// Consecutive planes of a field, or of a ring of planes inside it.
#[derive(Clone, Copy, Debug)]
pub struct Planes {
    /// How many planes are visited.
    pub count: usize,
    /// Place in the ring of the first plane.
    pub first: usize,
    /// Places in the ring, at least `count`.
    pub size: usize,
    /// Plane of the field at the first place of the ring.
    pub offset: usize,
}

impl Planes {
    /// The planes of a range, without a ring.
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

/// As [`for_rows`], for the rows of some planes: the same row of all planes in turn, so that a worker keeps its rows of every plane.
///
/// # Panics
/// When a ring has fewer places than there are planes, or ends behind row `rows`.
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
    let row_at = move |index: usize| {
        let plane = offset + (first + index % count.max(1)) % size.max(1);
        plane * rows_per_plane + index / count.max(1)
    };
    // SAFETY: nothing above overflows, and `count <= size`, so planes differ, and each index is another row.
    unsafe { for_rows_at(exec, rows, count * rows_per_plane, row_at, buffers, task) }
}

/// Calls `task` for the rows `row_at(index)` of `rows`, where `index < count`.
///
/// # Safety
/// `row_at` must give a different row for every index.
unsafe fn for_rows_at<T, const K: usize, F>(
    exec: &dyn Exec,
    rows: usize,
    count: usize,
    row_at: impl Fn(usize) -> usize + Sync,
    buffers: RowBuffers<'_, T, K>,
    task: F,
) where
    T: Send,
    F: Fn(RowTask<'_, T, K>) + Sync,
{
    let row_len = len_of_row(&buffers.fields, rows);
    let fields = buffers.fields.map(|field| Chunks::new(field, rows));
    let sums = Chunks::new(buffers.sums, rows);
    let scratch = Chunks::new(buffers.scratch, exec.threads().max(1));
    schedule(exec, count, row_len, move |worker, turn| {
        for row in turn.map(&row_at) {
            // SAFETY: `schedule` gives every index to one worker once, the caller promises a different row for each, and every worker
            // index runs once, so no chunk is shared.
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

/// As [`for_rows`], but calls `task` once for all rows that a worker takes in one turn.
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
    let row_len = len_of_row(&fields, rows);
    let fields = fields.map(|field| Chunks::new(field, rows));
    let scratch = Chunks::new(scratch, exec.threads().max(1));
    schedule(exec, rows, row_len, move |worker, turn| {
        // SAFETY: `schedule` gives every row to one worker once, and every worker index runs once.
        let task_of_turn = unsafe {
            RunTask {
                fields: core::array::from_fn(|k| fields[k].get(turn.clone())),
                sums: &mut [],
                scratch: scratch.get(worker..worker + 1),
                rows: turn,
            }
        };
        task(task_of_turn);
    });
}

/// Elements of all fields together in one of `rows` rows.
fn len_of_row<T>(fields: &[&mut [T]], rows: usize) -> usize {
    fields.iter().map(|field| field.len()).sum::<usize>() / rows.max(1)
}

/// Calls `task` for every row of `values` with its index, of rows of different lengths: row r has `unit` times `begin[r]` to `begin[r + 1]`.
///
/// # Panics
/// When `begin` does not ascend, or its last row ends beyond `values`.
pub fn for_uneven<T, F>(exec: &dyn Exec, begin: &[u32], unit: usize, values: &mut [T], task: F)
where
    T: Send,
    F: Fn(usize, &mut [T]) + Sync,
{
    let count = begin.last().map_or(0, |&end| end as usize);
    assert!(begin.is_sorted() && count.saturating_mul(unit) <= values.len());
    let values = values.get_mut(..count * unit).unwrap_or(&mut []);
    let chunks = Chunks::new(values, count);
    // Each row is a turn: rows that are long enough to be uneven are dear.
    schedule(exec, begin.len().saturating_sub(1), 0, move |_, turn| {
        for row in turn {
            if let Some(&[from, to]) = begin.get(row..row + 2) {
                // SAFETY: `begin` ascends, so rows share no chunk, and `schedule` gives every row to one worker once.
                task(row, unsafe { chunks.get(from as usize..to as usize) });
            }
        }
    });
}
