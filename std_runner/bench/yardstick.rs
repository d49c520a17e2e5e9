//! Seconds, and what the machine can do: a triad for its memory, multiply-adds for its arithmetic, measured in the same run.

use core::hint::black_box;
use serde::Serialize;
use std::time::Instant;
use thurible_core::exec::{RowBuffers, for_rows};
use thurible_core::{Exec, Serial};

/// Numbers of each array of the triad: 64 MiB, more than a core's share of any cache.
const NUMBERS: usize = 1 << 24;
/// The same where a few seconds must do.
const FEW_NUMBERS: usize = 1 << 20;
/// Repeats, so many that some of them are not disturbed.
const REPEATS: usize = 40;
/// Chunks that the threads take.
const CHUNKS: usize = 1 << 8;
/// Multiply-adds of each chain.
const LINKS: usize = 1 << 22;
/// Chains that do not wait for each other, enough to hide the latency of a multiply-add.
const CHAINS: usize = 12;

/// The best of `repeats` timings of `work`, in seconds.
pub fn best(repeats: usize, mut work: impl FnMut()) -> f64 {
    (0..repeats).map(|_| timed(&mut work)).fold(f64::INFINITY, f64::min)
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
    /// Bytes a second of the triad on those threads.
    pub triad: f64,
    /// The same on one thread.
    pub triad_on_one: f64,
    /// Multiply-adds in f32, two operations each, a second, on those threads.
    pub flops: f64,
    /// The same on one thread.
    pub flops_on_one: f64,
}

impl Yardstick {
    /// Measures; `quick` in arrays that fit in a cache.
    pub fn measure(exec: &dyn Exec, quick: bool) -> Self {
        let numbers = if quick { FEW_NUMBERS } else { NUMBERS };
        Self {
            threads: exec.threads(),
            triad: triad(exec, numbers),
            triad_on_one: triad(&Serial, numbers),
            flops: multiply_adds(exec),
            flops_on_one: multiply_adds(&Serial),
        }
    }

    /// In words.
    pub fn sentence(&self) -> String {
        let [triad, one, flops, one_flops] = [self.triad, self.triad_on_one, self.flops, self.flops_on_one].map(|rate| rate / 1e9);
        format!(
            "Triad a = b + 3 c in f32 on {} threads: {triad:.1} GB/s, on one {one:.1}. Multiply-adds in f32: {flops:.0} GFLOP/s, on one thread {one_flops:.0}.",
            self.threads
        )
    }
}

/// Bytes a second of a = b + s c in f32 on the threads of `exec`, counting two reads and a write.
fn triad(exec: &dyn Exec, numbers: usize) -> f64 {
    let (mut a, b, c) = (vec![0f32; numbers], vec![1f32; numbers], vec![2f32; numbers]);
    let seconds = best(REPEATS, || {
        for_rows(exec, CHUNKS, 0..CHUNKS, RowBuffers { fields: [&mut a[..]], sums: &mut [], scratch: &mut [] }, |task| {
            let [a] = task.fields;
            let span = task.row * a.len()..(task.row + 1) * a.len();
            a.iter_mut().zip(&b[span.clone()]).zip(&c[span]).for_each(|((a, &b), &c)| *a = b + 3.0 * c);
        });
        black_box(&a);
    });
    (3 * numbers * size_of::<f32>()) as f64 / seconds
}

/// Operations a second of multiply-adds in registers on the threads of `exec`.
fn multiply_adds(exec: &dyn Exec) -> f64 {
    let lanes = chains(0);
    let seconds = best(3, || {
        exec.run(exec.threads(), &|_| {
            black_box(chains(LINKS));
        });
    });
    (2 * lanes * CHAINS * LINKS * exec.threads()) as f64 / seconds
}

/// x <- x a + b, `links` times in each chain, in the widest vectors that the machine has; how many lanes those have.
fn chains(links: usize) -> usize {
    #[cfg(target_arch = "x86_64")]
    {
        if is_x86_feature_detected!("avx512f") {
            #[expect(unsafe_code, reason = "calling a function compiled for AVX-512 after asking the machine for it")]
            // SAFETY: the machine has AVX-512.
            return unsafe { wide::chains(links) };
        }
        if is_x86_feature_detected!("fma") {
            #[expect(unsafe_code, reason = "calling a function compiled for FMA after asking the machine for it")]
            // SAFETY: the machine has FMA and with it AVX.
            return unsafe { medium::chains(links) };
        }
    }
    let mut sums = [[black_box(1f32); 4]; CHAINS];
    let (a, b) = (black_box(0.5f32), black_box(0.25f32));
    for _ in 0..links {
        sums.iter_mut().flatten().for_each(|sum| *sum = *sum * a + b);
    }
    black_box(sums);
    4
}

/// [`chains`] in vectors of one instruction set.
#[cfg(target_arch = "x86_64")]
macro_rules! chains {
    ($name:ident, $feature:literal, $lanes:expr, $splat:ident, $multiply_add:ident) => {
        mod $name {
            use super::{CHAINS, black_box};
            use core::arch::x86_64::{$multiply_add, $splat};

            #[target_feature(enable = $feature)]
            pub(super) fn chains(links: usize) -> usize {
                let mut sums = [$splat(black_box(1.0)); CHAINS];
                let (a, b) = ($splat(black_box(0.5)), $splat(black_box(0.25)));
                for _ in 0..links {
                    for sum in &mut sums {
                        *sum = $multiply_add(*sum, a, b);
                    }
                }
                black_box(sums);
                $lanes
            }
        }
    };
}
#[cfg(target_arch = "x86_64")]
chains!(wide, "avx512f", 16, _mm512_set1_ps, _mm512_fmadd_ps);
#[cfg(target_arch = "x86_64")]
chains!(medium, "avx,fma", 8, _mm256_set1_ps, _mm256_fmadd_ps);
