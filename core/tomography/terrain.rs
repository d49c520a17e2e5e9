//! What a chain walks on: places of the box, what samples there would gain, and the pixels and cells that they change.

use super::camera::Camera;
use super::pixels::Touched;
use crate::real::Real;
use crate::simd::multiversion;
use crate::walk::prior::change;
use crate::walk::{Cells, Course, Gain, Prior, Random, Terrain};

multiversion! {
    /// Up to `most` mutations more.
    pub(super) fn walk[T: Real, const D: usize](
        ground: &mut Ground<'_, T, D>,
        course: &mut Course<[f64; D]>,
        most: u64,
    ) {
        course.advance(ground, most);
    }
}

/// The views, the residual and the density.
pub(super) struct Ground<'a, T, const D: usize> {
    pub cells: Cells<D>,
    pub cameras: &'a [Camera<D>],
    /// q, the pictures one after the other.
    pub measured: &'a [T],
    /// r = q - F p.
    pub residual: &'a mut [T],
    /// p.
    pub density: &'a mut [T],
    pub prior: Prior,
    pub gamma: f64,
    pub nonnegative: bool,
    /// Standard deviation of a mutation, in cells.
    pub sigma: f64,
    /// The mass of a sample.
    pub eps: f64,
    /// Pixels of at most this are dark.
    pub dark: f64,
}

impl<T: Real, const D: usize> Ground<'_, T, D> {
    /// <a, r> and |a|^2 with a the weights of the pixels that a sample touches; nothing outside of the visual hull.
    #[inline(always)]
    fn seen(&self, place: &[f64; D]) -> Option<[f64; 2]> {
        let (mut along, mut square) = (0.0, 0.0);
        let (mut measured, mut residual) = (self.measured, &*self.residual);
        let mut any = false;
        for camera in self.cameras {
            let (q, r);
            (q, measured) = measured.split_at_checked(camera.len())?;
            (r, residual) = residual.split_at_checked(camera.len())?;
            let Some(seen) = camera.see(place) else { continue };
            let (mut touches, mut lit) = (false, false);
            let (mut sum, mut weights) = (0.0, 0.0);
            Touched::about(seen.at).each::<D>(&camera.pixels, |pixel, weight| {
                if let (Some(q), Some(r)) = (q.get(pixel), r.get(pixel)) {
                    touches = true;
                    lit |= q.to_f64() > self.dark;
                    sum += weight * r.to_f64();
                    weights += weight * weight;
                }
            });
            if touches && !lit {
                return None;
            }
            any |= touches;
            along += seen.weight * sum;
            square += seen.weight * seen.weight * weights;
        }
        any.then_some([along, square])
    }

    /// What a sample at `place` is worth: gamma times the change of the prior is taken off, and one that makes fall below 0 what may not is
    /// out.
    #[inline(always)]
    pub fn weigh(
        &self,
        place: &[f64; D],
        charge: impl Fn(f64) -> Option<[f64; 2]>,
        falls: impl Fn(f64) -> bool,
    ) -> Gain {
        if !self.cells.hold(place) {
            return Gain::NONE;
        }
        let Some([along, square]) = self.seen(place) else {
            return Gain::NONE;
        };
        let mass = self.eps;
        let half = 0.5 * mass * mass * square;
        let [mut plus, mut minus] = [mass * along - half, -mass * along - half];
        if let Some([up, down]) = charge(mass) {
            plus -= self.gamma * up;
            minus -= self.gamma * down;
        }
        // A sample of -eps is asked for what it leaves only where it would be taken.
        if self.nonnegative && minus > plus && falls(-mass) {
            minus = f64::NEG_INFINITY;
        }
        Gain::better([plus, minus], mass)
    }

    /// The change of a prior on cells.
    #[inline(always)]
    pub fn charge(&self, place: &[f64; D], mass: f64) -> Option<[f64; 2]> {
        if self.prior == Prior::None {
            return None;
        }
        let footprint = self.cells.around(place);
        Some(change(self.prior, &self.cells, self.density, &footprint, mass))
    }

    /// Whether a sample makes a cell fall below 0.
    #[inline(always)]
    pub fn falls(&self, place: &[f64; D], mass: f64) -> bool {
        let footprint = self.cells.around(place);
        self.cells.least(self.density, &footprint, mass) < 0.0
    }

    /// Whether a place lies in the box and in the visual hull: no camera that sees it sees it dark.
    pub fn in_hull(&self, place: &[f64; D]) -> bool {
        self.cells.hold(place) && self.seen(place).is_some()
    }
}

impl<T: Real, const D: usize> Terrain for Ground<'_, T, D> {
    type Place = [f64; D];

    #[inline(always)]
    fn anywhere(&self, random: &mut Random) -> [f64; D] {
        self.cells.counts.map(|count| random.uniform() * count as f64)
    }

    #[inline(always)]
    fn near(&self, from: [f64; D], random: &mut Random) -> [f64; D] {
        from.map(|x| x + self.sigma * random.normal())
    }

    #[inline(always)]
    fn gain(&self, place: [f64; D]) -> Gain {
        self.weigh(
            &place,
            |mass| self.charge(&place, mass),
            |mass| self.falls(&place, mass),
        )
    }

    #[inline(always)]
    fn record(&mut self, place: [f64; D], mass: f64) {
        let mut rest = &mut *self.residual;
        for camera in self.cameras {
            let Some((picture, after)) = rest.split_at_mut_checked(camera.len()) else {
                return;
            };
            rest = after;
            let Some(seen) = camera.see(&place) else { continue };
            Touched::about(seen.at).each::<D>(&camera.pixels, |pixel, weight| {
                if let Some(pixel) = picture.get_mut(pixel) {
                    *pixel = T::from_f64(pixel.to_f64() - mass * seen.weight * weight);
                }
            });
        }
        let footprint = self.cells.around(&place);
        self.cells.add(self.density, &footprint, mass);
    }
}
