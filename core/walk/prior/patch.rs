//! The cells about a footprint, side by side.

use crate::real::Real;
use crate::walk::{Cells, Footprint};

/// `N` = `SIDE`^D cells about a footprint, which lies in their middle.
pub(super) struct Patch<const D: usize, const SIDE: usize, const N: usize> {
    /// What they hold; 0 beyond the box.
    pub values: [f64; N],
    /// What a sample of mass 1 adds.
    pub weights: [f64; N],
    /// 1 in the box, 0 beyond it; `None` where all of them are in it.
    pub inside: Option<[f64; N]>,
}

impl<const D: usize, const SIDE: usize, const N: usize> Patch<D, SIDE, N> {
    /// Cells on either side of the footprint.
    const HALO: usize = SIDE / 2 - 1;

    #[inline(always)]
    pub fn around<T: Real>(cells: &Cells<D>, field: &[T], footprint: &Footprint<D>) -> Self {
        let mut patch = Self {
            values: [0.0; N],
            weights: Self::weights(footprint),
            inside: None,
        };
        let within = footprint
            .base
            .iter()
            .zip(&cells.counts)
            .all(|(&base, &count)| base >= Self::HALO && base + Self::HALO + 2 <= count);
        if within {
            patch.copy(cells, field, footprint);
        } else {
            patch.gather(cells, field, footprint);
        }
        patch
    }

    #[inline(always)]
    fn weights(footprint: &Footprint<D>) -> [f64; N] {
        let mut weights = [0.0; N];
        for corner in 0..1 << D {
            let (mut place, mut stride) = (0, 1);
            for axis in 0..D {
                place += stride * (Self::HALO + (corner >> axis & 1));
                stride *= SIDE;
            }
            if let Some(weight) = weights.get_mut(place) {
                *weight = footprint.weight(corner);
            }
        }
        weights
    }

    /// Row by row, where all of it is in the box.
    #[inline(always)]
    fn copy<T: Real>(&mut self, cells: &Cells<D>, field: &[T], footprint: &Footprint<D>) {
        let first = cells.index(&footprint.base.map(|base| base - Self::HALO));
        let row = cells.counts[0];
        let plane = if D > 2 { row * cells.counts[1] } else { 0 };
        for (number, values) in self.values.chunks_exact_mut(SIDE).enumerate() {
            let start = first + number % SIDE * row + number / SIDE * plane;
            if let Some(from) = field.get(start..start + SIDE) {
                for (value, from) in values.iter_mut().zip(from) {
                    *value = from.to_f64();
                }
            }
        }
    }

    /// Cell by cell, at the edge of the box.
    #[cold]
    fn gather<T: Real>(&mut self, cells: &Cells<D>, field: &[T], footprint: &Footprint<D>) {
        let mut inside = [0.0; N];
        for (place, (value, inside)) in self.values.iter_mut().zip(&mut inside).enumerate() {
            let mut rest = place;
            let (mut cell, mut held) = ([0; D], true);
            for axis in 0..D {
                let at = footprint.base[axis] + rest % SIDE;
                rest /= SIDE;
                held &= at >= Self::HALO && at - Self::HALO < cells.counts[axis];
                cell[axis] = at.saturating_sub(Self::HALO);
            }
            if held && let Some(from) = field.get(cells.index(&cell)) {
                (*value, *inside) = (from.to_f64(), 1.0);
            }
        }
        self.inside = Some(inside);
    }
}
