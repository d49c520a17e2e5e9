//! The rows that a face flux reads, along any axis.

use crate::field::Vector;
use crate::grid::Grid;
use crate::problem::Scheme;
use crate::real::Real;

/// Extra numbers of a row with its neighbours along x.
pub const HALO: usize = 4;
/// Rows of scratch of a task: two fields of cells and the faces along x with their neighbours.
pub const SCRATCH_ROWS: usize = 3;

/// Interpolation to a face from upstream, rho_f = w[0] downstream + w[1] upstream - w[2] next upstream (Leonard 1979).
#[must_use]
pub fn weights<T: Real>(scheme: Scheme) -> [T; 3] {
    match scheme {
        Scheme::Central => [0.5, 0.5, 0.0],
        _ => [0.375, 0.75, 0.125],
    }
    .map(T::from_f64)
}

/// A row and the rows around it.
#[derive(Clone, Copy, Debug)]
pub struct Rows<'a, T> {
    /// The row with its neighbours along x.
    pub x: &'a [T],
    /// The rows beside it along y and z.
    pub beside: [[&'a [T]; 4]; 2],
}

impl<'a, T> Rows<'a, T> {
    /// Exactly `n` numbers of the rows beside it along y or z: compilers then know how far they go.
    #[inline(always)]
    pub fn along(&self, axis: usize, n: usize) -> [&'a [T]; 4] {
        let [a, b, c, d] = self.beside[axis - 1];
        [&a[..n], &b[..n], &c[..n], &d[..n]]
    }
}

/// A row and those at offsets -2, -1, 1, 2 from it along y and z; at a wall the last row stands for those beyond.
#[derive(Clone, Copy, Debug)]
pub struct Around<'g> {
    grid: &'g Grid,
    row: usize,
    at: [usize; 2],
    beside: [[usize; 4]; 2],
}

impl<'g> Around<'g> {
    /// Those around `row`.
    #[inline]
    pub fn new(grid: &'g Grid, row: usize) -> Self {
        let at = grid.row_at(row);
        let along = |axis: usize| {
            let beside = |offset: isize| {
                let to = place(grid, axis, at[axis - 1], offset).unwrap_or(if offset < 0 { 0 } else { grid.n[axis] - 1 });
                row_at(grid, axis, at, to)
            };
            [beside(-2), beside(-1), beside(1), beside(2)]
        };
        Self { grid, row, at, beside: [along(1), along(2)] }
    }

    /// Whether there is a wall on the side of `offset` along y or z.
    #[inline]
    pub fn at_wall(&self, axis: usize, offset: isize) -> bool {
        place(self.grid, axis, self.at[axis - 1], offset).is_none()
    }

    /// Whether `of` holds for the row or for one beside it.
    #[inline]
    pub fn any(&self, of: impl Fn(usize) -> bool) -> bool {
        of(self.row) || self.beside.iter().take(self.grid.dims - 1).flatten().any(|&row| of(row))
    }
}

/// Where an offset from place `at` leads along an axis, or `None` beyond a wall.
#[inline]
fn place(grid: &Grid, axis: usize, at: usize, offset: isize) -> Option<usize> {
    let n = grid.n[axis];
    match at.wrapping_add_signed(offset) {
        to if to < n => Some(to),
        _ if !grid.periodic[axis] => None,
        _ if offset < 0 => Some((at + n).wrapping_add_signed(offset)),
        to => Some(to - n),
    }
}

/// The row at `at` but for one axis, y or z, along which it is at `to`.
#[inline]
fn row_at(grid: &Grid, axis: usize, at: [usize; 2], to: usize) -> usize {
    if axis == 1 { grid.row(to, at[1]) } else { grid.row(at[0], to) }
}

/// The cells of `field` around a row: along x offsets -2 .. 2, which `halo` receives, along y and z offsets -2, -1, 1, 2.
#[inline]
pub fn cells<'a, T: Real>(around: &Around<'_>, field: &'a [T], halo: &'a mut [T]) -> Rows<'a, T> {
    let (n, periodic) = (around.grid.n[0], around.grid.periodic[0]);
    let start = around.row * n;
    let here = &field[start..start + n];
    halo[2..n + 2].copy_from_slice(here);
    for (at, from) in [(0, n - 2), (1, n - 1)] {
        halo[at] = if periodic { here[from] } else { here[0] };
        halo[n + 2 + at] = if periodic { here[at] } else { here[n - 1] };
    }
    let of = |row: usize| &field[row * n..(row + 1) * n];
    let [y, z] = around.beside;
    Rows { x: &halo[..n + 4], beside: [[of(y[0]), of(y[1]), of(y[2]), of(y[3])], [of(z[0]), of(z[1]), of(z[2]), of(z[3])]] }
}

/// The faces -1, 0, 1, 2 around a row, face 0 the low and face 1 the high one of its cells; `halo` receives those along x. Beyond a
/// wall the faces of the low wall stand, which nothing goes through either.
#[inline]
pub fn faces<'a, T: Real>(around: &Around<'_>, v: Vector<'a, T>, halo: &'a mut [T]) -> Rows<'a, T> {
    let grid = around.grid;
    let n = grid.n[0];
    let here = &v[0][around.row * n..(around.row + 1) * n];
    let wrap = |x: T| if grid.periodic[0] { x } else { T::ZERO };
    halo[0] = wrap(here[n - 1]);
    halo[1..=n].copy_from_slice(here);
    halo[n + 1] = wrap(here[0]);
    halo[n + 2] = wrap(here[1]);
    let along = |axis: usize| -> [&'a [T]; 4] {
        if axis >= grid.dims {
            return [&[]; 4];
        }
        let of = |place: usize| {
            let start = row_at(grid, axis, around.at, place) * n;
            &v[axis][start..start + n]
        };
        let at = around.at[axis - 1];
        let beyond = |offset: isize| of(place(grid, axis, at, offset).unwrap_or(0));
        [beyond(-1), of(at), beyond(1), beyond(2)]
    };
    Rows { x: &halo[..n + 3], beside: [along(1), along(2)] }
}
