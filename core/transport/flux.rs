//! The rows that a face flux reads, along any axis.

use crate::field::Vector;
use crate::grid::Grid;
use crate::problem::Scheme;
use crate::real::Real;

/// Extra numbers of a row with its neighbours along x.
pub const HALO: usize = 4;
/// Rows of scratch of a task: two fields of cells and the faces along x with their neighbours, and a row of zeros.
pub const SCRATCH_ROWS: usize = 4;

/// Interpolation to a face from upstream, rho_f = w[0] downstream + w[1] upstream - w[2] next upstream (Leonard 1979).
#[must_use]
pub fn weights<T: Real>(scheme: Scheme) -> [T; 3] {
    match scheme {
        Scheme::Central => [0.5, 0.5, 0.0],
        _ => [0.375, 0.75, 0.125],
    }
    .map(T::from_f64)
}

/// A row of cells and the two next ones on either side along an axis: offsets -2 .. 2.
pub type Cells<'a, T> = [&'a [T]; 5];

/// The rows of a field along all axes.
pub type AllCells<'a, T> = [Cells<'a, T>; 3];

/// The faces -1, 0, 1, 2 along an axis: face 0 is the low and face 1 the high face of the row's cells.
pub type Faces<'a, T> = [&'a [T]; 4];

/// A row and those at offsets -2 .. 2 from it along y and z.
#[derive(Clone, Copy, Debug)]
pub struct Around<'g> {
    grid: &'g Grid,
    /// The row itself.
    pub row: usize,
    at: [usize; 2],
}

impl<'g> Around<'g> {
    /// Those around `row`.
    #[inline]
    pub fn new(grid: &'g Grid, row: usize) -> Self {
        Self { grid, row, at: grid.row_at(row) }
    }

    /// The row at an offset along y or z, or `None` beyond a wall.
    #[inline]
    pub fn beside(&self, axis: usize, offset: isize) -> Option<usize> {
        let (n, place) = (self.grid.n[axis] as isize, self.at[axis - 1] as isize + offset);
        let around = if place < 0 { n } else { -n * isize::from(place >= n) };
        let stride = if axis == 1 { 1 } else { self.grid.n[1] as isize };
        (around == 0 || self.grid.periodic[axis]).then(|| self.row.wrapping_add_signed((offset + around) * stride))
    }

    /// The same, but at a wall the last row stands for those beyond.
    #[inline]
    fn nearest(&self, axis: usize, offset: isize) -> usize {
        self.beside(axis, offset).or(self.beside(axis, offset.signum())).unwrap_or(self.row)
    }

    /// Whether `of` holds for the row or for one beside it.
    #[inline]
    pub fn any(&self, of: impl Fn(usize) -> bool) -> bool {
        of(self.row) || (1..self.grid.dims).any(|axis| [-2, -1, 1, 2].into_iter().any(|offset| self.beside(axis, offset).is_some_and(&of)))
    }
}

/// The rows of `field` around one; `halo` receives the row with its neighbours along x.
pub fn cells<'a, T: Real>(grid: &Grid, around: &Around<'_>, field: &'a [T], halo: &'a mut [T]) -> AllCells<'a, T> {
    let n = grid.n[0];
    let of = |row: usize| &field[row * n..(row + 1) * n];
    let here = of(around.row);
    halo[2..n + 2].copy_from_slice(here);
    for (at, from) in [(0, n - 2), (1, n - 1)] {
        halo[at] = if grid.periodic[0] { here[from] } else { here[0] };
        halo[n + 2 + at] = if grid.periodic[0] { here[at] } else { here[n - 1] };
    }
    let halo = &*halo;
    let along = |axis: usize| -> Cells<'a, T> {
        if axis >= grid.dims {
            return [here; 5];
        }
        let of = |offset: isize| of(around.nearest(axis, offset));
        [of(-2), of(-1), here, of(1), of(2)]
    };
    [[&halo[..n], &halo[1..n + 1], &halo[2..n + 2], &halo[3..n + 3], &halo[4..n + 4]], along(1), along(2)]
}

/// The faces around a row along all axes; `halo` receives those along x, `zeros` stands for walls.
pub fn faces<'a, T: Real>(grid: &Grid, around: &Around<'_>, v: Vector<'a, T>, halo: &'a mut [T], zeros: &'a [T]) -> [Faces<'a, T>; 3] {
    let n = grid.n[0];
    let here = &v[0][around.row * n..(around.row + 1) * n];
    let wrap = |x: T| if grid.periodic[0] { x } else { T::ZERO };
    halo[0] = wrap(here[n - 1]);
    halo[1..=n].copy_from_slice(here);
    halo[n + 1] = wrap(here[0]);
    halo[n + 2] = wrap(here[1]);
    let halo = &*halo;
    let along = |axis: usize| -> Faces<'a, T> {
        if axis >= grid.dims {
            return [zeros; 4];
        }
        let of = |offset: isize| around.beside(axis, offset).map_or(zeros, |row| &v[axis][row * n..(row + 1) * n]);
        [of(-1), of(0), of(1), of(2)]
    };
    [[&halo[..n], &halo[1..n + 1], &halo[2..n + 2], &halo[3..n + 3]], along(1), along(2)]
}
