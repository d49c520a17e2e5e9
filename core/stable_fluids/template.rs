//! Templates at cell centres, and what the covector of a force is for their numbers.
//!
//! The weight w = exp(-|x - c|^2 / (2 s^2)) is a product of one factor an axis, so a step takes as many exponentials as the box is long.
//!
//! ```text
//! wind      f = a w
//! vortex    f = (a/s) w (-(y - c_y), x - c_x) in 2D,   (w/s) a x (x - c) in 3D
//! ```

use super::cells::Cells;
use crate::exec::{Exec, RowBuffers, for_rows};
use crate::field::VectorMut;
use crate::grid::Grid;
use crate::problem::TemplateKind;
use crate::real::Real;

/// Sums that a template takes: of an amplitude, of its middle, of its radius.
pub const SUMS: usize = 7;

/// A template in a step.
#[derive(Clone, Copy)]
pub struct Shape<'a> {
    cells: &'a Cells,
    kind: TemplateKind,
    center: [f64; 3],
    radius: f64,
    amplitude: [f64; 3],
    /// The factors of w along x, y and z, one after the other.
    factors: &'a [f64],
}

impl<'a> Shape<'a> {
    /// Numbers of the factors.
    #[must_use]
    pub fn len(cells: &Cells) -> usize {
        cells.n.iter().sum()
    }

    /// The template with this middle, radius and amplitude.
    pub fn new(
        cells: &'a Cells,
        kind: TemplateKind,
        (center, radius): ([f64; 3], f64),
        amplitude: [f64; 3],
        factors: &'a mut [f64],
    ) -> Self {
        let mut places = factors.iter_mut();
        for (axis, (&n, c)) in cells.n.iter().zip(center).enumerate() {
            for (cell, factor) in places.by_ref().take(n).enumerate() {
                let d = if axis < cells.dims {
                    place(cells, cell) - c
                } else {
                    0.0
                };
                *factor = libm::exp(-0.5 * d * d / (radius * radius));
            }
        }
        Self {
            cells,
            kind,
            center,
            radius,
            amplitude,
            factors,
        }
    }

    /// The weights of a row without the factor of the row itself, that factor, and x - c of it along y and z.
    fn row(&self, row: usize) -> (&'a [f64], f64, [f64; 2]) {
        let [nx, ny, _] = self.cells.n;
        let [y, z] = self.cells.row_at(row);
        let factor = |place: usize| self.factors.get(place).copied().unwrap_or(0.0);
        let [_, cy, cz] = self.center;
        let away = [place(self.cells, y) - cy, place(self.cells, z) - cz];
        let weight = factor(nx + y) * factor(nx + ny + z);
        (self.factors.get(..nx).unwrap_or_default(), weight, away)
    }

    /// `out += f`, without ghosts.
    pub fn add<T: Real>(&self, exec: &dyn Exec, grid: &Grid, out: &mut VectorMut<'_, T>) {
        let fields = crate::field::reborrow(out);
        for_rows(exec, grid.rows(), RowBuffers::fields(fields), |mut task| {
            let (along, weight, [dy, dz]) = self.row(task.row);
            for (x, factor) in along.iter().enumerate() {
                let d = [place(self.cells, x) - self.center[0], dy, dz];
                let w = weight * factor;
                let push = match self.kind {
                    TemplateKind::Wind => self.amplitude.map(|a| a * w),
                    _ => cross(self.axis(), d).map(|turn| turn * w / self.radius),
                };
                for (out, push) in task.fields.iter_mut().zip(push) {
                    if let Some(out) = out.get_mut(x) {
                        *out += T::from_f64(push);
                    }
                }
            }
        });
    }

    /// What the covector b of the force is for the amplitude (three numbers), the middle (three) and the logarithm of the radius. `b` tells it at
    /// a cell by row and place.
    pub fn adjoint(
        &self,
        exec: &dyn Exec,
        grid: &Grid,
        moves: bool,
        b: impl Fn(usize, usize) -> [f64; 3] + Sync,
        sums: &mut [f64],
    ) -> [f64; SUMS] {
        let sums = sums.get_mut(..SUMS * grid.rows()).unwrap_or_default();
        for_rows(
            exec,
            grid.rows(),
            RowBuffers::<f64, 0>::sums(&mut *sums),
            |task| {
                let (along, weight, [dy, dz]) = self.row(task.row);
                let mut own = [0.0; SUMS];
                for (x, factor) in along.iter().enumerate() {
                    let d = [place(self.cells, x) - self.center[0], dy, dz];
                    let parts = self.cell(weight * factor, d, b(task.row, x), moves);
                    own.iter_mut().zip(parts).for_each(|(sum, part)| *sum += part);
                }
                task.sums.copy_from_slice(&own);
            },
        );
        core::array::from_fn(|which| sums.iter().skip(which).step_by(SUMS).sum())
    }

    /// What one cell adds to the sums.
    fn cell(&self, w: f64, mut d: [f64; 3], b: [f64; 3], moves: bool) -> [f64; SUMS] {
        if self.cells.dims == 2 {
            d[2] = 0.0;
        }
        let inverse = 1.0 / self.radius;
        let turned = cross(d, b);
        let (by_amplitude, along, pulled, size) = match self.kind {
            TemplateKind::Wind => (b.map(|b| w * b), w * dot(self.amplitude, b), [0.0; 3], 0.0),
            _ => {
                let along = w * inverse * dot(self.axis(), turned);
                let by = turned.map(|turn| w * inverse * turn);
                let by = if self.cells.dims == 2 {
                    [by[2], 0.0, 0.0]
                } else {
                    by
                };
                (
                    by,
                    along,
                    cross(b, self.axis()).map(|part| w * inverse * part),
                    along,
                )
            }
        };
        let mut sums = [0.0; SUMS];
        sums.iter_mut()
            .zip(by_amplitude)
            .for_each(|(sum, part)| *sum = part);
        if moves {
            let scale = along * inverse * inverse;
            for ((sum, d), pulled) in sums.iter_mut().skip(3).zip(d).zip(pulled) {
                *sum = scale * d - pulled;
            }
            if let Some(sum) = sums.last_mut() {
                *sum = scale * dot(d, d) - size;
            }
        }
        sums
    }

    /// The axis of a vortex times its strength: along z in 2D.
    fn axis(&self) -> [f64; 3] {
        let [a, ..] = self.amplitude;
        if self.cells.dims == 2 {
            [0.0, 0.0, a]
        } else {
            self.amplitude
        }
    }
}

/// Where cell `cell` of an axis is, from 0.
fn place(cells: &Cells, cell: usize) -> f64 {
    (cell as f64 + 0.5) / cells.longest as f64
}

fn cross([ax, ay, az]: [f64; 3], [bx, by, bz]: [f64; 3]) -> [f64; 3] {
    [ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx]
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a.iter().zip(b).fold(0.0, |sum, (a, b)| sum + a * b)
}
