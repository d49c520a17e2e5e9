//! The scalar types of the core, `f32` and `f64`, behind one trait; nothing from `std`.

use core::fmt::Debug;
use core::ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign};

mod sealed {
    pub trait Sealed {}
    impl Sealed for f32 {}
    impl Sealed for f64 {}
}

/// `f32` or `f64`. Sums over fields accumulate in `f64` whatever the precision.
pub trait Real:
    Copy
    + Debug
    + Default
    + PartialOrd
    + Send
    + Sync
    + 'static
    + sealed::Sealed
    + crate::memory::Plain
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + crate::simd::Vector<Elem = Self>
    + AddAssign
    + SubAssign
{
    /// Bytes that one value takes.
    const BYTES: usize;
    /// Zero, 0.
    const ZERO: Self;
    /// One, 1.
    const ONE: Self;
    /// One half, 1/2.
    const HALF: Self;
    /// Distance from 1 to the next larger value.
    const EPSILON: f64;
    /// Name of the type as users write it: `f32` or `f64`.
    const NAME: &'static str;
    /// Widest SIMD vector of this type, for AVX-512; see [`simd`](crate::simd).
    type Wide: crate::simd::Vector<Elem = Self>;
    /// As [`Self::Wide`], for machines with AVX2.
    type Medium: crate::simd::Vector<Elem = Self>;
    /// As [`Self::Wide`], for every machine.
    type Narrow: crate::simd::Vector<Elem = Self>;

    /// The nearest value of this type; ties go to the even one.
    fn from_f64(x: f64) -> Self;
    /// The same value in `f64`; always exact.
    fn to_f64(self) -> f64;
    /// The absolute value |x|.
    fn abs(self) -> Self;
    /// The square root, correctly rounded.
    fn sqrt(self) -> Self;
    /// Neither infinite nor NaN.
    fn is_finite(self) -> bool;

    /// Both numbers in the bytes of one: as bfloat16 in an `f32`, as `f32` in an `f64`, the first in the upper half. Each goes to the nearest
    /// that a half has, ties to the even one, by arithmetic on its bits that every machine does alike; what is no number stays so.
    fn of_halves(numbers: [Self; 2]) -> Self;
    /// The numbers that [`Self::of_halves`] left; always exact.
    fn halves(self) -> [Self; 2];

    /// Its bytes, little-endian, into [`Self::BYTES`] of them.
    fn write(self, bytes: &mut [u8]);
    /// From [`Self::BYTES`] little-endian bytes.
    fn read(bytes: &[u8]) -> Self;

    /// The value nearest to a count.
    #[inline(always)]
    fn from_usize(x: usize) -> Self {
        Self::from_f64(x as f64)
    }
}

/// The bits of a number in `f32` rounded to bfloat16, which are the upper ones; the lower ones are of no use.
#[inline(always)]
fn rounded(x: f32) -> u32 {
    let bits = x.to_bits();
    // NaN would carry into the sign.
    if x.is_nan() {
        0x7fc0_0000
    } else {
        bits + 0x7fff + (bits >> 16 & 1)
    }
}

#[inline(always)]
fn of_halves_f32([upper, lower]: [f32; 2]) -> f32 {
    f32::from_bits(rounded(upper) & 0xffff_0000 | rounded(lower) >> 16)
}

#[inline(always)]
fn halves_f32(both: f32) -> [f32; 2] {
    [both.to_bits() & 0xffff_0000, both.to_bits() << 16].map(f32::from_bits)
}

#[inline(always)]
fn of_halves_f64(numbers: [f64; 2]) -> f64 {
    let [upper, lower] = numbers.map(|x| u64::from((x as f32).to_bits()));
    f64::from_bits(upper << 32 | lower)
}

#[inline(always)]
fn halves_f64(both: f64) -> [f64; 2] {
    [both.to_bits() >> 32, both.to_bits()].map(|half| f64::from(f32::from_bits(half as u32)))
}

macro_rules! real {
    ($t:ident, $bytes:expr, $sqrt:path, $halves:path, $of_halves:path, $wide:ident, $medium:ident, $narrow:ident) => {
        impl Real for $t {
            const BYTES: usize = $bytes;
            const ZERO: Self = 0.0;
            const ONE: Self = 1.0;
            const HALF: Self = 0.5;
            const EPSILON: f64 = $t::EPSILON as f64;
            const NAME: &'static str = stringify!($t);
            type Wide = crate::simd::$wide;
            type Medium = crate::simd::$medium;
            type Narrow = crate::simd::$narrow;

            #[inline(always)]
            fn from_f64(x: f64) -> Self {
                x as $t
            }
            #[inline(always)]
            fn to_f64(self) -> f64 {
                self as f64
            }
            #[inline(always)]
            fn abs(self) -> Self {
                $t::abs(self)
            }
            #[inline(always)]
            fn sqrt(self) -> Self {
                $sqrt(self)
            }
            #[inline(always)]
            fn is_finite(self) -> bool {
                $t::is_finite(self)
            }
            #[inline(always)]
            fn of_halves(numbers: [Self; 2]) -> Self {
                $of_halves(numbers)
            }
            #[inline(always)]
            fn halves(self) -> [Self; 2] {
                $halves(self)
            }
            #[inline(always)]
            fn write(self, bytes: &mut [u8]) {
                bytes
                    .iter_mut()
                    .zip(self.to_le_bytes())
                    .for_each(|(to, from)| *to = from);
            }
            #[inline(always)]
            fn read(bytes: &[u8]) -> Self {
                let mut own = [0; $bytes];
                own.iter_mut().zip(bytes).for_each(|(to, &from)| *to = from);
                Self::from_le_bytes(own)
            }
        }
    };
}

real!(
    f32,
    4,
    libm::sqrtf,
    halves_f32,
    of_halves_f32,
    F32Wide,
    F32Medium,
    F32Narrow
);
real!(
    f64,
    8,
    libm::sqrt,
    halves_f64,
    of_halves_f64,
    F64Wide,
    F64Medium,
    F64Narrow
);
