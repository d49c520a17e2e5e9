//! Fields laid out by diagonals x + y = const of each plane, the cells of a diagonal side by side.

use super::cells::Cells;
use crate::real::Real;

/// Diagonals that are one task where there are enough of them.
const DIAGONALS: usize = 8;
/// With so many cells more than two sides there are: three longer sides are then the room of both fields.
const FEW: usize = 12;

/// Where cells lie in a field that is laid out by diagonals.
#[derive(Clone, Copy, Debug)]
pub struct Skew {
    /// Numbers of a diagonal: the cells of the shorter axis, x or y, with ghosts.
    pub width: usize,
    /// Cells of the shorter of x and y, and of the longer.
    pub sides: [usize; 2],
    /// Whether x is the shorter one.
    pub along_x: bool,
    /// Diagonals of a plane.
    pub diagonals: usize,
    /// Diagonals of a task.
    pub group: usize,
}

impl Skew {
    /// That of some cells.
    #[must_use]
    pub fn new(cells: &Cells) -> Self {
        let [x, y, _] = cells.n;
        let sides = [x.min(y), x.max(y)];
        let diagonals = x + y + 3;
        let group = match cells.dims {
            3 => diagonals,
            // A box of few cells has no room for more of them.
            _ if 2 * sides[0] + FEW <= 3 * sides[1] => DIAGONALS,
            _ => 1,
        };
        Self {
            width: sides[0] + 2,
            sides,
            along_x: x <= y,
            diagonals: diagonals.next_multiple_of(group),
            group,
        }
    }

    /// Numbers of a plane.
    pub fn plane(&self) -> usize {
        self.diagonals * self.width
    }

    /// Numbers of a field.
    #[must_use]
    pub fn len(&self, cells: &Cells) -> usize {
        self.plane() * if cells.dims == 3 { cells.n[2] + 2 } else { 1 }
    }

    /// How far apart neighbours along x and y lie.
    pub fn strides(&self) -> [usize; 2] {
        if self.along_x {
            [self.width + 1, self.width]
        } else {
            [self.width, self.width + 1]
        }
    }

    /// Where the first cell of row `y` lies in a plane.
    fn first(&self, y: usize) -> usize {
        let [along_x, along_y] = self.strides();
        along_x + (y + 1) * along_y
    }

    /// Writes the cells of row `y` of a plane.
    pub fn write<T: Real>(&self, plane: &mut [T], y: usize, values: impl Iterator<Item = T>) {
        let places = plane.get_mut(self.first(y)..).unwrap_or_default();
        let places = places.iter_mut().step_by(self.strides()[0]);
        places.zip(values).for_each(|(place, value)| *place = value);
    }

    /// The cells of row `row` of a field.
    pub fn read<'f, T: Real>(
        &self,
        cells: &Cells,
        field: &'f [T],
        row: usize,
    ) -> impl Iterator<Item = T> + use<'f, T> {
        let [y, z] = cells.row_at(row);
        let plane = if cells.dims == 3 {
            (z + 1) * self.plane()
        } else {
            0
        };
        let places = field.get(plane + self.first(y)..).unwrap_or_default();
        places.iter().step_by(self.strides()[0]).take(cells.n[0]).copied()
    }
}
