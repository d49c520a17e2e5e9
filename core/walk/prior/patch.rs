//! The cells about a footprint, side by side.

use crate::real::Real;
use crate::walk::{Cells, Footprint};

/// The 2^D cells that a sample touches, some of which may lie beyond the edge.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spot<const D: usize> {
    /// The lowest of them along each axis.
    pub base: [isize; D],
    /// How much of a sample the other one gets, along each axis.
    pub part: [f64; D],
}

impl<const D: usize> From<&Footprint<D>> for Spot<D> {
    #[inline(always)]
    fn from(footprint: &Footprint<D>) -> Self {
        Self {
            base: footprint.base.map(|base| base as isize),
            part: footprint.part,
        }
    }
}

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
    pub fn around<T: Real>(cells: &Cells<D>, field: &[T], spot: &Spot<D>) -> Self {
        let mut patch = Self {
            values: [0.0; N],
            weights: Self::weights(spot),
            inside: None,
        };
        let halo = Self::HALO as isize;
        let within = spot
            .base
            .iter()
            .zip(&cells.counts)
            .all(|(&base, &count)| base >= halo && base + halo + 2 <= count as isize);
        if within {
            patch.copy(cells, field, spot);
        } else {
            patch.gather(cells, field, spot);
        }
        patch
    }

    #[inline(always)]
    fn weights(spot: &Spot<D>) -> [f64; N] {
        let footprint = Footprint {
            base: [0; D],
            part: spot.part,
        };
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
    fn copy<T: Real>(&mut self, cells: &Cells<D>, field: &[T], spot: &Spot<D>) {
        let first = cells.index(&spot.base.map(|base| base as usize - Self::HALO));
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
    fn gather<T: Real>(&mut self, cells: &Cells<D>, field: &[T], spot: &Spot<D>) {
        let mut inside = [0.0; N];
        for (place, (value, inside)) in self.values.iter_mut().zip(&mut inside).enumerate() {
            let mut rest = place;
            let (mut cell, mut held) = ([0; D], true);
            for axis in 0..D {
                let at = spot.base[axis] + (rest % SIDE) as isize - Self::HALO as isize;
                rest /= SIDE;
                held &= at >= 0 && at < cells.counts[axis] as isize;
                cell[axis] = at.max(0) as usize;
            }
            if held && let Some(from) = field.get(cells.index(&cell)) {
                (*value, *inside) = (from.to_f64(), 1.0);
            }
        }
        self.inside = Some(inside);
    }
}
