//! SIMD vectors, and kernels compiled for several instruction sets, of which one is chosen for the whole
//! process.
//!
//! Every operation works lane by lane, so a result does not depend on the length of a vector, and multiply
//! and add are never fused: all instruction sets give the same bits.
#![allow(unsafe_code)]

mod macros;
mod portable;
#[cfg(target_arch = "x86_64")]
mod x86;

pub(crate) use macros::{compiled_for, compiled_once, multiversion, vectorised};
pub use portable::{F32Narrow, F64Narrow};
#[cfg(target_arch = "x86_64")]
pub use x86::{F32Medium, F32Wide, F64Medium, F64Wide};
#[cfg(not(target_arch = "x86_64"))]
pub use {F32Narrow as F32Medium, F32Narrow as F32Wide, F64Narrow as F64Medium, F64Narrow as F64Wide};

use core::ops::{Add, Mul, Neg, Sub};
use core::sync::atomic::{AtomicU8, Ordering};

/// An instruction set that the kernels are compiled for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Level {
    /// What every machine of the target has.
    Baseline = 1,
    /// AVX2 (256 bits).
    Avx2 = 2,
    /// AVX-512 (512 bits).
    Avx512 = 3,
}

static LEVEL: AtomicU8 = AtomicU8::new(0);

/// The level that the kernels run at: the best that the machine has, unless [`limit`] said less.
#[inline]
#[must_use]
pub fn level() -> Level {
    match LEVEL.load(Ordering::Relaxed) {
        1 => Level::Baseline,
        2 => Level::Avx2,
        3 => Level::Avx512,
        _ => limit(Level::Avx512),
    }
}

/// Keeps the kernels to at most `level`, and returns the level in force. For tests and comparisons.
pub fn limit(level: Level) -> Level {
    let chosen = level.min(best());
    LEVEL.store(chosen as u8, Ordering::Relaxed);
    chosen
}

#[cfg(target_arch = "x86_64")]
fn best() -> Level {
    cpufeatures::new!(has_avx512, "avx512f", "avx512vl", "avx512dq", "avx512bw", "avx2");
    cpufeatures::new!(has_avx2, "avx2");
    if has_avx512::get() {
        Level::Avx512
    } else if has_avx2::get() {
        Level::Avx2
    } else {
        Level::Baseline
    }
}

#[cfg(not(target_arch = "x86_64"))]
fn best() -> Level {
    Level::Baseline
}

/// Nothing more to know where a proof can exist; elsewhere there is no value of this type.
#[cfg(target_arch = "x86_64")]
type Proven = ();
#[cfg(not(target_arch = "x86_64"))]
type Proven = core::convert::Infallible;

/// Proof that the processor has AVX-512, without which functions that [`compiled_for`] it cannot be called.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Avx512(Proven);

/// Proof that the processor has AVX2; see [`Avx512`].
#[derive(Clone, Copy, Debug)]
pub(crate) struct Avx2(Proven);

#[cfg(not(target_arch = "x86_64"))]
impl Avx512 {
    /// Never called: there is no such proof.
    pub(crate) fn absurd(self) {
        match self.0 {}
    }
}

#[cfg(not(target_arch = "x86_64"))]
impl Avx2 {
    /// Never called: there is no such proof.
    pub(crate) fn absurd(self) {
        match self.0 {}
    }
}

/// AVX-512, if the kernels run at that [`level`].
#[inline(always)]
pub(crate) fn avx512() -> Option<Avx512> {
    #[cfg(target_arch = "x86_64")]
    let proof = (level() >= Level::Avx512).then_some(Avx512(()));
    #[cfg(not(target_arch = "x86_64"))]
    let proof = None;
    proof
}

/// AVX2, if the kernels run at that [`level`] or a higher one.
#[inline(always)]
pub(crate) fn avx2() -> Option<Avx2> {
    #[cfg(target_arch = "x86_64")]
    let proof = (level() >= Level::Avx2).then_some(Avx2(()));
    #[cfg(not(target_arch = "x86_64"))]
    let proof = None;
    proof
}

