//! Seconds of a piece of work.

use std::time::Instant;

/// The best of `repeats` timings of `work`, in seconds.
pub fn best(repeats: usize, mut work: impl FnMut()) -> f64 {
    (0..repeats)
        .map(|_| timed(&mut work))
        .fold(f64::INFINITY, f64::min)
}

/// Seconds of `work`.
pub fn timed(work: impl FnOnce()) -> f64 {
    let began = Instant::now();
    work();
    began.elapsed().as_secs_f64()
}
