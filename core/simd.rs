//! Vectors of numbers and the choice of instruction set, made once for the process.
//!
//! Every operation works lane by lane, so a result does not depend on the width, and multiply and add are never fused:
//! all levels give the same bits.
#![allow(unsafe_code)]

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

/// Compiles a kernel once for every [`Level`] and calls the one in force.
///
/// The body must be plain loops over slices; what it calls must be `#[inline(always)]`.
macro_rules! multiversion {
    ($(#[$meta:meta])* $vis:vis fn $name:ident[$($gen:tt)*]($($arg:ident: $ty:ty),* $(,)?) $(-> $ret:ty)? $body:block) => {
        $(#[$meta])*
        #[allow(unsafe_code)]
        $vis fn $name<$($gen)*>($($arg: $ty),*) $(-> $ret)? {
            #[inline(always)]
            fn body<$($gen)*>($($arg: $ty),*) $(-> $ret)? $body

            #[cfg(target_arch = "x86_64")]
            {
                #[target_feature(enable = "avx512f,avx512vl,avx512dq,avx512bw,avx2")]
                unsafe fn avx512<$($gen)*>($($arg: $ty),*) $(-> $ret)? {
                    body($($arg),*)
                }
                #[target_feature(enable = "avx2")]
                unsafe fn avx2<$($gen)*>($($arg: $ty),*) $(-> $ret)? {
                    body($($arg),*)
                }
                match $crate::simd::level() {
                    // SAFETY: `level` returns only what the processor has.
                    $crate::simd::Level::Avx512 => return unsafe { avx512($($arg),*) },
                    // SAFETY: as above.
                    $crate::simd::Level::Avx2 => return unsafe { avx2($($arg),*) },
                    $crate::simd::Level::Baseline => {}
                }
            }
            body($($arg),*)
        }
    };
}
pub(crate) use multiversion;

/// Where [`prefetch`] brings numbers.
#[derive(Clone, Copy, Debug)]
pub enum Cache {
    /// The first cache, for what is read next.
    First,
    /// The second cache, where more waits than the first one holds: there it would drive out what is being worked on, and be gone again
    /// when it is read.
    Second,
}

/// Asks for `count` numbers of `from` from `index` on, which will be read soon; places beyond the slice are harmless.
#[inline(always)]
pub fn prefetch<T>(cache: Cache, from: &[T], index: usize, count: usize) {
    #[cfg(target_arch = "x86_64")]
    for line in 0..(count * size_of::<T>()).div_ceil(CACHE_LINE) {
        use core::arch::x86_64::{_MM_HINT_T0, _MM_HINT_T1, _mm_prefetch};
        let number = from
            .as_ptr()
            .wrapping_add(index)
            .wrapping_add(line * (CACHE_LINE / size_of::<T>()))
            .cast();
        // SAFETY: a prefetch never faults, whatever the address.
        unsafe {
            match cache {
                Cache::First => _mm_prefetch::<_MM_HINT_T0>(number),
                Cache::Second => _mm_prefetch::<_MM_HINT_T1>(number),
            }
        }
    }
    #[cfg(not(target_arch = "x86_64"))]
    let _ = (cache, from, index, count);
}

/// Bytes.
#[cfg(target_arch = "x86_64")]
const CACHE_LINE: usize = 64;

/// A few numbers side by side, one cell a lane.
///
/// A type wider than the processor must not be used; [`level`] says which may.
pub trait Vector:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Neg<Output = Self>
{
    /// The number in a lane.
    type Elem: Copy;
    /// How many lanes.
    const LANES: usize;
    /// The same number in every lane.
    fn splat(x: Self::Elem) -> Self;
    /// The first `LANES` numbers of `from`, which must have as many.
    fn load(from: &[Self::Elem]) -> Self;
    /// Into the first `LANES` numbers of `to`, which must have as many.
    fn store(self, to: &mut [Self::Elem]);
    /// The first and the second of each pair of `from`, which must have `LANES` pairs; pair `i` goes to lane [`Self::PAIRED`]`[i]`.
    fn load_pairs(from: &[Self::Elem]) -> [Self; 2];
    /// The order of [`Self::load_pairs`], its own inverse.
    const PAIRED: &'static [usize] = &[0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15];
    /// What is in lane [`Self::PAIRED`]`[i]` goes to lane `i`.
    #[inline(always)]
    #[must_use]
    fn unpaired(self) -> Self {
        self
    }
    /// 1 / x.
    fn recip(self) -> Self;
    /// The larger of each pair; that of `other` where this one is NaN.
    fn max(self, other: Self) -> Self;
    /// The smaller of each pair; that of `other` where this one is NaN.
    fn min(self, other: Self) -> Self;
    /// The number of `yes` where this one is above 0, else that of `no`.
    fn select(self, yes: Self, no: Self) -> Self;
    /// Whether a number is above 0.
    fn any_above_zero(self) -> bool;
}

/// Compiles a kernel once for every [`Level`], with the vectors of that level as its type parameter `V`.
///
/// `fn name[T, V](..)`: the body may use `V: Vector<Elem = T>`; what it calls must be `#[inline(always)]`.
macro_rules! vectorised {
    ($(#[$meta:meta])* $vis:vis fn $name:ident[$t:ident, $v:ident]($($arg:ident: $ty:ty),* $(,)?) $(-> $ret:ty)? $body:block) => {
        $(#[$meta])*
        #[allow(unsafe_code)]
        $vis fn $name<$t: $crate::real::Real>($($arg: $ty),*) $(-> $ret)? {
            #[inline(always)]
            fn body<$t: $crate::real::Real, $v: $crate::simd::Vector<Elem = $t>>($($arg: $ty),*) $(-> $ret)? $body

            #[cfg(target_arch = "x86_64")]
            {
                #[target_feature(enable = "avx512f,avx512vl,avx512dq,avx512bw,avx2")]
                unsafe fn avx512<$t: $crate::real::Real>($($arg: $ty),*) $(-> $ret)? {
                    body::<$t, $t::Wide>($($arg),*)
                }
                #[target_feature(enable = "avx2")]
                unsafe fn avx2<$t: $crate::real::Real>($($arg: $ty),*) $(-> $ret)? {
                    body::<$t, $t::Medium>($($arg),*)
                }
                match $crate::simd::level() {
                    // SAFETY: `level` returns only what the processor has.
                    $crate::simd::Level::Avx512 => return unsafe { avx512($($arg),*) },
                    // SAFETY: as above.
                    $crate::simd::Level::Avx2 => return unsafe { avx2($($arg),*) },
                    $crate::simd::Level::Baseline => {}
                }
            }
            body::<$t, $t::Narrow>($($arg),*)
        }
    };
}
pub(crate) use vectorised;

macro_rules! single {
    ($t:ident) => {
        impl Vector for $t {
            type Elem = $t;
            const LANES: usize = 1;
            #[inline(always)]
            fn splat(x: $t) -> Self {
                x
            }
            #[inline(always)]
            fn load(from: &[$t]) -> Self {
                from[0]
            }
            #[inline(always)]
            fn store(self, to: &mut [$t]) {
                to[0] = self;
            }
            #[inline(always)]
            fn load_pairs(from: &[$t]) -> [Self; 2] {
                [from[0], from[1]]
            }
            #[inline(always)]
            fn recip(self) -> Self {
                1.0 / self
            }
            #[inline(always)]
            fn max(self, other: Self) -> Self {
                if self > other { self } else { other }
            }
            #[inline(always)]
            fn min(self, other: Self) -> Self {
                if self < other { self } else { other }
            }
            #[inline(always)]
            fn select(self, yes: Self, no: Self) -> Self {
                if self > 0.0 { yes } else { no }
            }
            #[inline(always)]
            fn any_above_zero(self) -> bool {
                self > 0.0
            }
        }
    };
}
single!(f32);
single!(f64);

#[cfg(target_arch = "x86_64")]
macro_rules! vector {
    ($name:ident, $t:ty, $raw:ty, $lanes:expr, $splat:expr, $load:expr, $store:expr, $add:expr, $sub:expr, $mul:expr, $div:expr, $pairs:expr, $max:expr, $min:expr, $select:expr, $any:expr $(, $paired:expr, $unpaired:expr)?) => {
        /// A [`Vector`].
        #[derive(Clone, Copy, Debug)]
        pub struct $name($raw);

        impl Add for $name {
            type Output = Self;
            #[inline(always)]
            fn add(self, other: Self) -> Self {
                // SAFETY: the caller of a kernel of this width has checked `level`.
                Self(unsafe { $add(self.0, other.0) })
            }
        }
        impl Sub for $name {
            type Output = Self;
            #[inline(always)]
            fn sub(self, other: Self) -> Self {
                // SAFETY: as in `add`.
                Self(unsafe { $sub(self.0, other.0) })
            }
        }
        impl Mul for $name {
            type Output = Self;
            #[inline(always)]
            fn mul(self, other: Self) -> Self {
                // SAFETY: as in `add`.
                Self(unsafe { $mul(self.0, other.0) })
            }
        }
        impl Neg for $name {
            type Output = Self;
            #[inline(always)]
            fn neg(self) -> Self {
                Self::splat(0.0) - self
            }
        }
        impl Vector for $name {
            type Elem = $t;
            const LANES: usize = $lanes;
            #[inline(always)]
            fn splat(x: $t) -> Self {
                // SAFETY: as in `add`.
                Self(unsafe { $splat(x) })
            }
            #[inline(always)]
            fn load(from: &[$t]) -> Self {
                let from = &from[..$lanes];
                // SAFETY: `from` has `LANES` numbers.
                Self(unsafe { $load(from.as_ptr()) })
            }
            #[inline(always)]
            fn store(self, to: &mut [$t]) {
                let to = &mut to[..$lanes];
                // SAFETY: `to` has `LANES` numbers.
                unsafe { $store(to.as_mut_ptr(), self.0) }
            }
            #[inline(always)]
            fn load_pairs(from: &[$t]) -> [Self; 2] {
                let from = &from[..2 * $lanes];
                // SAFETY: `from` has `2 LANES` numbers.
                let [even, odd] = unsafe { $pairs($load(from.as_ptr()), $load(from.as_ptr().add($lanes))) };
                [Self(even), Self(odd)]
            }
            $(const PAIRED: &'static [usize] = &$paired;
            #[inline(always)]
            fn unpaired(self) -> Self {
                // SAFETY: as in `add`.
                Self(unsafe { $unpaired(self.0) })
            })?
            #[inline(always)]
            fn recip(self) -> Self {
                // SAFETY: as in `add`.
                Self(unsafe { $div($splat(1.0), self.0) })
            }
            #[inline(always)]
            fn max(self, other: Self) -> Self {
                // SAFETY: as in `add`.
                Self(unsafe { $max(self.0, other.0) })
            }
            #[inline(always)]
            fn min(self, other: Self) -> Self {
                // SAFETY: as in `add`.
                Self(unsafe { $min(self.0, other.0) })
            }
            #[inline(always)]
            fn select(self, yes: Self, no: Self) -> Self {
                // SAFETY: as in `add`.
                Self(unsafe { $select(self.0, yes.0, no.0) })
            }
            #[inline(always)]
            fn any_above_zero(self) -> bool {
                // SAFETY: as in `add`.
                unsafe { $any(self.0) }
            }
        }
    };
}

#[cfg(target_arch = "x86_64")]
mod x86 {
    use super::{Add, Mul, Neg, Sub, Vector};
    use core::arch::x86_64::*;

    #[inline(always)]
    unsafe fn pairs_ps512(a: __m512, b: __m512) -> [__m512; 2] {
        // SAFETY: the caller has AVX-512.
        unsafe {
            let even = _mm512_setr_epi32(0, 2, 4, 6, 8, 10, 12, 14, 16, 18, 20, 22, 24, 26, 28, 30);
            let odd = _mm512_setr_epi32(1, 3, 5, 7, 9, 11, 13, 15, 17, 19, 21, 23, 25, 27, 29, 31);
            [
                _mm512_permutex2var_ps(a, even, b),
                _mm512_permutex2var_ps(a, odd, b),
            ]
        }
    }
    #[inline(always)]
    unsafe fn pairs_pd512(a: __m512d, b: __m512d) -> [__m512d; 2] {
        // SAFETY: the caller has AVX-512.
        unsafe {
            let (even, odd) = (
                _mm512_setr_epi64(0, 2, 4, 6, 8, 10, 12, 14),
                _mm512_setr_epi64(1, 3, 5, 7, 9, 11, 13, 15),
            );
            [
                _mm512_permutex2var_pd(a, even, b),
                _mm512_permutex2var_pd(a, odd, b),
            ]
        }
    }
    // Halves of 128 bits are shuffled apart, which leaves the middle quarters in each other's place.
    #[inline(always)]
    unsafe fn pairs_ps256(a: __m256, b: __m256) -> [__m256; 2] {
        // SAFETY: the caller has AVX2.
        unsafe {
            [
                _mm256_shuffle_ps::<0b10_00_10_00>(a, b),
                _mm256_shuffle_ps::<0b11_01_11_01>(a, b),
            ]
        }
    }
    #[inline(always)]
    unsafe fn pairs_pd256(a: __m256d, b: __m256d) -> [__m256d; 2] {
        // SAFETY: the caller has AVX2.
        unsafe {
            [
                _mm256_shuffle_pd::<0b0000>(a, b),
                _mm256_shuffle_pd::<0b1111>(a, b),
            ]
        }
    }

    const PAIRED_PS256: [usize; 8] = [0, 1, 4, 5, 2, 3, 6, 7];
    const PAIRED_PD256: [usize; 4] = [0, 2, 1, 3];

    #[inline(always)]
    unsafe fn unpaired_ps256(a: __m256) -> __m256 {
        // SAFETY: the caller has AVX2.
        unsafe { _mm256_castpd_ps(unpaired_pd256(_mm256_castps_pd(a))) }
    }
    #[inline(always)]
    unsafe fn unpaired_pd256(a: __m256d) -> __m256d {
        // SAFETY: the caller has AVX2.
        unsafe { _mm256_permute4x64_pd::<0b11_01_10_00>(a) }
    }

    #[inline(always)]
    unsafe fn select_ps512(a: __m512, yes: __m512, no: __m512) -> __m512 {
        // SAFETY: the caller has AVX-512.
        unsafe { _mm512_mask_blend_ps(_mm512_cmp_ps_mask::<_CMP_GT_OQ>(a, _mm512_setzero_ps()), no, yes) }
    }
    #[inline(always)]
    unsafe fn select_pd512(a: __m512d, yes: __m512d, no: __m512d) -> __m512d {
        // SAFETY: the caller has AVX-512.
        unsafe { _mm512_mask_blend_pd(_mm512_cmp_pd_mask::<_CMP_GT_OQ>(a, _mm512_setzero_pd()), no, yes) }
    }
    #[inline(always)]
    unsafe fn select_ps256(a: __m256, yes: __m256, no: __m256) -> __m256 {
        // SAFETY: the caller has AVX2.
        unsafe { _mm256_blendv_ps(no, yes, _mm256_cmp_ps::<_CMP_GT_OQ>(a, _mm256_setzero_ps())) }
    }
    #[inline(always)]
    unsafe fn select_pd256(a: __m256d, yes: __m256d, no: __m256d) -> __m256d {
        // SAFETY: the caller has AVX2.
        unsafe { _mm256_blendv_pd(no, yes, _mm256_cmp_pd::<_CMP_GT_OQ>(a, _mm256_setzero_pd())) }
    }

    #[inline(always)]
    unsafe fn any_ps512(a: __m512) -> bool {
        // SAFETY: the caller has AVX-512.
        unsafe { _mm512_cmp_ps_mask::<_CMP_GT_OQ>(a, _mm512_setzero_ps()) != 0 }
    }
    #[inline(always)]
    unsafe fn any_pd512(a: __m512d) -> bool {
        // SAFETY: the caller has AVX-512.
        unsafe { _mm512_cmp_pd_mask::<_CMP_GT_OQ>(a, _mm512_setzero_pd()) != 0 }
    }
    #[inline(always)]
    unsafe fn any_ps256(a: __m256) -> bool {
        // SAFETY: the caller has AVX2.
        unsafe { _mm256_movemask_ps(_mm256_cmp_ps::<_CMP_GT_OQ>(a, _mm256_setzero_ps())) != 0 }
    }
    #[inline(always)]
    unsafe fn any_pd256(a: __m256d) -> bool {
        // SAFETY: the caller has AVX2.
        unsafe { _mm256_movemask_pd(_mm256_cmp_pd::<_CMP_GT_OQ>(a, _mm256_setzero_pd())) != 0 }
    }

    vector!(
        F32Wide,
        f32,
        __m512,
        16,
        _mm512_set1_ps,
        _mm512_loadu_ps,
        _mm512_storeu_ps,
        _mm512_add_ps,
        _mm512_sub_ps,
        _mm512_mul_ps,
        _mm512_div_ps,
        pairs_ps512,
        _mm512_max_ps,
        _mm512_min_ps,
        select_ps512,
        any_ps512
    );
    vector!(
        F64Wide,
        f64,
        __m512d,
        8,
        _mm512_set1_pd,
        _mm512_loadu_pd,
        _mm512_storeu_pd,
        _mm512_add_pd,
        _mm512_sub_pd,
        _mm512_mul_pd,
        _mm512_div_pd,
        pairs_pd512,
        _mm512_max_pd,
        _mm512_min_pd,
        select_pd512,
        any_pd512
    );
    vector!(
        F32Medium,
        f32,
        __m256,
        8,
        _mm256_set1_ps,
        _mm256_loadu_ps,
        _mm256_storeu_ps,
        _mm256_add_ps,
        _mm256_sub_ps,
        _mm256_mul_ps,
        _mm256_div_ps,
        pairs_ps256,
        _mm256_max_ps,
        _mm256_min_ps,
        select_ps256,
        any_ps256,
        PAIRED_PS256,
        unpaired_ps256
    );
    vector!(
        F64Medium,
        f64,
        __m256d,
        4,
        _mm256_set1_pd,
        _mm256_loadu_pd,
        _mm256_storeu_pd,
        _mm256_add_pd,
        _mm256_sub_pd,
        _mm256_mul_pd,
        _mm256_div_pd,
        pairs_pd256,
        _mm256_max_pd,
        _mm256_min_pd,
        select_pd256,
        any_pd256,
        PAIRED_PD256,
        unpaired_pd256
    );
}
#[cfg(target_arch = "x86_64")]
pub use x86::{F32Medium, F32Wide, F64Medium, F64Wide};
#[cfg(not(target_arch = "x86_64"))]
pub use {F32Narrow as F32Medium, F32Narrow as F32Wide, F64Narrow as F64Medium, F64Narrow as F64Wide};

/// Four plain numbers: what compilers turn into the vectors of any machine.
macro_rules! plain {
    ($name:ident, $t:ty) => {
        /// A [`Vector`] of four numbers for any machine.
        #[derive(Clone, Copy, Debug)]
        pub struct $name([$t; 4]);

        impl $name {
            #[inline(always)]
            fn zip(self, other: Self, f: impl Fn($t, $t) -> $t) -> Self {
                let (a, b) = (self.0, other.0);
                Self([f(a[0], b[0]), f(a[1], b[1]), f(a[2], b[2]), f(a[3], b[3])])
            }
        }
        impl Add for $name {
            type Output = Self;
            #[inline(always)]
            fn add(self, other: Self) -> Self {
                self.zip(other, |a, b| a + b)
            }
        }
        impl Sub for $name {
            type Output = Self;
            #[inline(always)]
            fn sub(self, other: Self) -> Self {
                self.zip(other, |a, b| a - b)
            }
        }
        impl Mul for $name {
            type Output = Self;
            #[inline(always)]
            fn mul(self, other: Self) -> Self {
                self.zip(other, |a, b| a * b)
            }
        }
        impl Neg for $name {
            type Output = Self;
            #[inline(always)]
            fn neg(self) -> Self {
                Self::splat(0.0) - self
            }
        }
        impl Vector for $name {
            type Elem = $t;
            const LANES: usize = 4;
            #[inline(always)]
            fn splat(x: $t) -> Self {
                Self([x; 4])
            }
            #[inline(always)]
            fn load(from: &[$t]) -> Self {
                let from = &from[..4];
                Self([from[0], from[1], from[2], from[3]])
            }
            #[inline(always)]
            fn store(self, to: &mut [$t]) {
                to[..4].copy_from_slice(&self.0);
            }
            #[inline(always)]
            fn load_pairs(from: &[$t]) -> [Self; 2] {
                let from = &from[..8];
                [
                    Self([from[0], from[2], from[4], from[6]]),
                    Self([from[1], from[3], from[5], from[7]]),
                ]
            }
            #[inline(always)]
            fn recip(self) -> Self {
                Self(self.0.map(|x| 1.0 / x))
            }
            #[inline(always)]
            fn max(self, other: Self) -> Self {
                self.zip(other, |a, b| if a > b { a } else { b })
            }
            #[inline(always)]
            fn min(self, other: Self) -> Self {
                self.zip(other, |a, b| if a < b { a } else { b })
            }
            #[inline(always)]
            fn select(self, yes: Self, no: Self) -> Self {
                let (yes, no) = (yes.0, no.0);
                Self(core::array::from_fn(|lane| {
                    if self.0[lane] > 0.0 {
                        yes[lane]
                    } else {
                        no[lane]
                    }
                }))
            }
            #[inline(always)]
            fn any_above_zero(self) -> bool {
                self.0.iter().any(|&x| x > 0.0)
            }
        }
    };
}
plain!(F32Narrow, f32);
plain!(F64Narrow, f64);
