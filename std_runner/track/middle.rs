//! The plane of a box that pictures show: the middle one, x across and z up; of a plane itself.

use super::errors::faces;
use super::wheel::Plane;
use crate::keyframes::Series;
use thurible_core::Boundary;

/// How that plane lies in the box.
pub(crate) struct Middle<'a> {
    /// Cells along x, y (and z).
    pub cells: &'a [usize],
    /// How each axis ends.
    pub boundary: &'a [Boundary],
    /// Cells a frame that a velocity of 1 is.
    pub unit: f64,
}

impl Middle<'_> {
    /// Cells across and up.
    pub fn sides(&self) -> [usize; 2] {
        match *self.cells {
            [nx, _, nz] => [nx, nz],
            [nx, ny] => [nx, ny],
            _ => [1, 1],
        }
    }

    /// The index in the box of a cell of the plane.
    fn index(&self, cell: usize) -> usize {
        match *self.cells {
            [nx, ny, _] => (cell / nx * ny + ny / 2) * nx + cell % nx,
            _ => cell,
        }
    }

    /// A density there.
    pub fn slice(&self, values: &[f64]) -> Vec<f32> {
        let [nx, ny] = self.sides();
        let at = |cell: usize| values.get(self.index(cell)).map_or(0.0, |&value| value as f32);
        (0..nx * ny).map(at).collect()
    }

    /// A flow there, at the centres of the cells, in cells a frame: `velocity` has its components, of which entry `step` is read.
    pub fn plane(&self, velocity: &mut [Series], step: usize) -> Plane {
        let cells = self.sides();
        let mut flow = vec![[0.0; 2]; cells[0] * cells[1]];
        let last = self.cells.len() - 1;
        for (component, axis) in [0, last].into_iter().enumerate() {
            let Some(series) = velocity.get_mut(axis) else {
                continue;
            };
            let values = series.read(step).unwrap_or_default();
            let periodic = self.boundary.get(axis) == Some(&Boundary::Periodic);
            for (cell, flow) in flow.iter_mut().enumerate() {
                let [low, high] = faces(self.cells, (axis, periodic), self.index(cell));
                let value = |face: usize| values.get(face).copied().unwrap_or_default();
                flow[component] = (0.5 * self.unit * (value(low) + value(high))) as f32;
            }
        }
        Plane { cells, flow }
    }
}
