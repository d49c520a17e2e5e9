//! Rectangles of pixels of one channel that change by the same amount at once.

use super::kernel::Blur;
use super::plane::Frame;
use super::prior::{Clusters, ImagePrior, Seen, Thought};
use crate::real::Real;

/// A rectangle of pixels of one channel, within the border.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Patch {
    /// Its first pixel in the bordered plane, across and down.
    pub at: [usize; 2],
    /// Pixels across and down.
    pub size: [usize; 2],
    /// The channel.
    pub channel: usize,
}

impl Patch {
    /// The places of its numbers in the planes.
    pub fn places(&self, frame: &Frame) -> impl Iterator<Item = usize> {
        let ([x, y], [wide, high]) = (self.at, self.size);
        let (row, first) = (frame.wide(), self.channel * frame.unknowns());
        (y..y + high).flat_map(move |y| (x..x + wide).map(move |x| first + y * row + x))
    }
}

/// A patch whose numbers are thought to be so much more.
#[derive(Clone, Copy)]
struct Moved<'a, T> {
    planes: &'a [T],
    patch: Patch,
    mass: f64,
}

impl<T: Real> Thought for Moved<'_, T> {
    #[inline(always)]
    fn instead(&self, place: usize, channel: usize, at: [isize; 2]) -> Option<f64> {
        let within = |axis: usize| {
            let first = self.patch.at[axis] as isize;
            at[axis] >= first && at[axis] < first + self.patch.size[axis] as isize
        };
        let moved = channel == self.patch.channel && within(0) && within(1);
        let value = if moved { self.planes.get(place) } else { None };
        value.map(|value| value.to_f64() + self.mass)
    }
}

impl<T: Real> Seen<'_, T, Moved<'_, T>> {
    /// The sum of all terms that read a number of the patch, and of some that do not.
    fn about(&self, prior: ImagePrior, clusters: &Clusters, patch: &Patch) -> f64 {
        let [x, y] = patch.at.map(|at| at as isize);
        let [wide, high] = patch.size.map(|count| count as isize);
        // Forward differences are read from the pixels before; all else from both sides.
        let ahead = matches!(
            prior,
            ImagePrior::Tv | ImagePrior::Atv | ImagePrior::Mtv | ImagePrior::Clusters
        );
        let after = isize::from(!ahead);
        let mut sum = 0.0;
        for row in y - 1..y + high + after {
            for column in x - 1..x + wide + after {
                sum += match prior {
                    ImagePrior::Clusters => Real::sqrt(self.steep(patch.channel, column, row)),
                    _ => self.term(prior, clusters, patch.channel, column, row),
                };
            }
        }
        if prior == ImagePrior::Clusters {
            // Of its neighbours the differences alone: their own colours stay.
            for row in y..y + high {
                for column in x..x + wide {
                    sum += self.far(clusters, column, row);
                }
            }
        }
        sum
    }
}

/// By how much Gamma changes where all numbers of a patch become `mass` more, and where they become so much less.
#[must_use]
pub fn change_patch<T: Real>(
    prior: ImagePrior,
    clusters: &Clusters,
    frame: &Frame,
    planes: &[T],
    patch: &Patch,
    mass: f64,
) -> [f64; 2] {
    if prior == ImagePrior::None {
        return [0.0; 2];
    }
    let patch = *patch;
    let about = |mass| {
        let moved = Moved { planes, patch, mass };
        Seen::of(frame, planes, moved).about(prior, clusters, &patch)
    };
    let before = about(0.0);
    [about(mass) - before, about(-mass) - before]
}

impl<T: Real> Blur<'_, T> {
    /// Visits the pixels of the image that a patch reaches, each with the sum of the kernel's numbers by which it does.
    #[inline(always)]
    fn cover(&self, patch: &Patch, mut visit: impl FnMut(usize, f64)) {
        let Frame {
            width,
            height,
            border,
            ..
        } = self.frame;
        let reach = 2 * border;
        let span = |at: usize, size: usize, count: usize| at.saturating_sub(reach)..(at + size).min(count);
        // Kernel numbers by which a pixel of the image sees the patch, along an axis.
        let numbers = |pixel: usize, at: usize, size: usize| {
            let last = pixel + reach - at;
            last.saturating_sub(size - 1)..=last.min(reach)
        };
        let ([x, y], [wide, high]) = (patch.at, patch.size);
        for row in span(y, high, height) {
            for column in span(x, wide, width) {
                let pixel = row * width + column;
                let mut sum = 0.0;
                for down in numbers(row, y, high) {
                    for across in numbers(column, x, wide) {
                        sum += self.at(pixel, down * (reach + 1) + across);
                    }
                }
                visit(pixel, sum);
            }
        }
    }

    /// <f, M r> and |M f|^2 of a patch, f being the sum of those of its pixels.
    #[inline(always)]
    pub(super) fn gains_of(&self, patch: &Patch, residual: &[T], mask: &[u16]) -> [f64; 2] {
        let (mut along, mut square) = (0.0, 0.0);
        self.cover(patch, |pixel, sum| {
            if let (Some(residual), Some(&mask)) = (residual.get(pixel), mask.get(pixel)) {
                let value = f64::from(mask) * sum;
                along += value * residual.to_f64();
                square += value * value;
            }
        });
        [along, square]
    }

    /// r -= m f.
    #[inline(always)]
    pub(super) fn take_of(&self, patch: &Patch, mass: f64, residual: &mut [T]) {
        self.cover(patch, |pixel, sum| {
            if let Some(residual) = residual.get_mut(pixel) {
                *residual = T::from_f64(residual.to_f64() - mass * sum);
            }
        });
    }
}
