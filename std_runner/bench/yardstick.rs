//! Seconds, and what the machine can do: a triad for its memory, multiplications and additions for its arithmetic, how long a number
//! is on its way from thread to thread; measured in the same run.

use super::ready::{in_block, no_memory};
use crate::exit::Failure;
use core::hint::{black_box, spin_loop};
use core::sync::atomic::{AtomicU64, AtomicUsize, Ordering};
use serde::Serialize;
use std::time::Instant;
use thurible_core::exec::{RowBuffers, for_rows};
use thurible_core::memory::{Arena, TooSmall};
use thurible_core::{Exec, Serial};

/// Numbers of each array of the triad: 64 MiB, more than a core's share of any cache.
const NUMBERS: usize = 1 << 24;
/// The same where a few seconds must do.
const FEW_NUMBERS: usize = 1 << 20;
/// Repeats, so many that some of them are not disturbed.
const REPEATS: usize = 40;
/// Chunks that the threads take.
const CHUNKS: usize = 1 << 8;
/// Operations of each chain.
const LINKS: usize = 1 << 22;
/// Times that a number goes there and back in one measurement,
const TRIPS: usize = 1_000;
/// and measurements.
const MEASUREMENTS: usize = 9;
/// Looks at a number until nobody is waited for any more.
const PATIENCE: usize = 1 << 18;

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

/// What the machine did.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Yardstick {
    /// Threads of the run.
    pub threads: usize,
    /// What changes from minute to minute.
    #[serde(flatten)]
    pub moment: Moment,
    /// Bytes a second of the triad on one thread.
    pub triad_on_one: f64,
    /// Operations a second on one thread.
    pub flops_on_one: f64,
}

/// What the machine did at one time: other machines may share its processors.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Moment {
    /// Bytes a second of the triad.
    pub triad: f64,
    /// Multiplications and additions in f32 a second, as many of one as of the other, none fused.
    pub flops: f64,
    /// Seconds until one thread reads what another wrote; none where no two run at the same time.
    pub handover: Option<f64>,
}

impl Moment {
    /// Measures; `quick` in arrays that fit in a cache.
    ///
    /// # Errors
    /// [`Failure`]: there is no memory for them.
    pub fn measure(exec: &dyn Exec, quick: bool) -> Result<Self, Failure> {
        Ok(Self {
            triad: triad(exec, numbers(quick))?,
            flops: arithmetic(exec),
            handover: handover(exec),
        })
    }

    /// The mean of what was before and what is after something.
    #[must_use]
    pub fn mean(self, after: Self) -> Self {
        let handover = self
            .handover
            .zip(after.handover)
            .map(|(before, after)| 0.5 * (before + after));
        Self {
            triad: 0.5 * (self.triad + after.triad),
            flops: 0.5 * (self.flops + after.flops),
            handover,
        }
    }
}

/// Numbers of each array of the triad.
const fn numbers(quick: bool) -> usize {
    if quick { FEW_NUMBERS } else { NUMBERS }
}

impl Yardstick {
    /// Measures; `quick` in arrays that fit in a cache.
    ///
    /// # Errors
    /// [`Failure`]: there is no memory for them.
    pub fn measure(exec: &dyn Exec, quick: bool) -> Result<Self, Failure> {
        let moment = Moment::measure(exec, quick)?;
        Ok(Self {
            threads: exec.threads(),
            moment,
            triad_on_one: triad(&Serial, numbers(quick))?,
            flops_on_one: arithmetic(&Serial),
        })
    }

    /// In words.
    pub fn sentence(&self) -> String {
        let [triad, one, flops, one_flops] = [
            self.moment.triad,
            self.triad_on_one,
            self.moment.flops,
            self.flops_on_one,
        ]
        .map(|rate| rate / 1e9);
        let handover = self.moment.handover.map_or_else(String::new, |seconds| {
            format!(" From thread to thread in {:.0} ns.", 1e9 * seconds)
        });
        format!(
            "Triad a = b + 3 c in f32 on {} threads: {triad:.1} GB/s, on one {one:.1}. \
             Multiplications and additions in f32, not fused: {flops:.0} GFLOP/s, on one thread {one_flops:.0}.{handover}",
            self.threads
        )
    }
}

/// Bytes a second of a = b + s c in f32 on the threads of `exec`, counting two reads and a write, in a block like a solve's.
fn triad(exec: &dyn Exec, numbers: usize) -> Result<f64, Failure> {
    triad_of(exec, CHUNKS, numbers / CHUNKS)
}

