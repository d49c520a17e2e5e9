//! Samples on a grid of cells: a sample at a place adds d-linear weights to the 2^d cells around it.

use crate::real::Real;

/// A grid of cells, x fastest; cell i of an axis has its centre at i + 1/2.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Cells<const D: usize> {
    /// Cells along each axis, at least two.
    pub counts: [usize; D],
}

/// The 2^D cells around a place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Footprint<const D: usize> {
    /// The lowest of them along each axis.
    pub base: [usize; D],
    /// How much of a sample the other one gets, along each axis.
    pub part: [f64; D],
}

impl<const D: usize> Footprint<D> {
    /// Weight of corner `corner`, whose bit a says whether it is the upper one along axis a.
    #[inline(always)]
    #[must_use]
    pub fn weight(&self, corner: usize) -> f64 {
        let mut weight = 1.0;
        for (axis, &part) in self.part.iter().enumerate() {
            weight *= if corner >> axis & 1 == 1 { part } else { 1.0 - part };
        }
        weight
    }
}

impl<const D: usize> Cells<D> {
    /// How many there are.
    #[must_use]
    pub fn len(&self) -> usize {
        self.counts.iter().product()
    }

    /// Whether there are none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Whether `place` lies in the box.
    #[inline(always)]
    #[must_use]
    pub fn hold(&self, place: &[f64; D]) -> bool {
        place
            .iter()
            .zip(&self.counts)
            .all(|(&x, &count)| x >= 0.0 && x < count as f64)
    }

    /// The cells around a place of the box; beyond the outermost centres the outermost cell gets all.
    #[inline(always)]
    #[must_use]
    pub fn around(&self, place: &[f64; D]) -> Footprint<D> {
        let mut found = Footprint {
            base: [0; D],
            part: [0.0; D],
        };
        for axis in 0..D {
            let x = (place[axis] - 0.5).max(0.0);
            let base = (x as usize).min(self.counts[axis].saturating_sub(2));
            found.base[axis] = base;
            found.part[axis] = (x - base as f64).min(1.0);
        }
        found
    }

    /// Place of a cell in the field.
    #[inline(always)]
    #[must_use]
    pub fn index(&self, cell: &[usize; D]) -> usize {
        let mut index = 0;
        for axis in (0..D).rev() {
            index = index * self.counts[axis] + cell[axis];
        }
        index
    }

    /// The cell at a place of the field.
    #[must_use]
    pub fn cell(&self, index: usize) -> [usize; D] {
        let mut rest = index;
        self.counts.map(|count| {
            let at = rest % count.max(1);
            rest /= count.max(1);
            at
        })
    }

    /// Place in the field of corner `corner` of a footprint.
    #[inline(always)]
    #[must_use]
    pub fn corner(&self, footprint: &Footprint<D>, corner: usize) -> usize {
        let mut cell = footprint.base;
        for (axis, at) in cell.iter_mut().enumerate() {
            *at += corner >> axis & 1;
        }
        self.index(&cell)
    }

    /// Adds a sample to `field`.
    #[inline(always)]
    pub fn add<T: Real>(&self, field: &mut [T], footprint: &Footprint<D>, mass: f64) {
        for corner in 0..1 << D {
            if let Some(value) = field.get_mut(self.corner(footprint, corner)) {
                *value = T::from_f64(value.to_f64() + mass * footprint.weight(corner));
            }
        }
    }

    /// The least value that the cells of a footprint would have with a sample of `mass`.
    #[inline(always)]
    #[must_use]
    pub fn least<T: Real>(&self, field: &[T], footprint: &Footprint<D>, mass: f64) -> f64 {
        let mut least = f64::INFINITY;
        for corner in 0..1 << D {
            let weight = footprint.weight(corner);
            if let Some(value) = field.get(self.corner(footprint, corner))
                && weight > 0.0
            {
                least = least.min(value.to_f64() + mass * weight);
            }
        }
        least
    }
}
