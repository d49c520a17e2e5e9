//! What a chain walks on: the numbers of an image with its border.

use super::kernel::Blur;
use super::patch::{Patch, change_patch};
use super::prior::{Clusters, change};
use super::settings::{Moves, Tuning};
use crate::real::Real;
use crate::simd::multiversion;
use crate::walk::{Course, Gain, Random, Terrain};

/// A pixel with its border, which a chain may have left, and its channel.
#[derive(Clone, Copy, Debug)]
pub(super) struct Spot {
    x: i64,
    y: i64,
    channel: usize,
    /// Pixels across and down that change.
    size: [usize; 2],
}

multiversion! {
    /// Up to `most` mutations more.
    pub(super) fn walk[T: Real](ground: &mut Ground<'_, T>, course: &mut Course<Spot>, most: u64) {
        course.advance(ground, most);
    }
}

/// The image, its residual and its mask.
pub(super) struct Ground<'a, T> {
    pub blur: Blur<'a, T>,
    pub mask: &'a [u16],
    pub residual: &'a mut [T],
    pub planes: &'a mut [T],
    pub clusters: Clusters,
    pub tuning: Tuning,
    pub eps: f64,
}

/// Sides that a patch may have: powers of two.
const SIDES: usize = 4;
/// How often one pixel changes where patches do: most of what is left to gain is a pixel's.
const ALONE: f64 = 0.5;
/// A chain that records less than this makes eps smaller; with patches, of which few gain, a part of this.
const TOO_LITTLE: f64 = 0.075;

/// The next lower whole number.
#[inline(always)]
fn floor(x: f64) -> i64 {
    let cut = x as i64;
    cut - i64::from((cut as f64) > x)
}

impl<T: Real> Ground<'_, T> {
    /// The places of a spot: in the plane, in the planes, and where its channel begins in the image.
    #[inline(always)]
    fn place(&self, spot: Spot) -> Option<([usize; 2], usize, usize)> {
        let frame = &self.blur.frame;
        let (x, y) = (usize::try_from(spot.x).ok()?, usize::try_from(spot.y).ok()?);
        if x >= frame.wide() || y >= frame.high() {
            return None;
        }
        let place = (spot.channel * frame.high() + y) * frame.wide() + x;
        Some(([x, y], place, spot.channel * frame.pixels()))
    }

    /// How much a mutation changes.
    #[inline(always)]
    fn size(&self, random: &mut Random) -> [usize; 2] {
        match self.tuning.moves {
            Moves::Pixel => [1; 2],
            Moves::Patch if random.uniform() < ALONE => [1; 2],
            Moves::Patch => [(); 2].map(|()| 1 << random.below(SIDES)),
        }
    }

    /// The patch of a spot, where it lies within the border.
    fn patch(&self, spot: Spot) -> Option<Patch> {
        let frame = &self.blur.frame;
        let ([x, y], _, _) = self.place(spot)?;
        let fits = x + spot.size[0] <= frame.wide() && y + spot.size[1] <= frame.high();
        fits.then_some(Patch {
            at: [x, y],
            size: spot.size,
            channel: spot.channel,
        })
    }

    /// As `gain`, of a patch.
    #[inline(never)]
    fn gain_of(&self, spot: Spot) -> Gain {
        let (Some(patch), Some((_, _, image))) = (self.patch(spot), self.place(spot)) else {
            return Gain::NONE;
        };
        let range = image..image + self.blur.frame.pixels();
        let (Some(residual), Some(mask)) = (self.residual.get(range.clone()), self.mask.get(range)) else {
            return Gain::NONE;
        };
        let (tuning, mass, frame) = (&self.tuning, self.eps, &self.blur.frame);
        let [along, square] = self.blur.gains_of(&patch, residual, mask);
        let [up, down] = change_patch(tuning.prior, &self.clusters, frame, self.planes, &patch, mass);
        let half = 0.5 * mass * mass * square;
        let plus = mass * along - half - tuning.gamma * up;
        let mut places = patch.places(frame);
        let falls = |place| {
            self.planes
                .get(place)
                .is_none_or(|value: &T| value.to_f64() < mass)
        };
        let minus = if tuning.nonnegative && places.any(falls) {
            f64::NEG_INFINITY
        } else {
            -mass * along - half - tuning.gamma * down
        };
        Gain::better([plus, minus], mass)
    }

    /// As `record`, of a patch.
    #[inline(never)]
    fn record_of(&mut self, spot: Spot, mass: f64) {
        let (Some(patch), Some((_, _, image))) = (self.patch(spot), self.place(spot)) else {
            return;
        };
        for place in patch.places(&self.blur.frame) {
            if let Some(value) = self.planes.get_mut(place) {
                *value = T::from_f64(value.to_f64() + mass);
            }
        }
        let range = image..image + self.blur.frame.pixels();
        if let Some(residual) = self.residual.get_mut(range) {
            self.blur.take_of(&patch, mass, residual);
        }
    }
}