/// As [`triad`], over `rows` rows of `a_row` numbers, as often in a timing as it takes for as many numbers as [`FEW_NUMBERS`].
fn triad_of(exec: &dyn Exec, rows: usize, a_row: usize) -> Result<f64, Failure> {
    let numbers = rows * a_row;
    let (bytes, passes) = (3 * numbers * size_of::<f32>(), FEW_NUMBERS.div_ceil(numbers));
    in_block(bytes, |block| {
        let mut arena = Arena::new(block);
        let mut array = || {
            arena
                .take::<f32>(numbers)
                .map_err(|TooSmall { .. }| no_memory(bytes))
        };
        let (a, b, c) = (array()?, array()?, array()?);
        b.fill(1.0);
        c.fill(2.0);
        let seconds = best(REPEATS, || {
            for _ in 0..passes {
                for_rows(exec, rows, RowBuffers::fields([&mut *a]), |task| {
                    let [a] = task.fields;
                    let span = task.row * a.len()..(task.row + 1) * a.len();
                    a.iter_mut()
                        .zip(&b[span.clone()])
                        .zip(&c[span])
                        .for_each(|((a, &b), &c)| *a = b + 3.0 * c);
                });
                black_box(&mut *a);
            }
        });
        Ok((passes * bytes) as f64 / seconds)
    })
}

/// How many times as fast all threads of `exec` are as one where they meet after every triad over `rows` rows of `a_row` numbers.
///
/// # Errors
/// [`Failure`]: there is no memory for it.
pub fn gain(exec: &dyn Exec, rows: usize, a_row: usize) -> Result<f64, Failure> {
    Ok(triad_of(exec, rows, a_row)? / triad_of(&Serial, rows, a_row)?)
}

/// Operations a second in registers on the threads of `exec`.
fn arithmetic(exec: &dyn Exec) -> f64 {
    let side_by_side = chains(0);
    let seconds = best(3, || {
        exec.run(exec.threads(), &|_| {
            black_box(chains(LINKS));
        });
    });
    (side_by_side * LINKS * exec.threads()) as f64 / seconds
}

/// x <- x a and y <- y + b, `links` times in each of some chains, in the widest vectors that the machine has; operations of a link in all of them.
///
/// Chains do not wait for each other, and there are as many as registers hold, to hide the latency of either operation.
fn chains(links: usize) -> usize {
    #[cfg(target_arch = "x86_64")]
    {
        if is_x86_feature_detected!("avx512f") {
            #[expect(
                unsafe_code,
                reason = "calling a function compiled for AVX-512 after asking the machine for it"
            )]
            // SAFETY: the machine has AVX-512.
            return unsafe { wide::chains(links) };
        }
        if is_x86_feature_detected!("avx") {
            #[expect(
                unsafe_code,
                reason = "calling a function compiled for AVX after asking the machine for it"
            )]
            // SAFETY: the machine has AVX.
            return unsafe { medium::chains(links) };
        }
    }
    let mut pairs = [[[black_box(1f32); 4]; 2]; 6];
    let (a, b) = (black_box(1f32), black_box(0.25f32));
    for _ in 0..links {
        for [product, sum] in &mut pairs {
            product.iter_mut().for_each(|x| *x *= a);
            sum.iter_mut().for_each(|y| *y += b);
        }
    }
    black_box(pairs).as_flattened().as_flattened().len()
}

/// [`chains`] in vectors of one instruction set.
#[cfg(target_arch = "x86_64")]
macro_rules! chains {
    ($name:ident, $feature:literal, $lanes:expr, $chains:expr, $splat:ident, $multiply:ident, $add:ident) => {
        mod $name {
            use super::black_box;
            use core::arch::x86_64::{$add, $multiply, $splat};

            #[target_feature(enable = $feature)]
            pub(super) fn chains(links: usize) -> usize {
                let mut pairs = [($splat(black_box(1.0)), $splat(black_box(1.0))); $chains];
                let (a, b) = ($splat(black_box(1.0)), $splat(black_box(0.25)));
                for _ in 0..links {
                    for (product, sum) in &mut pairs {
                        *product = $multiply(*product, a);
                        *sum = $add(*sum, b);
                    }
                }
                black_box(pairs);
                2 * $chains * $lanes
            }
        }
    };
}
#[cfg(target_arch = "x86_64")]
chains!(
    wide,
    "avx512f",
    16,
    12,
    _mm512_set1_ps,
    _mm512_mul_ps,
    _mm512_add_ps
);
#[cfg(target_arch = "x86_64")]
chains!(medium, "avx", 8, 6, _mm256_set1_ps, _mm256_mul_ps, _mm256_add_ps);

/// A number on a cache line of its own: processors fetch lines in pairs.
#[derive(Default)]
#[repr(align(128))]
struct Line(AtomicUsize);

impl Line {
    /// Waits until the number is `goal`; whether it came to that.
    fn reaches(&self, goal: usize) -> bool {
        (0..PATIENCE).any(|_| {
            spin_loop();
            self.0.load(Ordering::Acquire) == goal
        })
    }
}

/// Seconds until one thread of `exec` reads what another wrote: half of a way there and back, the median of some.
fn handover(exec: &dyn Exec) -> Option<f64> {
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
