//! The numbers of a fast transform along an axis: roots of unity, and what turns a Fourier transform into the coefficients of the
//! [eigenvectors](super::spectrum).
//!
//! Between walls the values are sorted, even places upwards and then odd ones downwards, and the Fourier transform V of that gives
//! the cosines: X_k = Re(e^(-i pi k / 2n) V_k) and X_(n-k) = -Im(e^(-i pi k / 2n) V_k) (Makhoul 1980, A fast cosine transform in
//! one and two dimensions). On a ring V is that of the values as they are, and in the same way cosine k and sine k are the parts of
//! e^(-i pi k / n) V_k.

use super::Axis;
use crate::real::Real;
use core::ops::RangeInclusive;

/// The tables of an axis.
#[derive(Clone, Copy, Debug)]
pub struct Fourier<'m, T> {
    axis: Axis,
    /// e^(-2 pi i j / n) for j from 0 to n - 1, real and imaginary parts in turn.
    pub roots: &'m [T],
    turns: &'m [T],
}

/// Half the length of an eigenvector before it is scaled, in terms of sqrt(2 / n).
const HALF: f64 = 0.5;

impl<'m, T: Real> Fourier<'m, T> {
    /// The numbers of an axis of `n` cells.
    #[must_use]
    pub const fn len(n: usize) -> usize {
        2 * n + 2 * (n / 2 + 1)
    }

    /// Fills [`Self::len`] numbers for [`Self::view`].
    pub fn fill(axis: Axis, numbers: &mut [T]) {
        let n = axis.cells();
        let (roots, turns) = numbers.split_at_mut(2 * n);
        for (j, root) in roots.chunks_exact_mut(2).enumerate() {
            let angle = 2.0 * core::f64::consts::PI * j as f64 / n as f64;
            root.copy_from_slice(&[libm::cos(angle), -libm::sin(angle)].map(T::from_f64));
        }
        let whole = if axis.is_ring() { 1.0 } else { 2.0 };
        for (k, turn) in turns.chunks_exact_mut(2).enumerate() {
            let angle = core::f64::consts::PI * k as f64 / (whole * n as f64);
            let scale = HALF * libm::sqrt(2.0 / n as f64);
            turn.copy_from_slice(&[scale * libm::cos(angle), scale * libm::sin(angle)].map(T::from_f64));
        }
    }

    /// The tables that [`Self::fill`] wrote.
    #[must_use]
    pub fn view(axis: Axis, numbers: &'m [T]) -> Self {
        let (roots, turns) = numbers.split_at(2 * axis.cells());
        Self { axis, roots, turns }
    }

    /// The length of the axis.
    #[must_use]
    pub fn cells(&self) -> usize {
        self.axis.cells()
    }

    /// Where the value of cell `i` stands in what is transformed.
    #[must_use]
    pub fn sorted(&self, i: usize) -> usize {
        match i % 2 {
            _ if self.axis.is_ring() => i,
            0 => i / 2,
            _ => self.cells() - 1 - i / 2,
        }
    }

    /// The coefficients that are V_k but for the scale 1 / sqrt(n): each k with the place of its coefficient.
    pub fn alone(&self) -> impl Iterator<Item = (usize, usize)> {
        let n = self.cells();
        let middle = (self.axis.is_ring() && n.is_multiple_of(2)).then_some((n / 2, n - 1));
        core::iter::once((0, 0)).chain(middle)
    }

    /// The k for which V_k and V_(n-k) give two coefficients.
    #[must_use]
    pub fn pairs(&self) -> RangeInclusive<usize> {
        let n = self.cells();
        1..=if self.axis.is_ring() { (n - 1) / 2 } else { n / 2 }
    }

    /// The places of the two coefficients of V_k and V_(n-k) among those of all eigenvectors, even ones first.
    #[must_use]
    pub fn places(&self, k: usize) -> [usize; 2] {
        let n = self.cells();
        let half = n.div_ceil(2);
        if self.axis.is_ring() {
            return [k, half + k - 1];
        }
        [k, n - k].map(|waves| waves / 2 + if waves.is_multiple_of(2) { 0 } else { half })
    }

    /// Cosine and sine of the angle by which V_k is turned, times half of sqrt(2 / n).
    #[must_use]
    pub fn turn(&self, k: usize) -> [T; 2] {
        match self.turns.get(2 * k..) {
            Some(&[cosine, sine, ..]) => [cosine, sine],
            _ => [T::ZERO; 2],
        }
    }
}

/// 4 or the smallest prime that divides `n`, which is above 1: what the next pass of a transform takes.
#[must_use]
pub fn factor(n: usize) -> usize {
    if n.is_multiple_of(4) {
        return 4;
    }
    (2..)
        .take_while(|p| p * p <= n)
        .find(|&p| n.is_multiple_of(p))
        .unwrap_or(n)
}

/// The fewest cells of an axis that may be transformed fast: as many as there are columns in a panel.
const FEWEST: usize = 32;

/// Whether the passes of a fast transform take less time along an axis of `n` cells than products with matrices of half its size. A pass by p
/// takes about 4.5 p / n of such a product, and a transform has some work beside them (measured in `docs/log/performance.md`).
#[must_use]
pub fn pays(n: usize) -> bool {
    let (mut left, mut sum) = (n, 0);
    while left > 1 {
        let factor = factor(left);
        (left, sum) = (left / factor, sum + factor);
    }
    n >= FEWEST && 9 * sum <= 2 * n + 36
}
