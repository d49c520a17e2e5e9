//! The layout of a component in memory and in a file.

use super::InputError;
use crate::field::rows;
use crate::grid::Grid;
use crate::real::Real;

/// Elements of one component in a file: z, y, x with x fastest, of faces one more along their own axis when that ends in walls.
pub(super) struct FileLayout {
    n: [usize; 3],
    axis: usize,
    walls: bool,
}

impl FileLayout {
    pub fn new(grid: &Grid, axis: usize) -> Self {
        Self {
            n: grid.n,
            axis,
            walls: grid.axis(axis).open_face(0).is_none(),
        }
    }

    /// That of a field of cells.
    pub fn of_cells(grid: &Grid) -> Self {
        Self {
            n: grid.n,
            axis: 0,
            walls: false,
        }
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

    /// `field` = `scale` times the numbers of a file, 0 on walls.
    pub fn read<T: Real>(&self, faces: &[T], scale: f64, field: &mut [T]) -> Result<(), InputError> {
        if faces.len() != self.len() {
            return Err(InputError::Length {
                expected: self.len(),
                given: faces.len(),
            });
        }
        if let Some(index) = faces.iter().position(|x| !x.is_finite()) {
            return Err(InputError::NotFinite { index });
        }
        let (n, scale) = (self.n[0], T::from_f64(scale));
        self.each_row(|row, file, wall| {
            let from = rows::part(faces, file..file + n).iter();
            let at = rows::part_mut(field, row * n..(row + 1) * n).iter_mut();
            for (x, (value, &face)) in at.zip(from).enumerate() {
                *value = if wall || self.wall_face(x) {
                    T::ZERO
                } else {
                    face * scale
                };
            }
        });
        Ok(())
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

/// A field as it lies in memory, to be read without copying. Number (x, y, z) is `numbers[x + y strides[1] + z strides[2]]` times
/// `unit` in the scene's units. Of a component of a velocity or force it is the one on the low face of cell (x, y, z) along the
/// component's axis; the last faces of a wall axis are not stored, since nothing flows there.
#[derive(Clone, Copy, Debug)]
pub struct Strided<'a, T> {
    /// The numbers from the first on.
    pub numbers: &'a [T],
    /// How many there are along each axis.
    pub extent: [usize; 3],
    /// Numbers from one to the next along each axis.
    pub strides: [usize; 3],
    /// The scene's unit.
    pub unit: f64,
}

impl<'a, T> Strided<'a, T> {
    /// Slot `slot` of a trajectory of `slots`.
    pub(super) fn slot(grid: &Grid, field: &'a [T], slots: usize, slot: usize, unit: f64) -> Self {
        let n = grid.n;
        Self {
            numbers: field.get(slot * n[0]..).unwrap_or(&[]),
            extent: n,
            strides: [1, slots * n[0], slots * n[0] * n[1]],
            unit,
        }
    }
}
