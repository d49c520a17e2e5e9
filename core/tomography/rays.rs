//! Integrals along rays: the density between cells is d-linear, sampled at even steps.

use super::camera::{Camera, dot};
use crate::exec::{Exec, RowBuffers, for_rows};
use crate::real::Real;
use crate::walk::{Cells, Footprint};

/// A ray's part within the box, from `near` on, in `count` steps.
pub(super) struct Way<const D: usize> {
    start: [f64; D],
    along: [f64; D],
    near: f64,
    count: usize,
    step: f64,
}

impl<const D: usize> Way<D> {
    /// That of the ray through u, v, in steps of at most `step` cells; nothing where it misses the box.
    pub fn through(cells: &Cells<D>, camera: &Camera<D>, at: [f64; 2], step: f64) -> Option<Self> {
        let (start, along) = camera.ray(at);
        let behind = if matches!(camera.lens, super::Lens::Pinhole { .. }) {
            0.0
        } else {
            f64::NEG_INFINITY
        };
        let (mut near, mut far) = (behind, f64::INFINITY);
        for axis in 0..D {
            let side = cells.counts[axis] as f64;
            if along[axis].abs() < 1e-12 {
                if !(start[axis] >= 0.0 && start[axis] <= side) {
                    return None;
                }
                continue;
            }
            let ends = [-start[axis] / along[axis], (side - start[axis]) / along[axis]];
            near = near.max(ends[0].min(ends[1]));
            far = far.min(ends[0].max(ends[1]));
        }
        let length = far - near;
        if !(length > 0.0 && length.is_finite()) {
            return None;
        }
        let count = (length / step) as usize + 1;
        Some(Self {
            start,
            along,
            near,
            count,
            step: length / count as f64,
        })
    }

    /// The cells at the middle of each step, and the step's length.
    #[inline(always)]
    pub fn steps(&self, cells: &Cells<D>) -> impl Iterator<Item = (Footprint<D>, f64)> {
        (0..self.count).map(move |number| {
            let t = self.near + (number as f64 + 0.5) * self.step;
            let mut place = self.start;
            for axis in 0..D {
                place[axis] += t * self.along[axis];
            }
            (cells.around(&place), self.step)
        })
    }
}

/// The integral of a density along the ray through u, v of `camera`, in steps of at most `step` cells.
#[must_use]
pub fn integral<T: Real, const D: usize>(
    cells: &Cells<D>,
    camera: &Camera<D>,
    density: &[T],
    at: [f64; 2],
    step: f64,
) -> f64 {
    let Some(way) = Way::through(cells, camera, at, step) else {
        return 0.0;
    };
    way.steps(cells)
        .map(|(footprint, step)| {
            let value = |corner| {
                let cell = density.get(cells.corner(&footprint, corner));
                cell.map_or(0.0, |cell| cell.to_f64()) * footprint.weight(corner)
            };
            step * (0..1 << D).map(value).sum::<f64>()
        })
        .sum()
}

/// Fills the picture that `camera` takes of a density: the mean over `fine` x `fine` rays in each pixel.
pub fn photograph<T: Real, const D: usize>(
    exec: &dyn Exec,
    cells: &Cells<D>,
    camera: &Camera<D>,
    density: &[T],
    fine: usize,
    picture: &mut [T],
) {
    let fine = fine.max(1);
    let [width, height] = camera.pixels;
    let middle = |number: usize, part: usize| number as f64 + (part as f64 + 0.5) / fine as f64;
    let rays = if D > 2 { fine * fine } else { fine };
    for_rows(exec, height, RowBuffers::fields([picture]), |task| {
        let [row] = task.fields;
        for (column, pixel) in row.iter_mut().enumerate().take(width) {
            let sum: f64 = (0..rays)
                .map(|ray| {
                    let at = [middle(column, ray % fine), middle(task.row, ray / fine)];
                    integral(cells, camera, density, at, 0.25)
                })
                .sum();
            *pixel = T::from_f64(sum / rays as f64);
        }
    });
}

/// Rays along each side of a picture that are tried first,
const FEW: usize = 64;
/// and the most pixels whose rays are all tried then.
const MANY: usize = 1 << 24;

/// Whether any ray of `camera` through the middle of a pixel meets the box, as far as [`MANY`] tell.
pub(super) fn sees_box<const D: usize>(cells: &Cells<D>, camera: &Camera<D>) -> bool {
    let centre = cells.counts.map(|count| 0.5 * count as f64);
    let inside = |place: &[f64; D]| {
        camera.see(place).is_some_and(|seen| {
            let [u, v] = seen.at;
            let [width, height] = camera.pixels.map(|count| count as f64);
            (0.0..width).contains(&u) && (D == 2 || (0.0..height).contains(&v))
        })
    };
    let [width, height] = camera.pixels;
    debug_assert!(dot(&centre, &centre) >= 0.0);
    let meets = |column: usize, row: usize| {
        let at = [column as f64 + 0.5, row as f64 + 0.5];
        Way::through(cells, camera, at, 1.0).is_some()
    };
    // A few rays find a box that fills a part of the picture; all of them one that is a sliver at its side.
    let some = |count: usize| (0..count).step_by(count.div_ceil(FEW).max(1));
    inside(&centre)
        || some(height).any(|row| some(width).any(|column| meets(column, row)))
        || (width.saturating_mul(height) <= MANY
            && (0..height).any(|row| (0..width).any(|column| meets(column, row))))
}
