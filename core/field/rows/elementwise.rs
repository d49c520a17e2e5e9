//! Elementwise loops over rows of equal length.

use crate::real::Real;
use crate::simd::multiversion;

multiversion! {
    /// `out += x`.
    pub fn add[T: Real](out: &mut [T], x: &[T]) {
        for (o, &x) in out.iter_mut().zip(x) {
            *o += x;
        }
    }
}

multiversion! {
    /// `out *= x`.
    pub fn multiply[T: Real](out: &mut [T], x: &[T]) {
        for (o, &x) in out.iter_mut().zip(x) {
            *o = *o * x;
        }
    }
}

multiversion! {
    /// `out -= x`.
    pub fn sub[T: Real](out: &mut [T], x: &[T]) {
        for (o, &x) in out.iter_mut().zip(x) {
            *o -= x;
        }
    }
}

multiversion! {
    /// `out += s x`.
    pub fn add_scaled[T: Real](out: &mut [T], s: T, x: &[T]) {
        for (o, &x) in out.iter_mut().zip(x) {
            *o += s * x;
        }
    }
}

multiversion! {
    /// `out = s0 x0 + s1 x1 + s2 x2 + s3 x3`, from the left.
    pub fn sum_of_four[T: Real](out: &mut [T], s: [T; 4], x0: &[T], x1: &[T], x2: &[T], x3: &[T]) {
        for ((((o, &x0), &x1), &x2), &x3) in out.iter_mut().zip(x0).zip(x1).zip(x2).zip(x3) {
            *o = s[0] * x0 + s[1] * x1 + s[2] * x2 + s[3] * x3;
        }
    }
}

multiversion! {
    /// `out = s x`.
    pub fn scale[T: Real](out: &mut [T], s: T, x: &[T]) {
        for (o, &x) in out.iter_mut().zip(x) {
            *o = s * x;
        }
    }
}

multiversion! {
    /// `out += s (x - y)`.
    pub fn add_difference[T: Real](out: &mut [T], s: T, x: &[T], y: &[T]) {
        for ((o, &x), &y) in out.iter_mut().zip(x).zip(y) {
            *o += s * (x - y);
        }
    }
}

/// Sets the first value of every `nx` to 0: the face, or the plaquette, on the wall.
pub fn clear_first<T: Real>(out: &mut [T], nx: usize) {
    for first in out.iter_mut().step_by(nx) {
        *first = T::ZERO;
    }
}

multiversion! {
    /// `out *= s`.
    pub fn scale_in_place[T: Real](out: &mut [T], s: T) {
        for o in out.iter_mut() {
            *o = *o * s;
        }
    }
}

multiversion! {
    /// `out = s out - x`.
    pub fn scale_and_sub[T: Real](out: &mut [T], s: T, x: &[T]) {
        for (o, &x) in out.iter_mut().zip(x) {
            *o = s * *o - x;
        }
    }
}

multiversion! {
    /// `out = x + s out`.
    pub fn combine[T: Real](out: &mut [T], s: T, x: &[T]) {
        for (o, &x) in out.iter_mut().zip(x) {
            *o = x + s * *o;
        }
    }
}

multiversion! {
    /// `out += s (x - y - out)`.
    pub fn relax[T: Real](out: &mut [T], s: T, x: &[T], y: &[T]) {
        for ((o, &x), &y) in out.iter_mut().zip(x).zip(y) {
            *o += s * (x - y - *o);
        }
    }
}