impl<T: Real> Terrain for Ground<'_, T> {
    type Place = Spot;

    #[inline(always)]
    fn anywhere(&self, random: &mut Random) -> Spot {
        let frame = &self.blur.frame;
        let (x, y) = (random.below(frame.wide()), random.below(frame.high()));
        Spot {
            x: x as i64,
            y: y as i64,
            channel: channel(frame.channels, random),
            size: self.size(random),
        }
    }

    #[inline(always)]
    fn near(&self, from: Spot, random: &mut Random) -> Spot {
        let sigma = self.tuning.sigma * (2 * self.blur.frame.border + 1) as f64;
        let mut step = |at: i64| floor(at as f64 + 0.5 + sigma * random.normal());
        let (x, y) = (step(from.x), step(from.y));
        Spot {
            x,
            y,
            channel: channel(self.blur.frame.channels, random),
            size: self.size(random),
        }
    }

    #[inline(always)]
    fn gain(&self, spot: Spot) -> Gain {
        if self.tuning.moves == Moves::Patch {
            return self.gain_of(spot);
        }
        let Some((at, place, image)) = self.place(spot) else {
            return Gain::NONE;
        };
        let range = image..image + self.blur.frame.pixels();
        let (Some(residual), Some(mask)) = (self.residual.get(range.clone()), self.mask.get(range)) else {
            return Gain::NONE;
        };
        let [along, square] = self.blur.gains(at, residual, mask);
        let value = self.planes.get(place).map_or(0.0, |value| value.to_f64());
        let mass = self.eps;
        let tuning = &self.tuning;
        let [up, down] = change(
            tuning.prior,
            &self.clusters,
            &self.blur.frame,
            self.planes,
            place,
            mass,
        );
        let half = 0.5 * mass * mass * square;
        let plus = mass * along - half - self.tuning.gamma * up;
        let minus = if self.tuning.nonnegative && value - mass < 0.0 {
            f64::NEG_INFINITY
        } else {
            -mass * along - half - self.tuning.gamma * down
        };
        Gain::better([plus, minus], mass)
    }

    #[inline(always)]
    fn record(&mut self, spot: Spot, mass: f64) {
        if self.tuning.moves == Moves::Patch {
            return self.record_of(spot, mass);
        }
        let Some((at, place, image)) = self.place(spot) else {
            return;
        };
        if let Some(value) = self.planes.get_mut(place) {
            *value = T::from_f64(value.to_f64() + mass);
        }
        let range = image..image + self.blur.frame.pixels();
        if let Some(residual) = self.residual.get_mut(range) {
            self.blur.take(at, mass, residual);
        }
    }

    fn chain_over(&mut self, mutations: u64, recorded: u64) {
        let smaller = self.tuning.tau * self.eps;
        let part = match self.tuning.moves {
            Moves::Pixel => 1.0,
            Moves::Patch => ALONE,
        };
        if (recorded as f64) < part * TOO_LITTLE * mutations as f64 && smaller >= self.tuning.eps_min {
            self.eps = smaller;
        }
    }
}

/// Which channel is changed: any of them.
#[inline(always)]
fn channel(count: usize, random: &mut Random) -> usize {
    if count > 1 { random.below(count) } else { 0 }
}
