//! The same walk with novel views: what cameras that measured nothing would see is kept, sample by sample, be it beside the density or in
//! its place, and priors may be charged on it.

use super::camera::Camera;
use super::pixels::Touched;
use super::terrain::Ground;
use crate::real::Real;
use crate::simd::multiversion;
use crate::walk::prior::{change_at, whole};
use crate::walk::{Cells, Course, Gain, Prior, Random, Terrain};

multiversion! {
    /// Up to `most` mutations more.
    pub(super) fn walk[T: Real, const D: usize](
        gallery: &mut Gallery<'_, T, D>,
        course: &mut Course<[f64; D]>,
        most: u64,
    ) {
        course.advance(gallery, most);
    }
}

/// What is walked on, and the novel views.
pub(super) struct Gallery<'a, T, const D: usize> {
    pub ground: Ground<'a, T, D>,
    pub cameras: &'a [Camera<D>],
    /// F p of the novel views, one after the other.
    pub images: &'a mut [T],
}

/// Visits each camera with its picture.
#[inline(always)]
fn each<'a, T, const D: usize>(
    cameras: &'a [Camera<D>],
    images: &'a [T],
    mut visit: impl FnMut(&'a Camera<D>, &'a [T]),
) {
    let mut rest = images;
    for camera in cameras {
        let Some((image, after)) = rest.split_at_checked(camera.len()) else {
            return;
        };
        rest = after;
        visit(camera, image);
    }
}

/// Gamma of all novel views.
pub(super) fn gamma<T: Real, const D: usize>(prior: Prior, cameras: &[Camera<D>], images: &[T]) -> f64 {
    let Some(prior) = prior.on_images() else {
        return 0.0;
    };
    let mut sum = 0.0;
    each(cameras, images, |camera, image| {
        sum += if D > 2 {
            let counts = camera.pixels;
            whole(prior, &Cells { counts }, image)
        } else {
            let counts = [camera.pixels[0]];
            whole(prior, &Cells { counts }, image)
        };
    });
    sum
}

impl<T: Real, const D: usize> Gallery<'_, T, D> {
    /// The change of a prior on the novel views by a sample of +`mass` and of -`mass`.
    #[inline(always)]
    fn change(&self, prior: Prior, place: &[f64; D], mass: f64) -> [f64; 2] {
        let mut sums = [0.0; 2];
        each(self.cameras, self.images, |camera, image| {
            let Some(seen) = camera.see(place) else { return };
            let (touched, pixels) = (Touched::about(seen.at), &camera.pixels);
            let mass = mass * seen.weight;
            let [up, down] = if D > 2 {
                let counts = *pixels;
                touched.spot::<2>(pixels).map_or([0.0; 2], |spot| {
                    change_at(prior, &Cells { counts }, image, &spot, mass)
                })
            } else {
                let counts = [pixels[0]];
                touched.spot::<1>(pixels).map_or([0.0; 2], |spot| {
                    change_at(prior, &Cells { counts }, image, &spot, mass)
                })
            };
            sums[0] += up;
            sums[1] += down;
        });
        sums
    }

    /// Whether a sample makes a pixel of a novel view fall below 0.
    fn falls(&self, place: &[f64; D], mass: f64) -> bool {
        let mut least = 0.0_f64;
        each(self.cameras, self.images, |camera, image| {
            let Some(seen) = camera.see(place) else { return };
            Touched::about(seen.at).each::<D>(&camera.pixels, |pixel, weight| {
                if let Some(pixel) = image.get(pixel)
                    && weight > 0.0
                {
                    least = least.min(pixel.to_f64() + mass * seen.weight * weight);
                }
            });
        });
        least < 0.0
    }
}

impl<T: Real, const D: usize> Terrain for Gallery<'_, T, D> {
    type Place = [f64; D];

    #[inline(always)]
    fn anywhere(&self, random: &mut Random) -> [f64; D] {
        self.ground.anywhere(random)
    }

    #[inline(always)]
    fn near(&self, from: [f64; D], random: &mut Random) -> [f64; D] {
        self.ground.near(from, random)
    }

    #[inline(always)]
    fn gain(&self, place: [f64; D]) -> Gain {
        let ground = &self.ground;
        let charge = |mass| match ground.prior.on_images() {
            Some(prior) => Some(self.change(prior, &place, mass)),
            None => ground.charge(&place, mass),
        };
        let falls = |mass| {
            if ground.density.is_empty() {
                self.falls(&place, mass)
            } else {
                ground.falls(&place, mass)
            }
        };
        ground.weigh(&place, charge, falls)
    }

    #[inline(always)]
    fn record(&mut self, place: [f64; D], mass: f64) {
        self.ground.record(place, mass);
        let mut rest = &mut *self.images;
        for camera in self.cameras {
            let Some((image, after)) = rest.split_at_mut_checked(camera.len()) else {
                return;
            };
            rest = after;
            let Some(seen) = camera.see(&place) else { continue };
            Touched::about(seen.at).each::<D>(&camera.pixels, |pixel, weight| {
                if let Some(pixel) = image.get_mut(pixel) {
                    *pixel = T::from_f64(pixel.to_f64() + mass * seen.weight * weight);
                }
            });
        }
    }
}
