//! Seconds, and a yardstick for them that is measured on the same machine in the same run.

use core::hint::black_box;
use std::time::Instant;
use thurible_core::Exec;
use thurible_core::exec::{RowBuffers, for_rows};

/// Numbers of each array of the triad: 64 MiB, more than any cache.
const NUMBERS: usize = 1 << 24;
/// Chunks that the threads take.
const CHUNKS: usize = 1 << 8;

/// The best of `repeats` timings of `work`, in seconds.
pub fn best(repeats: usize, mut work: impl FnMut()) -> f64 {
    let time = |work: &mut dyn FnMut()| {
        let began = Instant::now();
        work();
        began.elapsed().as_secs_f64()
    };
    (0..repeats).map(|_| time(&mut work)).fold(f64::INFINITY, f64::min)
}

/// Bytes a second of a = b + s c in f32 on the threads of `exec`, counting two reads and a write.
pub fn triad(exec: &dyn Exec) -> f64 {
    let (mut a, b, c) = (vec![0f32; NUMBERS], vec![1f32; NUMBERS], vec![2f32; NUMBERS]);
    let seconds = best(5, || {
        for_rows(exec, CHUNKS, 0..CHUNKS, RowBuffers { fields: [&mut a[..]], sums: &mut [], scratch: &mut [] }, |task| {
            let [a] = task.fields;
            let span = task.row * a.len()..(task.row + 1) * a.len();
            a.iter_mut().zip(&b[span.clone()]).zip(&c[span]).for_each(|((a, &b), &c)| *a = b + 3.0 * c);
        });
        black_box(&a);
    });
    (3 * NUMBERS * size_of::<f32>()) as f64 / seconds
}
