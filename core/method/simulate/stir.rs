//! Noise without divergence that stirs a guided flow (Bridson, Houriham & Nordenstam 2007, Curl-noise for procedural fluid flow).
//!
//! ```text
//! v += a c / |c|,   c = curl (ramp B n)
//! ```
//!
//! n is white noise, anew in every step: in 2D at the corners of cells, in 3D at their edges, a component along each. B is a Gaussian, |c| the root
//! mean square, a the amplitude in cells a step. The ramp leads a component to 0 within two standard deviations of the walls that it lies along, so
//! that nothing flows through them.

use crate::exec::{Exec, RowBuffers, for_rows};
use crate::field::{Vector, VectorMut, reborrow, rows, sums, view};
use crate::grid::gaussian::Gaussian;
use crate::grid::{Grid, Side};
use crate::memory::{Pool, pooled};
use crate::operators::{blur, curl::turns};
use crate::real::Real;
use crate::walk::Random;

/// How much noise, and which.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Noise {
    /// a: its root mean square, in cells a step; 0 for none.
    pub strength: f64,
    /// Standard deviation of the Gaussian, in cells.
    pub sigma: f64,
    /// Which noise.
    pub seed: usize,
}

impl Default for Noise {
    fn default() -> Self {
        Self {
            strength: 0.0,
            sigma: 2.0,
            seed: 1,
        }
    }
}

/// A potential that differs by no more than so many rounding errors from cell to cell is flat.
const FLAT: f64 = 16.0;

/// The workspace: rows and taps of the Gaussian.
pub struct Stir<'a, T> {
    grid: &'a Grid,
    gaussian: Gaussian,
    noise: Noise,
    scratch: &'a mut [T],
}

impl<'a, T: Real> Stir<'a, T> {
    /// Takes it from a pool; nothing where there is no noise.
    pub fn carve(grid: &'a Grid, noise: Noise, threads: usize, pool: &mut Pool<'a, T>) -> Option<Self> {
        let gaussian = Gaussian::of(noise.sigma);
        let rows = pooled(blur::along_len(grid, gaussian.radius, threads));
        (noise.strength > 0.0).then(|| Self {
            grid,
            gaussian,
            noise,
            scratch: pool.take("noise, blurred", rows),
        })
    }

    /// `out` = the noise of a step, of no certain strength. `potential` and `work` are overwritten.
    pub fn noise(
        &mut self,
        exec: &dyn Exec,
        step: usize,
        potential: &mut VectorMut<'_, T>,
        work: &mut [T],
        out: &mut VectorMut<'_, T>,
    ) {
        let grid = self.grid;
        for (axis, values) in potential.iter_mut().enumerate() {
            if is_along(grid, axis) {
                let mut random = Random::new(self.noise.seed as u64, step as u64, axis as u64);
                values
                    .iter_mut()
                    .for_each(|value| *value = T::from_f64(random.normal()));
                self.smoothen(exec, axis, values, work);
            }
        }
        let given = view(potential);
        for_rows(exec, grid.rows(), RowBuffers::fields(reborrow(out)), |task| {
            for (axis, out) in task.fields.into_iter().enumerate().take(grid.dims) {
                curl_in_row(grid, (axis, task.row), given, out);
            }
        });
    }

    /// Gives the noise its strength. `sums` holds a value a row.
    pub fn strengthen(&self, exec: &dyn Exec, noise: &mut VectorMut<'_, T>, sums: &mut [f64]) {
        let grid = self.grid;
        let squares = sums::sum_squares(exec, grid, 1, view(noise), sums);
        let size = libm::sqrt(squares / grid.cells() as f64);
        // A potential of at most 1 in all, more or less, whose differences are rounding errors.
        let scale = if size * grid.h[0] > FLAT * T::EPSILON {
            self.noise.strength * grid.h[0] / size
        } else {
            0.0
        };
        for component in noise.iter_mut().take(grid.dims) {
            rows::scale_in_place(component, T::from_f64(scale));
        }
    }

    /// Blurs the component of a potential along `axis` and leads it to 0 at walls.
    fn smoothen(&mut self, exec: &dyn Exec, axis: usize, values: &mut [T], work: &mut [T]) {
        let (grid, gaussian, width) = (self.grid, self.gaussian, 2.0 * self.noise.sigma);
        for along in 0..grid.dims {
            blur::along(exec, (grid, along), gaussian, values, work, self.scratch);
            values.copy_from_slice(work);
        }
        let along = if grid.dims == 2 { 2 } else { axis };
        for_rows(exec, grid.rows(), RowBuffers::fields([values]), |task| {
            let [values] = task.fields;
            for (x, value) in values.iter_mut().enumerate() {
                let at = grid.cell_at(task.row, x);
                let walls = (0..grid.dims).filter(|&other| other != along && !grid.axis(other).is_ring());
                let ramps = walls.map(|other| {
                    let near = at[other].min(grid.n[other] - at[other]);
                    ramp(near as f64 / width)
                });
                *value = *value * T::from_f64(ramps.product());
            }
        });
    }
}

/// Whether a potential has a component along an axis: in 2D it has the one across the plane.
fn is_along(grid: &Grid, axis: usize) -> bool {
    grid.dims == 3 || axis == 0
}

/// From 0 at 0 to 1 from 1 on, with two derivatives.
fn ramp(x: f64) -> f64 {
    let x = x.clamp(0.0, 1.0);
    x * x * x * (10.0 + x * (6.0 * x - 15.0))
}

/// A row of the faces of `axis` of the curl of a potential.
fn curl_in_row<T: Real>(grid: &Grid, (axis, row): (usize, usize), potential: Vector<'_, T>, out: &mut [T]) {
    for (x, out) in out.iter_mut().enumerate() {
        let here = grid.cell_at(row, x);
        let value = |component: usize, at: [usize; 3]| {
            let values = potential.get(component).copied().unwrap_or(&[]);
            values.get(grid.index(at)).map_or(0.0, |value| value.to_f64())
        };
        let sum = turns(grid.dims, axis)
            .into_iter()
            .fold(0.0, |sum, (component, along, sign)| {
                // Beyond the last cell is the wall, where the potential is 0.
                let next = grid.beside(here, along, Side::High);
                let next = next.map_or(0.0, |next| value(component, next));
                sum + sign * (next - value(component, here)) / grid.h[along]
            });
        *out = T::from_f64(sum);
    }
}
