//! The arithmetic of the machine, by chains of multiplications and of additions in registers.

use crate::timing::best;
use core::hint::black_box;
use thurible_core::Exec;

/// Operations of each chain.
const LINKS: usize = 1 << 22;
/// Operations a second in registers on the threads of `exec`.
pub(super) fn arithmetic(exec: &dyn Exec) -> f64 {
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
