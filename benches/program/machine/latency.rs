//! How long a value takes from one thread to another.

use core::hint::spin_loop;
use core::sync::atomic::{AtomicU64, AtomicUsize, Ordering};
use std::time::Instant;
use thurible_core::Exec;

/// Round trips of a value in one measurement,
const TRIPS: usize = 1_000;
/// and measurements, of which the median counts.
const MEASUREMENTS: usize = 9;
/// How often a thread looks for the other's value before it gives up.
const PATIENCE: usize = 1 << 18;

/// A value on cache lines of its own: processors fetch lines in pairs.
#[derive(Default)]
#[repr(align(128))]
struct Line(AtomicUsize);

impl Line {
    /// Waits until the value is `goal`; false if it gave up.
    fn reaches(&self, goal: usize) -> bool {
        (0..PATIENCE).any(|_| {
            spin_loop();
            self.0.load(Ordering::Acquire) == goal
        })
    }
}

/// Seconds until one thread of `exec` reads what another wrote: half of a way there and back, the median of some.
pub(super) fn handover(exec: &dyn Exec) -> Option<f64> {
    let mut trips: Vec<f64> = (0..MEASUREMENTS).map_while(|_| round_trips(exec)).collect();
    trips.sort_by(f64::total_cmp);
    trips
        .get(trips.len() / 2)
        .map(|seconds| 0.5 * seconds / TRIPS as f64)
}

/// Seconds of [`TRIPS`] ways from one thread to another and back; none if the other does not come.
fn round_trips(exec: &dyn Exec) -> Option<f64> {
    let (there, back, nanoseconds) = (Line::default(), Line::default(), AtomicU64::new(0));
    exec.run(2.min(exec.threads()), &|side| {
        let goes_and_returns = |trip| {
            there.0.store(trip, Ordering::Release);
            back.reaches(trip)
        };
        let is_sent_back = |trip| {
            let came = there.reaches(trip);
            if came {
                back.0.store(trip, Ordering::Release);
            }
            came
        };
        if side == 1 {
            let _ = (1..=TRIPS + 1).all(is_sent_back);
        } else if goes_and_returns(1) {
            let began = Instant::now();
            if (2..=TRIPS + 1).all(goes_and_returns) {
                nanoseconds.store(
                    u64::try_from(began.elapsed().as_nanos()).unwrap_or(0),
                    Ordering::Relaxed,
                );
            }
        }
    });
    Some(nanoseconds.into_inner())
        .filter(|&nanoseconds| nanoseconds > 0)
        .map(|nanoseconds| nanoseconds as f64 * 1e-9)
}
