//! The layout of a velocity or force in a file.

use crate::grid::Grid;

/// Faces of one component in a file: z, y, x with x fastest, one more along its own axis when that ends in walls.
pub(super) struct FileLayout {
    n: [usize; 3],
    axis: usize,
    walls: bool,
}

impl FileLayout {
    pub fn new(grid: &Grid, axis: usize) -> Self {
        Self { n: grid.n, axis, walls: !grid.periodic[axis] }
    }

    pub fn extent(&self, axis: usize) -> usize {
        self.n[axis] + usize::from(self.walls && axis == self.axis)
    }

    pub fn len(&self) -> usize {
        (0..3).map(|axis| self.extent(axis)).product()
    }

    /// Whether face `x` of a row is on a wall.
    pub fn wall_face(&self, x: usize) -> bool {
        self.walls && self.axis == 0 && x == 0
    }

    /// Calls `visit` with every stored row, where it begins in the file, and whether all of it is on a wall.
    pub fn each_row(&self, mut visit: impl FnMut(usize, usize, bool)) {
        for z in 0..self.n[2] {
            for y in 0..self.n[1] {
                let wall = self.walls && (self.axis == 1 && y == 0 || self.axis == 2 && z == 0);
                visit(z * self.n[1] + y, (z * self.extent(1) + y) * self.extent(0), wall);
            }
        }
    }
}
