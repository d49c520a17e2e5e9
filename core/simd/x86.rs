//! The vectors of x86-64.

use super::Vector;
use core::arch::x86_64::*;
use core::ops::{Add, Mul, Neg, Sub};

/// A [`Vector`] of the type `$raw`, from the instructions of its operations.
macro_rules! vector {
    (
        $(#[$meta:meta])*
        $name:ident: $raw:ty, $lanes:literal of $t:ty {
            splat: $splat:path, load: $load:path, store: $store:path,
            add: $add:path, sub: $sub:path, mul: $mul:path, div: $div:path, root: $root:path,
            max: $max:path, min: $min:path, select: $select:path, any: $any:path,
            pairs: $pairs:path $(, paired: $paired:path, unpaired: $unpaired:path)? $(,)?
        }
    ) => {
        $(#[$meta])*
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
                // SAFETY: `from` has `LANES` values.
                Self(unsafe { $load(from.as_ptr()) })
            }
            #[inline(always)]
            fn store(self, to: &mut [$t]) {
                let to = &mut to[..$lanes];
                // SAFETY: `to` has `LANES` values.
                unsafe { $store(to.as_mut_ptr(), self.0) }
            }
            #[inline(always)]
            fn pairs(self, other: Self) -> [Self; 2] {
                // SAFETY: as in `add`.
                let [even, odd] = unsafe { $pairs(self.0, other.0) };
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
            fn root(self) -> Self {
                // SAFETY: as in `add`.
                Self(unsafe { $root(self.0) })
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

vector! {
    /// Sixteen `f32` of AVX-512.
    F32Wide: __m512, 16 of f32 {
        splat: _mm512_set1_ps, load: _mm512_loadu_ps, store: _mm512_storeu_ps,
        add: _mm512_add_ps, sub: _mm512_sub_ps, mul: _mm512_mul_ps, div: _mm512_div_ps, root: _mm512_sqrt_ps,
        max: _mm512_max_ps, min: _mm512_min_ps, select: select_ps512, any: any_ps512,
        pairs: pairs_ps512,
    }
}
vector! {
    /// Eight `f64` of AVX-512.
    F64Wide: __m512d, 8 of f64 {
        splat: _mm512_set1_pd, load: _mm512_loadu_pd, store: _mm512_storeu_pd,
        add: _mm512_add_pd, sub: _mm512_sub_pd, mul: _mm512_mul_pd, div: _mm512_div_pd, root: _mm512_sqrt_pd,
        max: _mm512_max_pd, min: _mm512_min_pd, select: select_pd512, any: any_pd512,
        pairs: pairs_pd512,
    }
}
vector! {
    /// Eight `f32` of AVX2.
    F32Medium: __m256, 8 of f32 {
        splat: _mm256_set1_ps, load: _mm256_loadu_ps, store: _mm256_storeu_ps,
        add: _mm256_add_ps, sub: _mm256_sub_ps, mul: _mm256_mul_ps, div: _mm256_div_ps, root: _mm256_sqrt_ps,
        max: _mm256_max_ps, min: _mm256_min_ps, select: select_ps256, any: any_ps256,
        pairs: pairs_ps256, paired: PAIRED_PS256, unpaired: unpaired_ps256,
    }
}
vector! {
    /// Four `f64` of AVX2.
    F64Medium: __m256d, 4 of f64 {
        splat: _mm256_set1_pd, load: _mm256_loadu_pd, store: _mm256_storeu_pd,
        add: _mm256_add_pd, sub: _mm256_sub_pd, mul: _mm256_mul_pd, div: _mm256_div_pd, root: _mm256_sqrt_pd,
        max: _mm256_max_pd, min: _mm256_min_pd, select: select_pd256, any: any_pd256,
        pairs: pairs_pd256, paired: PAIRED_PD256, unpaired: unpaired_pd256,
    }
}