/// A cache of the processor that [`prefetch`] loads into.
#[derive(Clone, Copy, Debug)]
pub enum Cache {
    /// The first level, for what is read next.
    First,
    /// The second level, for more data than the first one has room for: there, prefetched lines would evict
    /// those in use, and would be evicted themselves before they are read.
    Second,
}

/// Starts to load `count` values of `from`, from `index` on, into a cache. Places beyond the slice are
/// harmless.
#[inline(always)]
pub fn prefetch<T>(cache: Cache, from: &[T], index: usize, count: usize) {
    #[cfg(target_arch = "x86_64")]
    for line in 0..(count * size_of::<T>()).div_ceil(CACHE_LINE) {
        use core::arch::x86_64::{_MM_HINT_T0, _MM_HINT_T1, _mm_prefetch};
        let address = from
            .as_ptr()
            .wrapping_add(index)
            .wrapping_add(line * (CACHE_LINE / size_of::<T>()))
            .cast();
        // SAFETY: a prefetch never faults, whatever the address.
        unsafe {
            match cache {
                Cache::First => _mm_prefetch::<_MM_HINT_T0>(address),
                Cache::Second => _mm_prefetch::<_MM_HINT_T1>(address),
            }
        }
    }
    #[cfg(not(target_arch = "x86_64"))]
    let _ = (cache, from, index, count);
}

/// Bytes of a line of the caches.
#[cfg(target_arch = "x86_64")]
const CACHE_LINE: usize = 64;

/// A SIMD vector: a few values side by side, each in a lane.
///
/// A type wider than the processor must not be used; [`level`] says which may.
pub trait Vector:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Neg<Output = Self>
{
    /// The type of the value in a lane.
    type Elem: Copy;
    /// Number of lanes.
    const LANES: usize;
    /// `x` in every lane.
    fn splat(x: Self::Elem) -> Self;
    /// The first `LANES` values of `from`, which must have as many.
    fn load(from: &[Self::Elem]) -> Self;
    /// Writes to the first `LANES` places of `to`, which must have as many.
    fn store(self, to: &mut [Self::Elem]);
    /// [`Self::load`] of the values from `index` on.
    #[inline(always)]
    fn at(from: &[Self::Elem], index: usize) -> Self {
        Self::load(&from[index..])
    }
    /// [`Self::store`] to the places from `index` on.
    #[inline(always)]
    fn put(self, to: &mut [Self::Elem], index: usize) {
        self.store(&mut to[index..]);
    }
    /// The first and the second value of each pair of the values of `self` and then `other`; pair `i` goes to lane [`Self::PAIRED`]`[i]`.
    fn pairs(self, other: Self) -> [Self; 2];
    /// [`Self::pairs`] of the first `2 LANES` values of `from`, which must have as many.
    #[inline(always)]
    fn load_pairs(from: &[Self::Elem]) -> [Self; 2] {
        Self::at(from, 0).pairs(Self::at(from, Self::LANES))
    }
    /// The order of [`Self::pairs`], its own inverse.
    const PAIRED: &'static [usize] = &[0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15];
    /// Moves what is in lane [`Self::PAIRED`]`[i]` to lane `i`.
    #[inline(always)]
    #[must_use]
    fn unpaired(self) -> Self {
        self
    }
    /// 1 / x.
    fn recip(self) -> Self;
    /// The square root, correctly rounded.
    #[must_use]
    fn root(self) -> Self;
    /// The larger value in each lane; that of `other` where this one is NaN.
    fn max(self, other: Self) -> Self;
    /// The smaller value in each lane; that of `other` where this one is NaN.
    fn min(self, other: Self) -> Self;
    /// The value of `yes` where this one is above 0, else that of `no`.
    fn select(self, yes: Self, no: Self) -> Self;
    /// Whether a lane holds a value above 0.
    fn any_above_zero(self) -> bool;
}
