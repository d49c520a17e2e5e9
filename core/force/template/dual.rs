//! Numbers in which a template's field is computed: plain ones, and ones that carry derivatives along.

use core::ops::{Add, Mul, Neg, Sub};

/// Derivatives that a [`Dual`] carries.
pub(super) const PARTS: usize = 4;

/// A number, with or without derivatives.
pub trait Number:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Neg<Output = Self>
{
    /// A constant.
    fn of(value: f64) -> Self;
    /// One of which derivative `part` is `by`.
    fn variable(value: f64, part: usize, by: f64) -> Self;
    /// Its value.
    fn value(self) -> f64;
    /// Its derivatives, all 0 where it carries none.
    fn by(self) -> [f64; PARTS];
    /// A function of it, from its value and its derivative there.
    fn map(self, value: f64, slope: f64) -> Self;

    /// e to its power.
    fn exp(self) -> Self {
        let e = libm::exp(self.value());
        self.map(e, e)
    }

    /// Its sine and cosine.
    fn sine_and_cosine(self) -> [Self; 2] {
        let (sine, cosine) = libm::sincos(self.value());
        [self.map(sine, cosine), self.map(cosine, -sine)]
    }

    /// 1 over it.
    fn inverse(self) -> Self {
        let inverse = 1.0 / self.value();
        self.map(inverse, -inverse * inverse)
    }
}

impl Number for f64 {
    fn of(value: f64) -> Self {
        value
    }

    fn variable(value: f64, _: usize, _: f64) -> Self {
        value
    }

    fn value(self) -> f64 {
        self
    }

    fn by(self) -> [f64; PARTS] {
        [0.0; PARTS]
    }

    fn map(self, value: f64, _: f64) -> Self {
        value
    }
}

/// A number with its derivatives by the middle of a template, along each axis, and by the logarithm of its radius.
#[derive(Clone, Copy, Debug)]
pub struct Dual {
    value: f64,
    by: [f64; PARTS],
}

impl Dual {
    /// Derivatives s a + t b.
    fn joined(value: f64, (s, a): (f64, Self), (t, b): (f64, Self)) -> Self {
        let mut by = a.by.map(|a| s * a);
        by.iter_mut().zip(b.by).for_each(|(by, b)| *by += t * b);
        Self { value, by }
    }
}

impl Number for Dual {
    fn of(value: f64) -> Self {
        Self {
            value,
            by: [0.0; PARTS],
        }
    }

    fn variable(value: f64, part: usize, by: f64) -> Self {
        let by = core::array::from_fn(|index| if index == part { by } else { 0.0 });
        Self { value, by }
    }

    fn value(self) -> f64 {
        self.value
    }

    fn by(self) -> [f64; PARTS] {
        self.by
    }

    fn map(self, value: f64, slope: f64) -> Self {
        Self {
            value,
            by: self.by.map(|by| slope * by),
        }
    }
}

impl Add for Dual {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self::joined(self.value + other.value, (1.0, self), (1.0, other))
    }
}

impl Sub for Dual {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        Self::joined(self.value - other.value, (1.0, self), (-1.0, other))
    }
}

impl Mul for Dual {
    type Output = Self;

    fn mul(self, other: Self) -> Self {
        Self::joined(self.value * other.value, (other.value, self), (self.value, other))
    }
}

impl Neg for Dual {
    type Output = Self;

    fn neg(self) -> Self {
        self.map(-self.value, -1.0)
    }
}
