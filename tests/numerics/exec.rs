//! Loops on threads: every row is visited once, with its own part of every buffer.

use crate::fields::with_threads;
use thurible_core::exec::{Exec, Planes, RowBuffers, Slabs, for_rows, for_rows_across, for_runs, for_slabs};

/// Says that there are some threads, and runs their tasks one by one from the last.
pub struct Backwards(pub usize);

impl Exec for Backwards {
    fn threads(&self) -> usize {
        self.0
    }

    fn run(&self, tasks: usize, task: &(dyn Fn(usize) + Sync)) {
        (0..tasks).rev().for_each(task);
    }
}

const ROWS: usize = 53;
/// Elements of a row: less and more than what is worth a thread or a turn.
const LENGTHS: [usize; 3] = [1, 300, 5000];

/// Calls `check` with executors of several threads, and a few times with real ones.
fn on_threads(check: impl Fn(&dyn Exec) + Sync) {
    for threads in [1, 2, 3, 16, 17, 40] {
        check(&Backwards(threads));
    }
    for threads in [1, 2, 3, 17] {
        with_threads(threads, |exec| (0..20).for_each(|_| check(exec)));
    }
}

/// Adds 1 and the row to every element of a row, so that a row that is visited twice or never shows.
fn mark(elements: &mut [f32], row: usize) {
    elements.iter_mut().for_each(|x| *x += 1.0 + row as f32);
}

/// Whether the rows that `visited` names are marked once and all others are not.
fn marked(field: &[f32], length: usize, visited: impl Fn(usize) -> bool) -> bool {
    field.chunks_exact(length).enumerate().all(|(row, elements)| {
        let expected = if visited(row) { 1.0 + row as f32 } else { 0.0 };
        elements.iter().all(|&x| x == expected)
    })
}

#[test]
fn every_row_is_visited_once() {
    for (rows, length) in [ROWS, 0, 1, 26]
        .into_iter()
        .flat_map(|rows| LENGTHS.map(|length| (rows, length)))
    {
        on_threads(|exec| {
            let mut field = vec![0f32; rows * length];
            for_rows(exec, rows, RowBuffers::fields([&mut field]), |task| {
                task.fields.into_iter().for_each(|row| mark(row, task.row));
            });
            assert!(
                marked(&field, length, |_| true),
                "{rows} rows of {length} elements on {} threads",
                exec.threads()
            );
        });
    }
}

#[test]
fn every_row_is_in_one_run() {
    for length in LENGTHS {
        on_threads(|exec| {
            let mut field = vec![0f32; ROWS * length];
            for_runs(exec, ROWS, [&mut field], &mut [], |task| {
                let [elements] = task.fields;
                assert_eq!(elements.len(), task.rows.len() * length);
                task.rows
                    .zip(elements.chunks_exact_mut(length))
                    .for_each(|(row, elements)| mark(elements, row));
            });
            assert!(
                marked(&field, length, |_| true),
                "runs of {length} elements a row on {} threads",
                exec.threads()
            );
        });
    }
}

#[test]
fn every_row_is_in_one_slab() {
    for (count, least) in [(0, 1), (1, 1), (6, 4), (80, 4), (60, 1), (7, 60)] {
        let slabs = Slabs::new(ROWS, count, least);
        assert!(
            (1..=count.max(1)).contains(&slabs.count())
                && (0..slabs.count()).all(|slab| slabs.rows_of(slab).len() >= least.min(ROWS))
        );
        on_threads(|exec| {
            let (mut field, mut sums) = (vec![0f32; ROWS], vec![0.0; 2 * ROWS]);
            let buffers = RowBuffers::fields([&mut field]).with_sums(&mut sums);
            for_slabs(exec, slabs, buffers, |task| {
                let ([elements], rows) = (task.fields, task.rows);
                assert!(rows.clone().all(|row| slabs.rows_of(slabs.slab_of(row)) == rows));
                let sums = task.sums.chunks_exact_mut(2);
                for ((row, elements), sums) in rows.zip(elements.chunks_exact_mut(1)).zip(sums) {
                    mark(elements, row);
                    sums[1] = row as f64;
                }
            });
            let numbers = sums.chunks_exact(2).enumerate();
            assert!(numbers.into_iter().all(|(row, sums)| sums == [0.0, row as f64]));
            assert!(
                marked(&field, 1, |_| true),
                "{count} slabs on {} threads",
                exec.threads()
            );
        });
    }
}

/// A ring of seven planes of eight rows behind one that is left out.
#[test]
fn every_row_of_a_ring_of_planes_is_visited_once() {
    let rings = [(7, 0), (7, 5), (3, 6), (0, 2), (4, usize::MAX)];
    for ((count, first), length) in rings
        .into_iter()
        .flat_map(|ring| LENGTHS.map(|length| (ring, length)))
    {
        let planes = Planes {
            count,
            first,
            size: 7,
            offset: 1,
        };
        let expected: Vec<usize> = (0..count).map(|at| 1 + (first % 7 + at) % 7).collect();
        on_threads(|exec| {
            let mut field = vec![0f32; 64 * length];
            for_rows_across(exec, 64, 8, planes, RowBuffers::fields([&mut field]), |task| {
                task.fields.into_iter().for_each(|row| mark(row, task.row));
            });
            assert!(
                marked(&field, length, |row| expected.contains(&(row / 8))),
                "{count} planes from {first}, rows of {length} elements on {} threads",
                exec.threads()
            );
        });
    }
}
