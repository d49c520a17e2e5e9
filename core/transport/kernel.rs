//! What the kernels of all face-flux schemes share: how the rows that they write lie, the values around cells, and the size of a row.
//!
//! No closures: they would not be compiled for the vectors.

use super::rows::Rows;
use crate::field::rows;
use crate::grid::halo::BEFORE;
use crate::real::Real;
use crate::simd::Vector;

/// How rows of `n` cells lie in a field that is written: with halos or without.
#[derive(Clone, Copy)]
pub struct Layout {
    /// The cells of a row.
    pub n: usize,
    /// The distance between their beginnings.
    pub apart: usize,
    /// The length of the halo before each.
    pub before: usize,
}

impl Layout {
    /// That of `rows` rows which take `len` values together.
    pub fn new(n: usize, len: usize, rows: usize) -> Self {
        let apart = (len / rows.max(1)).max(1);
        let before = if apart > n { BEFORE } else { 0 };
        Self { n, apart, before }
    }
}

/// Values at offsets -2 .. 2 of cells at `i`: from the rows at -2, -1, 1 and 2, and `c` in the middle.
#[inline(always)]
pub fn around<T: Real, V: Vector<Elem = T>>(rows: &[&[T]; 4], i: usize, c: V) -> [V; 5] {
    [
        V::at(rows[0], i),
        V::at(rows[1], i),
        c,
        V::at(rows[2], i),
        V::at(rows[3], i),
    ]
}

/// The rows along one axis that an adjoint reads: of z and y at offsets -2, -1, 1 and 2 of the cells, of faces at -1, 0, 1 and 2.
pub struct Along<'a, T> {
    /// The adjoint.
    pub z: [&'a [T]; 4],
    /// What flowed.
    pub y: [&'a [T]; 4],
    /// Velocities.
    pub faces: [&'a [T]; 4],
}

/// z, y and the velocities in the rows of a run and around them.
#[derive(Clone, Copy)]
pub struct Read<'a, T> {
    /// The adjoint.
    pub z: Rows<'a, T>,
    /// What flowed.
    pub y: Rows<'a, T>,
    /// Velocities.
    pub faces: Rows<'a, T>,
}

impl<'a, T: Real> Along<'a, T> {
    /// Along the row itself, of `n` cells.
    #[inline(always)]
    pub fn x(row: usize, n: usize, read: &Read<'a, T>) -> Self {
        let (z, y) = (read.z.own(row, n + 4), read.y.own(row, n + 4));
        let faces = read.faces.own(row, n + 3);
        Self {
            z: [&z[..n], &z[1..], &z[3..], &z[4..]],
            y: [&y[..n], &y[1..], &y[3..], &y[4..]],
            faces: [&faces[..n], &faces[1..], &faces[2..], &faces[3..]],
        }
    }

    /// Along y or z.
    #[inline(always)]
    pub fn across(axis: usize, row: usize, n: usize, read: &Read<'a, T>) -> Self {
        Self {
            z: read.z.along(axis, row, n),
            y: read.y.along(axis, row, n),
            faces: read.faces.along(axis, row, n),
        }
    }

    /// Velocities at the faces before, below, above and after cells at `i`.
    #[inline(always)]
    pub fn through<V: Vector<Elem = T>>(&self, i: usize) -> [V; 4] {
        let [before, low, high, after] = self.faces;
        [V::at(before, i), V::at(low, i), V::at(high, i), V::at(after, i)]
    }
}

/// The largest magnitude so far, and what is NaN once a value is not finite.
#[derive(Clone, Copy)]
pub struct Extremes<V> {
    largest: V,
    poison: V,
}

impl<T: Real, V: Vector<Elem = T>> Extremes<V> {
    /// Of no values.
    #[inline(always)]
    pub fn none() -> Self {
        Self {
            largest: V::splat(T::ZERO),
            poison: V::splat(T::ZERO),
        }
    }

    /// Takes in a value of magnitude `size`.
    #[inline(always)]
    pub fn take(&mut self, value: V, size: V) {
        self.largest = size.max(self.largest);
        self.poison = self.poison + value * V::splat(T::ZERO);
    }

    /// The largest magnitude in a row, of its whole vectors and the `rest`; NaN where any value is not finite.
    #[inline(always)]
    pub fn with(self, rest: Extremes<T>) -> f64 {
        let mut lanes = [[T::ZERO; rows::LANES]; 2];
        self.largest.store(&mut lanes[0]);
        self.poison.store(&mut lanes[1]);
        lanes[0][0] = rest.largest.max(lanes[0][0]);
        lanes[1][0] += rest.poison;
        rows::largest_lane(lanes[0], lanes[1])
    }
}
