//! Kernels of (2R + 1)^2 numbers that sum to 1: one for all pixels, or one of several for each.

use super::plane::Frame;
use crate::real::Real;
use core::ops::Range;

/// The kernels, one after the other, and which one each pixel of the image has.
#[derive(Clone, Copy, Debug)]
pub struct Kernels<'a> {
    /// R.
    pub radius: usize,
    /// (2R + 1)^2 numbers each, row by row; q(y) = sum over k of f(k) p(y - k).
    pub values: &'a [f64],
    /// For each pixel of the image its kernel; empty where there is one.
    pub which: &'a [u16],
}

impl Kernels<'_> {
    /// Numbers along a side.
    #[must_use]
    pub fn side(&self) -> usize {
        2 * self.radius + 1
    }

    /// How many there are.
    #[must_use]
    pub fn count(&self) -> usize {
        self.values.len() / (self.side() * self.side())
    }
}

/// Kernels on an image.
#[derive(Clone, Copy)]
pub struct Blur<'a, T> {
    /// The sizes; the border is the kernels' radius.
    pub frame: Frame,
    /// The kernels' numbers.
    pub values: &'a [T],
    /// The kernel of each pixel; empty where there is one.
    pub which: &'a [u16],
}

impl<T: Real> Blur<'_, T> {
    fn side(&self) -> usize {
        2 * self.frame.border + 1
    }

    /// The rows of the kernel that reach the image from place (x, y) of the bordered plane, and the rows of the image that they reach: visits
    /// (first pixel, first kernel number, count).
    #[inline(always)]
    pub fn reach(&self, [x, y]: [usize; 2], mut visit: impl FnMut(usize, usize, usize)) {
        let Frame { width, height, .. } = self.frame;
        let side = self.side();
        // Kernel number k reaches pixel x - 2R + k of the image.
        let span = |at: usize, count: usize| -> Range<usize> {
            let last = side - 1;
            last.saturating_sub(at)..(count + last).saturating_sub(at).min(side)
        };
        let across = span(x, width);
        for row in span(y, height) {
            let pixel = (y + row + 1 - side) * width + (x + across.start + 1 - side);
            visit(pixel, row * side + across.start, across.len());
        }
    }

    /// Kernel number `number` at a pixel of the image.
    #[inline(always)]
    pub(super) fn at(&self, pixel: usize, number: usize) -> f64 {
        let kernel = self.which.get(pixel).map_or(0, |&which| usize::from(which));
        let place = kernel * self.side() * self.side() + number;
        self.values.get(place).map_or(0.0, |value| value.to_f64())
    }

    /// <f_x, M r> and |M f_x|^2 of the place (x, y) of the bordered plane.
    #[inline(always)]
    pub fn gains(&self, place: [usize; 2], residual: &[T], mask: &[u16]) -> [f64; 2] {
        let (mut along, mut square) = (0.0, 0.0);
        self.reach(place, |pixel, number, count| {
            let range = pixel..pixel + count;
            let (Some(residual), Some(mask)) = (residual.get(range.clone()), mask.get(range)) else {
                return;
            };
            for (index, (residual, &mask)) in residual.iter().zip(mask).enumerate() {
                let value = f64::from(mask) * self.at(pixel + index, number + index);
                along += value * residual.to_f64();
                square += value * value;
            }
        });
        [along, square]
    }

    /// r -= m f_x.
    #[inline(always)]
    pub fn take(&self, place: [usize; 2], mass: f64, residual: &mut [T]) {
        self.reach(place, |pixel, number, count| {
            let Some(residual) = residual.get_mut(pixel..pixel + count) else {
                return;
            };
            for (index, residual) in residual.iter_mut().enumerate() {
                let value = self.at(pixel + index, number + index);
                *residual = T::from_f64(residual.to_f64() - mass * value);
            }
        });
    }

    /// `image` = f * p of a plane.
    pub fn apply(&self, plane: &[T], image: &mut [T]) {
        image.fill(T::ZERO);
        let wide = self.frame.wide();
        for (place, value) in plane.iter().enumerate() {
            self.take([place % wide, place / wide], -value.to_f64(), image);
        }
    }

    /// `plane` = f^T (M r).
    pub fn transpose(&self, image: &[T], mask: &[u16], plane: &mut [T]) {
        let wide = self.frame.wide();
        for (place, value) in plane.iter_mut().enumerate() {
            *value = T::from_f64(self.gains([place % wide, place / wide], image, mask)[0]);
        }
    }
}
