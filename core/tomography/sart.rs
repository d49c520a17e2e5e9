//! SART (Andersen & Kak 1984): camera after camera, what a ray misses is spread over the cells that it passes.
//!
//! ```text
//! p += relax F_k^T ((q_k - F_k p) / row sums) / column sums
//! ```
//!
//! with F_k the ray-driven projection of camera k, samples every half cell, and p >= 0.

use super::camera::Camera;
use super::problem::Tomography;
use super::rays::Way;
use super::reconstruction::Buffers;
use crate::real::Real;
use crate::walk::Cells;

/// Cells between two samples of a ray, at most.
const STEP: f64 = 0.5;
/// Cameras are taken in the order of the fractions of k times this.
const GOLDEN: f64 = 0.618034;

/// One pass over all cameras.
pub(super) fn sweep<T: Real, const D: usize>(
    problem: &Tomography<'_, D>,
    buffers: &mut Buffers<'_, T>,
    relax: f64,
) {
    let turn = |camera: usize| {
        let place = camera as f64 * GOLDEN;
        place - place as usize as f64
    };
    let count = problem.cameras.len();
    let mut last = -1.0;
    for _ in 0..count {
        // The next in the order of the fractions, which are all different.
        let next = (0..count)
            .filter(|&camera| turn(camera) > last)
            .min_by(|&one, &other| turn(one).total_cmp(&turn(other)));
        let Some(number) = next else { break };
        last = turn(number);
        let start = problem.cameras.iter().take(number).map(Camera::len).sum();
        if let Some(camera) = problem.cameras.get(number) {
            update(&problem.cells, camera, start, buffers, relax);
        }
    }
}

/// The residual of the density that is there: what its rays miss.
pub(super) fn look<T: Real, const D: usize>(problem: &Tomography<'_, D>, buffers: &mut Buffers<'_, T>) {
    let mut start = 0;
    for camera in problem.cameras {
        each_ray(&problem.cells, camera, |pixel, way| {
            let sum = through(&problem.cells, way, buffers.density)[0];
            let measured = buffers.measured.get(start + pixel).map_or(0.0, |q| q.to_f64());
            if let Some(residual) = buffers.residual.get_mut(start + pixel) {
                *residual = T::from_f64(measured - sum);
            }
        });
        start += camera.len();
    }
}

fn update<T: Real, const D: usize>(
    cells: &Cells<D>,
    camera: &Camera<D>,
    start: usize,
    buffers: &mut Buffers<'_, T>,
    relax: f64,
) {
    buffers.change.fill(T::ZERO);
    buffers.weights.fill(T::ZERO);
    each_ray(cells, camera, |pixel, way| {
        let Some(way) = way else { return };
        let [sum, length] = through(cells, Some(way), buffers.density);
        let measured = buffers.measured.get(start + pixel).map_or(0.0, |q| q.to_f64());
        let missed = (measured - sum) / length.max(f64::MIN_POSITIVE);
        for (footprint, step) in way.steps(cells) {
            cells.add(buffers.change, &footprint, step * missed);
            cells.add(buffers.weights, &footprint, step);
        }
    });
    let changes = buffers.change.iter().zip(&*buffers.weights);
    for (cell, (change, weight)) in buffers.density.iter_mut().zip(changes) {
        if weight.to_f64() > 0.0 {
            let new = cell.to_f64() + relax * change.to_f64() / weight.to_f64();
            *cell = T::from_f64(new.max(0.0));
        }
    }
}

/// Every pixel of a camera with its ray's way through the box.
fn each_ray<const D: usize>(
    cells: &Cells<D>,
    camera: &Camera<D>,
    mut visit: impl FnMut(usize, Option<&Way<D>>),
) {
    let [width, height] = camera.pixels;
    for pixel in 0..width * height {
        let at = [(pixel % width) as f64 + 0.5, (pixel / width) as f64 + 0.5];
        let way = Way::through(cells, camera, at, STEP);
        visit(pixel, way.as_ref());
    }
}

/// The integral of the density along a way, and its length.
fn through<T: Real, const D: usize>(cells: &Cells<D>, way: Option<&Way<D>>, density: &[T]) -> [f64; 2] {
    let (mut sum, mut length) = (0.0, 0.0);
    for (footprint, step) in way.into_iter().flat_map(|way| way.steps(cells)) {
        for corner in 0..1 << D {
            let cell = density.get(cells.corner(&footprint, corner));
            sum += step * footprint.weight(corner) * cell.map_or(0.0, |cell| cell.to_f64());
        }
        length += step;
    }
    [sum, length]
}
