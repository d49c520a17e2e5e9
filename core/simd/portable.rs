//! Vectors that every machine has: one number, and four of which compilers make the machine's own vectors.

use super::Vector;
use core::ops::{Add, Mul, Neg, Sub};

/// A number as a [`Vector`] of one lane.
macro_rules! single {
    ($t:ident, $sqrt:path) => {
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
            fn pairs(self, other: Self) -> [Self; 2] {
                [self, other]
            }
            #[inline(always)]
            fn recip(self) -> Self {
                1.0 / self
            }
            #[inline(always)]
            fn root(self) -> Self {
                $sqrt(self)
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
single!(f32, libm::sqrtf);
single!(f64, libm::sqrt);

/// A [`Vector`] of an array of four values, which compilers turn into vectors on any machine.
macro_rules! plain {
    ($name:ident, $t:ty, $sqrt:path) => {
        /// A [`Vector`] of four values for any machine.
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
            fn pairs(self, other: Self) -> [Self; 2] {
                let (Self([a, b, c, d]), Self([e, f, g, h])) = (self, other);
                [Self([a, c, e, g]), Self([b, d, f, h])]
            }
            #[inline(always)]
            fn recip(self) -> Self {
                Self(self.0.map(|x| 1.0 / x))
            }
            #[inline(always)]
            fn root(self) -> Self {
                Self(self.0.map($sqrt))
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
plain!(F32Narrow, f32, libm::sqrtf);
plain!(F64Narrow, f64, libm::sqrt);
