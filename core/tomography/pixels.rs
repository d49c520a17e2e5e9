//! The pixels that a place touches: the two (in a plane) or four nearest its image, with bilinear weights.

use super::camera::Camera;
use crate::real::Real;
use crate::walk::Cells;
use crate::walk::prior::Spot;

/// The pixels about a point of a picture.
#[derive(Clone, Copy)]
pub(super) struct Touched {
    /// The lower of two neighbours across, and down.
    low: [i64; 2],
    /// What the upper ones get.
    part: [f64; 2],
}

/// The next lower whole number; far numbers become the farthest.
#[inline(always)]
fn floor(x: f64) -> i64 {
    let cut = x as i64;
    cut - i64::from((cut as f64) > x)
}

impl Touched {
    #[inline(always)]
    pub fn about([u, v]: [f64; 2]) -> Self {
        let [u, v] = [u - 0.5, v - 0.5];
        let low = [floor(u), floor(v)];
        Self {
            low,
            part: [u - low[0] as f64, v - low[1] as f64],
        }
    }

    /// The same for a prior on a picture of `A` axes; nothing where all of it is off the picture.
    #[inline(always)]
    pub fn spot<const A: usize>(&self, pixels: &[usize; 2]) -> Option<Spot<A>> {
        let on = |axis: usize| self.low[axis] >= -1 && self.low[axis] < pixels[axis] as i64;
        let all = on(0) && (A < 2 || on(1));
        all.then(|| Spot {
            base: core::array::from_fn(|axis| self.low[axis] as isize),
            part: core::array::from_fn(|axis| self.part[axis]),
        })
    }

    /// The pixels that the picture has, each with its place there and its weight.
    #[inline(always)]
    pub fn each<const D: usize>(&self, pixels: &[usize; 2], mut visit: impl FnMut(usize, f64)) {
        let [width, height] = pixels.map(|count| count as i64);
        let [across, down] = self.part;
        let rows = if D > 2 { 2 } else { 1 };
        for row in 0..rows {
            let v = if D > 2 { self.low[1] + row } else { 0 };
            let down = match (D > 2, row) {
                (false, _) => 1.0,
                (_, 0) => 1.0 - down,
                _ => down,
            };
            if v < 0 || v >= height {
                continue;
            }
            let u = self.low[0];
            let start = v * width + u;
            if u >= 0 && u < width {
                visit(start as usize, down * (1.0 - across));
            }
            if u >= -1 && u + 1 < width {
                visit((start + 1) as usize, down * across);
            }
        }
    }
}

/// Adds F p to `image`, the picture of `camera`: every cell is a sample at its centre.
pub fn project<T: Real, const D: usize>(
    cells: &Cells<D>,
    camera: &Camera<D>,
    density: &[T],
    scale: f64,
    image: &mut [T],
) {
    for (index, value) in density.iter().enumerate() {
        let mass = value.to_f64() * scale;
        if mass == 0.0 {
            continue;
        }
        let centre = cells.cell(index).map(|at| at as f64 + 0.5);
        let Some(seen) = camera.see(&centre) else { continue };
        Touched::about(seen.at).each::<D>(&camera.pixels, |pixel, weight| {
            if let Some(pixel) = image.get_mut(pixel) {
                *pixel = T::from_f64(pixel.to_f64() + mass * seen.weight * weight);
            }
        });
    }
}
